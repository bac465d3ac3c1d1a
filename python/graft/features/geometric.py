"""The default descriptor: geometric, learning-free, the same for every pose, scale and mirror image."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from graft import _core
from graft.errors import InputError
from graft.objects import Floats, PartObject

Family = Literal["hull", "inertia", "curve", "distributions", "harmonics"]
FAMILIES: tuple[Family, ...] = get_args(Family)
"""Kinds of features, in the order of their columns."""

VERSION = 1
"""Raised whenever vectors of the same options change, so that stored ones are not compared with new ones."""

SAMPLES = (64, 65_536)
"""Fewest and most points that can be sampled on a part."""


@dataclass(frozen=True)
class GeometricDescriptor:
    """Describe each part by its shape alone.

    The families, each invariant to rotation, translation, uniform scale and mirroring:

    * hull: proportions of the convex hull, how full it is, and how deep the surface lies under it;
    * inertia: moments of the surface about its centre, integrated exactly over the triangles;
    * curve: the part as a bent tube, along shortest paths on the surface: how thin, even and flat,
      ring or not, but not how bent;
    * distributions: quantiles of D1, D2, D3 and A3 (Osada et al. 2002);
    * harmonics: energies of spherical harmonics on shells (Kazhdan et al. 2003).

    Each feature is centred and scaled by fixed constants and bent onto an arc: 1 - cosine is a weighted
    mean over the features' differences, between 0 and 2. What a part cannot answer (the volume of a
    point cloud, all about a single point) counts as average.

    Attributes:
        families: Those to use, each once; their order does not matter.
        samples: Points sampled on each part, 64 to 65536.
        seed: Seed of the sampling.
    """

    families: tuple[Family, ...] = FAMILIES
    samples: int = 1024
    seed: int = 0

    def __post_init__(self) -> None:
        chosen = tuple(self.families)
        unknown = [family for family in chosen if family not in FAMILIES]
        if unknown or not chosen or len(set(chosen)) != len(chosen):
            raise InputError(f"families: expected some of {', '.join(FAMILIES)}, each once, got {chosen}")
        object.__setattr__(self, "families", tuple(family for family in FAMILIES if family in chosen))
        for name, low, high in (("samples", *SAMPLES), ("seed", 0, 2**64 - 1)):
            value = getattr(self, name)
            if not isinstance(value, int | np.integer) or isinstance(value, bool) or not low <= value <= high:
                raise InputError(f"{name}: expected an integer from {low} to {high}, got {value!r}")

    @property
    def name(self) -> str:
        """Version and options: "geometric-1/hull+inertia+…/1024/0"."""
        return f"geometric-{VERSION}/{'+'.join(self.families)}/{self.samples}/{self.seed}"

    @property
    def dim(self) -> int:
        """Length of a vector."""
        return _core.descriptor_dim(list(self.families))

    def describe(self, obj: PartObject) -> Floats:
        """Return (n, dim) rows of length 1, one per part.

        Results do not depend on the number of threads, nor on the object's other parts.
        """
        return self._call(obj, raw=False)

    def raw_features(self, obj: PartObject) -> Floats:
        """Return (n, dim / 2) features before standardisation; NaN where a part cannot answer."""
        return self._call(obj, raw=True)

    def _call(self, obj: PartObject, *, raw: bool) -> Floats:
        vertices = [part.vertices for part in obj.parts]
        faces = [part.faces for part in obj.parts]
        return _core.describe_parts(
            np.concatenate(vertices),
            np.concatenate(faces),
            np.cumsum([0, *map(len, vertices)], dtype=np.int64),
            np.cumsum([0, *map(len, faces)], dtype=np.int64),
            families=list(self.families),
            samples=int(self.samples),
            seed=int(self.seed),
            raw=raw,
        )

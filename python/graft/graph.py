"""Part graphs: what is matched.

Every part gets its oriented box of minimal volume, surface samples and a descriptor; every pair of parts
a gap and an edge length. Lengths are compared in shares of the diagonal of the object's minimal oriented box, which,
other than that of its axis-aligned box, does not change when the object is turned.

A box's frame is stated, not found by chance: axes from the longest extent to the shortest, the first two pointing
to the side of the centre on which the centroid of the surface lies, right-handed. What no rule can fix, such as how
far a cylinder's box is turned about its axis, is flagged `SYMMETRIC`.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from graft import _core
from graft.errors import InputError
from graft.features import Descriptor, GeometricDescriptor
from graft.objects import Floats, PartObject, joint_pairs

Structure = Literal["all_pairs", "shortest_path"]
LengthUnit = Literal["diagonal", "metres"]

SAMPLES = 1024
"""Surface samples of each part: about 2 % of a handle's length apart."""

ADJACENCY_GAP = 0.02
"""Boxes closer than this share of the diagonal touch. Parts cut from one surface have boxes that overlap or share
a rim; modelled parts may leave a slit of a few per mille; this leaves room for both."""

DEFAULT_DESCRIPTOR = GeometricDescriptor()
"""Describes parts where nothing else is asked for."""

SALIENCY = 0.6
"""gamma: what a step away from the demonstrated part costs a part's mass (the paper's value)."""


class PartFlag(enum.Flag):
    """What is special about a part's geometry."""

    NONE = 0
    DEGENERATE = enum.auto()
    """Faces without area, or too few points for a box."""
    FLAT = enum.auto()
    """A box extent was raised to the floor thickness."""
    SYMMETRIC = enum.auto()
    """Two box extents agree to 1 %: which axis is which, or how the box is turned, is a convention."""
    CLOUD = enum.auto()
    """Points without faces; area and, where not given, normals are estimated."""


@dataclass(frozen=True, eq=False)
class PartGraph:
    """An object's parts and their relations; n parts, s surface samples of each.

    Attributes:
        object: What it was built from.
        diagonal: Of the object's minimal oriented box, object units; 1 when all points coincide.
        centers: (n, 3) box centres, object frame and units.
        axes: (n, 3, 3) columns are the box axes in the object frame, longest extent first, right-handed.
        half_extents: (n, 3) descending, positive, object units.
        volumes: (n,) box volumes.
        areas: (n,) surface areas, estimated for clouds.
        flags: What is special about each part.
        points: n arrays (s, 3), surface samples, object frame and units; uniform by area.
        normals: n arrays (s, 3), outward unit normals there.
        gaps: (n, n) distances between boxes in shares of the diagonal.
        structure: (n, n) edge lengths in [0, 1), symmetric, zero diagonal.
        adjacency: (n, n) symmetric, connected.
        relations: (n, r) how each part lies in its object, compared by 1 - dot product; rows of length at most 1.
        descriptors: (n, d), or None.
        descriptor_name: Model and version of the descriptor, or None.
    """

    object: PartObject
    diagonal: float
    centers: Floats
    axes: Floats
    half_extents: Floats
    volumes: Floats
    areas: Floats
    flags: tuple[PartFlag, ...]
    points: tuple[Floats, ...]
    normals: tuple[Floats, ...]
    gaps: Floats
    structure: Floats
    adjacency: NDArray[np.bool_]
    relations: Floats
    descriptors: Floats | None
    descriptor_name: str | None

    def __len__(self) -> int:
        return len(self.centers)


def build_graph(
    obj: PartObject,
    *,
    descriptor: Descriptor | None = DEFAULT_DESCRIPTOR,
    samples: int = SAMPLES,
    seed: int = 0,
    structure: Structure = "all_pairs",
    unit: LengthUnit = "diagonal",
    adjacency_gap: float = ADJACENCY_GAP,
) -> PartGraph:
    """Build the part graph of an object.

    Args:
        obj: The object.
        descriptor: Describes the parts; None leaves descriptors out.
        samples: Surface samples of each part.
        seed: Of the samples; the same seed gives the same graph with any number of threads.
        structure: Edge lengths between all pairs, ``l = x / (1 + x)`` with
            ``x = norm(c_i - c_j) + angle(a_i, a_j) / pi``,
            or along the shortest path of adjacent parts.
        unit: What centres' distances are measured in: the object's diagonal, or metres (needs `scale_to_metres`).
        adjacency_gap: Boxes within this share of the diagonal are adjacent, where the object has no joints.

    Raises:
        InputError: An argument is out of range, or the descriptor's answer has the wrong shape or is not
            finite.
    """
    if samples < 1:
        raise InputError(f"samples: expected at least 1, got {samples}")
    if not 0 <= seed < 2**64:
        raise InputError(f"seed: expected 0 <= seed < 2^64, got {seed}")
    if not 0 <= adjacency_gap < np.inf:
        raise InputError(f"adjacency_gap: expected a number of at least 0, got {adjacency_gap}")
    if structure not in ("all_pairs", "shortest_path"):
        raise InputError(f"structure: expected 'all_pairs' or 'shortest_path', got {structure!r}")

    diagonal, boxes, areas, bits, points, normals = _measure(obj, samples, seed)
    gaps = _core.box_gaps(*boxes) / diagonal
    adjacency = _core.part_adjacency(gaps, joint_pairs(obj.joints), adjacency_gap)
    along = adjacency if structure == "shortest_path" else None
    lengths = _core.edge_lengths(*boxes, _length_unit(obj, diagonal, unit), along)
    up = None if obj.up is None else tuple(obj.up.tolist())
    relations = _core.part_relations(*boxes, points, areas, diagonal, up)
    descriptors = None if descriptor is None else _describe(descriptor, obj)
    clouds = [PartFlag.CLOUD if part.is_point_cloud else PartFlag.NONE for part in obj.parts]
    centers, axes, half_extents = boxes
    volumes = 8.0 * half_extents.prod(axis=1)
    for array in (centers, axes, half_extents, volumes, areas, points, normals, gaps, lengths, adjacency, relations):
        array.setflags(write=False)
    return PartGraph(
        object=obj,
        diagonal=diagonal,
        centers=centers,
        axes=axes,
        half_extents=half_extents,
        volumes=volumes,
        areas=areas,
        flags=tuple(PartFlag(int(b)) | cloud for b, cloud in zip(bits, clouds, strict=True)),
        points=tuple(points),
        normals=tuple(normals),
        gaps=gaps,
        structure=lengths,
        adjacency=adjacency,
        relations=relations,
        descriptors=descriptors,
        descriptor_name=None if descriptor is None else descriptor.name,
    )


def source_mass(graph: PartGraph, part: int | str, gamma: float = SALIENCY) -> Floats:
    """Return the masses (n,) of a source's nodes: mu_i ~ gamma^hops(part, i) * V_i, adding up to 1.

    Args:
        graph: The source.
        part: The demonstrated part, as `PartObject.part_index` takes it.
        gamma: In (0, 1]; 1 leaves volumes alone.

    Raises:
        InputError: No such part, or gamma is out of range.
    """
    if not 0 < gamma <= 1:
        raise InputError(f"gamma: expected 0 < gamma <= 1, got {gamma}")
    hops = _core.part_hops(graph.adjacency, graph.object.part_index(part))
    mass: Floats = gamma**hops * _relative_volumes(graph)
    mass /= mass.sum()
    return mass


def target_prior(graph: PartGraph) -> Floats:
    """Return the prior masses (n,) of a target's nodes: delta_j = V_j / sum V."""
    volumes = _relative_volumes(graph)
    volumes /= volumes.sum()
    return volumes


def _relative_volumes(graph: PartGraph) -> Floats:
    """Return (n,) box volumes over the largest, which keeps tiny and huge units in range."""
    volumes: Floats = (graph.half_extents / graph.diagonal).prod(axis=1)
    volumes /= volumes.max()
    return volumes


def _measure(
    obj: PartObject, samples: int, seed: int
) -> tuple[float, tuple[Floats, Floats, Floats], Floats, NDArray[np.uint8], Floats, Floats]:
    """Return diagonal, boxes, areas, flag bits, sampled points and normals of all parts."""
    diagonal, boxes, areas, _, _, bits, points, normals = _core.part_geometry(
        np.concatenate([part.vertices for part in obj.parts]),
        np.concatenate([np.zeros_like(part.vertices) if part.normals is None else part.normals for part in obj.parts]),
        np.array([len(part.vertices) for part in obj.parts], np.int64),
        np.concatenate([part.faces for part in obj.parts]),
        np.array([len(part.faces) for part in obj.parts], np.int64),
        samples,
        seed,
    )
    return diagonal, boxes, areas, bits, points, normals


def _length_unit(obj: PartObject, diagonal: float, unit: LengthUnit) -> float:
    """Return the object units that count as length 1."""
    if unit == "diagonal":
        return diagonal
    if unit != "metres":
        raise InputError(f"unit: expected 'diagonal' or 'metres', got {unit!r}")
    if obj.scale_to_metres is None:
        raise InputError(f"object {obj.name!r}: lengths in metres need scale_to_metres, which is not known")
    return 1.0 / obj.scale_to_metres


def _describe(descriptor: Descriptor, obj: PartObject) -> Floats:
    """Return the checked, read-only descriptors (n, dim)."""
    found = np.ascontiguousarray(descriptor.describe(obj), np.float64)
    expected = (len(obj.parts), descriptor.dim)
    if found.shape != expected:
        raise InputError(f"descriptor {descriptor.name!r}: expected shape {expected}, got {found.shape}")
    if not np.isfinite(found).all():
        row = int(np.argwhere(~np.isfinite(found).all(axis=1))[0, 0])
        raise InputError(f"descriptor {descriptor.name!r}: not finite for part {obj.parts[row].name!r} of {obj.name!r}")
    found.setflags(write=False)
    return found

"""What a category's function returns, and how it becomes an object and a demonstration."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from graft.errors import InputError
from graft.objects import Contact, Demonstration, Floats, Part, PartObject
from graft.zoo.surfaces import Mesh

UP = (0.0, 0.0, 1.0)

SIDE_OF_A_FACE = 0.9
"""Least cosine between a face's normal and the wanted side's direction."""


@dataclass(frozen=True, eq=False)
class Touch:
    """Where a person takes an object: the face of `part` nearest to `near` that looks along `outward`.

    The gripper comes against `outward`.
    """

    part: str
    near: Floats | tuple[float, float, float]
    outward: Floats | tuple[float, float, float]
    task: str


@dataclass(frozen=True, eq=False)
class Design:
    """One variant of a category before it is put on the table.

    Attributes:
        parts: Name to closed mesh, in order.
        graspable: Names of the parts that a person takes to use it.
        touch: The demonstrated place.
        labels: Kinds of the parts whose kind is not their name.
        stands: Whether z is up; else it lies as it is.
    """

    parts: dict[str, Mesh]
    graspable: tuple[str, ...]
    touch: Touch
    labels: dict[str, str] = field(default_factory=dict)
    stands: bool = True

    @property
    def drop(self) -> Floats:
        """(3,) shift that puts the lowest point at z = 0."""
        return np.array([0.0, 0.0, -min(mesh.vertices[:, 2].min() for mesh in self.parts.values())])

    def object(self, name: str, category: str) -> PartObject:
        """Return the variant as an object in metres, its lowest point at z = 0."""
        names = list(self.parts)
        return PartObject(
            name=name,
            parts=tuple(
                Part(key, mesh.vertices + self.drop, mesh.faces, label=self.labels.get(key, key), sweeps=mesh.sweeps)
                for key, mesh in self.parts.items()
            ),
            category=category,
            up=np.array(UP) if self.stands else None,
            scale_to_metres=1.0,
            graspable=tuple(names.index(part) for part in self.graspable),
            source=f"graft.zoo:{name}",
        )

    def demonstration(self, name: str, category: str) -> Demonstration:
        """Return the variant with its demonstrated contact."""
        obj = self.object(name, category)
        contact = contact_on(
            obj, obj.part_index(self.touch.part), np.asarray(self.touch.near) + self.drop, self.touch.outward
        )
        return Demonstration(obj, contact, metadata={"task": self.touch.task, "source": "graft.zoo"})


def contact_on(obj: PartObject, part: int, near: ArrayLike, outward: ArrayLike) -> Contact:
    """Return the contact at the middle of the part's face nearest to `near` on the side towards `outward`.

    Args:
        obj: The object.
        part: Index of a part with faces.
        near: (3,) object frame and units.
        outward: (3,) direction; the gripper approaches against it.

    Raises:
        InputError: No face of the part looks that way.
    """
    mesh = obj.parts[part]
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    away = np.asarray(outward, float) / np.linalg.norm(outward)
    looks = normals @ away > SIDE_OF_A_FACE * areas
    if not looks.any():
        raise InputError(f"object {obj.name!r} part {mesh.name!r}: no face looks along {away.round(3).tolist()}")
    candidates = np.flatnonzero(looks & (areas > 0))
    distance = np.linalg.norm(corners[candidates].mean(axis=1) - np.asarray(near, float), axis=1)
    face = candidates[int(np.argmin(distance))]
    return Contact(corners[face].mean(axis=0), normals[face] / areas[face], part, -away)

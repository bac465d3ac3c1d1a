"""Canonical frames: box-aligned frames of a part, in which the part fills [-1, 1]^3."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from graft.graph import PartGraph
from graft.objects import Floats, Ints

THINNEST = 1e-3
"""A fitted frame is at least this share of the part's least half extent thick: flat parts stay invertible."""


@dataclass(frozen=True, eq=False)
class CanonicalFrame:
    """A box-aligned frame of a part, in which the part fills [-1, 1]^3.

    Attributes:
        rotation: (3, 3) columns are the frame's axes in the object frame.
        center: (3,) the box's centre in the object frame, object units.
        half_extents: (3,) > 0, object units, in the order of the columns.
    """

    rotation: Floats
    center: Floats
    half_extents: Floats

    def to_canonical(self, points: Floats) -> Floats:
        """Map (..., 3) object-frame points to canonical coordinates."""
        mapped: Floats = (points - self.center) @ self.rotation / self.half_extents
        return mapped

    def to_object(self, canonical: Floats) -> Floats:
        """Map (..., 3) canonical coordinates to the object frame."""
        mapped: Floats = (canonical * self.half_extents) @ self.rotation.T + self.center
        return mapped

    def directions(self, normals: Floats) -> Floats:
        """Turn (..., 3) object-frame directions into the frame, without the box's distortion."""
        turned: Floats = normals @ self.rotation
        return turned


@dataclass(frozen=True, eq=False)
class CanonicalFrames:
    """k candidate frames of one part, as arrays.

    Attributes:
        rotations: (k, 3, 3).
        centers: (k, 3).
        half_extents: (k, 3).
    """

    rotations: Floats
    centers: Floats
    half_extents: Floats

    @classmethod
    def of(cls, frames: Sequence[CanonicalFrame]) -> CanonicalFrames:
        """Return several frames as one set."""
        return cls(
            np.stack([f.rotation for f in frames]),
            np.stack([f.center for f in frames]),
            np.stack([f.half_extents for f in frames]),
        )

    @classmethod
    def fitted(cls, points: Floats, rotations: Floats, floor: float) -> CanonicalFrames:
        """Return the frames of given rotations (k, 3, 3) whose boxes bound `points` (p, 3)."""
        turned = points @ rotations
        low, high = turned.min(axis=1), turned.max(axis=1)
        centers = np.einsum("kab,kb->ka", rotations, (low + high) / 2.0)
        return cls(rotations, centers, np.maximum((high - low) / 2.0, floor))

    @classmethod
    def joined(cls, several: Sequence[CanonicalFrames]) -> CanonicalFrames:
        """Return several sets as one, in order."""
        return cls(
            np.concatenate([s.rotations for s in several]),
            np.concatenate([s.centers for s in several]),
            np.concatenate([s.half_extents for s in several]),
        )

    def __getitem__(self, rows: Ints) -> CanonicalFrames:
        return CanonicalFrames(self.rotations[rows], self.centers[rows], self.half_extents[rows])

    def __len__(self) -> int:
        return len(self.rotations)

    def one(self, row: int) -> CanonicalFrame:
        """Return one frame."""
        return CanonicalFrame(self.rotations[row], self.centers[row], self.half_extents[row])

    def permuted(self) -> CanonicalFrames:
        """Return every frame in each of the 24 orders and directions of its axes (24 k frames, frame by frame)."""
        rotations = self.rotations[:, None] @ CUBE_ROTATIONS
        half_extents = self.half_extents[:, None, None] @ np.abs(CUBE_ROTATIONS)
        return CanonicalFrames(
            rotations.reshape(-1, 3, 3),
            np.repeat(self.centers, len(CUBE_ROTATIONS), axis=0),
            half_extents.reshape(-1, 3),
        )

    def to_canonical(self, points: Floats) -> Floats:
        """Map (p, 3) object-frame points to (k, p, 3) canonical coordinates."""
        scaled = self.rotations / self.half_extents[:, None, :]
        mapped: Floats = points @ scaled - self.centers[:, None, :] @ scaled
        return mapped


def _cube_rotations() -> Floats:
    """Return the 24 rotations of a cube (24, 3, 3), those that change the fewest axes first."""
    found = []
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        matrix = np.zeros((3, 3))
        matrix[order, range(3)] = signs
        if np.linalg.det(matrix) > 0:
            changed = sum(matrix[i, i] != 1.0 for i in range(3))
            found.append((changed, order, [-s for s in signs], matrix))
    found.sort(key=lambda row: row[:3])
    return np.array([row[3] for row in found])


CUBE_ROTATIONS = _cube_rotations()


def box_frame(graph: PartGraph, part: int) -> CanonicalFrame:
    """Return the frame of a part's oriented box."""
    return CanonicalFrame(graph.axes[part], graph.centers[part], graph.half_extents[part])


def turns_about(axis: int, angles: Floats) -> Floats:
    """Return rotations (k, 3, 3) by `angles` (k,), radians, about coordinate axis 0, 1 or 2."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turns = np.zeros((len(angles), 3, 3))
    turns[:, axis, axis] = 1.0
    turns[:, first, first] = turns[:, second, second] = np.cos(angles)
    turns[:, second, first] = np.sin(angles)
    turns[:, first, second] = -np.sin(angles)
    return turns

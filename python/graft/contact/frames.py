"""Canonical frames of matched parts.

A part's box gives a frame only up to the box's symmetries: which way each axis points, and which axis is which
when extents tie. A pair of matched parts is therefore aligned by trying every rotation that permutes and flips
box axes (the 24 rotations of a cube), plus, for round parts, turns about their axis that bring the neighbouring
parts to the same side. Each candidate is judged by four cues and the best one wins:

* shape: the symmetric chamfer distance of the two point sets in the canonical box;
* extents: how far the box has to be distorted to carry one onto the other;
* neighbours: whether the other parts, weighted by what the plan says of them, lie on the same sides;
* up: whether the up axes agree, where both objects have one.

Ties are broken by the order in which the candidates are made: fewest axes changed first.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from scipy.spatial import cKDTree

from graft.graph import PartGraph
from graft.objects import Floats

SHAPE_WEIGHT = 1.0
"""Weight of the chamfer distance, in canonical units (the box is 2 wide)."""

EXTENT_WEIGHT = 0.3
"""Weight of the spread of log extent ratios."""

NEIGHBOUR_WEIGHT = 1.0
"""Weight of the neighbours' mean squared direction difference, in [0, 4], scaled to [0, 1]."""

UP_WEIGHT = 1.0
"""Weight of (1 - cos) / 2 between the up axes, in [0, 1]."""

ROUND_TIE = 0.15
"""Two extents of a box within this relative difference make the part round about the third axis."""

TIE_TOLERANCE = 1e-9
"""Scores closer than this are equal; the earlier candidate wins."""

DIRECTION_FLOOR = 0.02
"""An offset shorter than this share of the object's diagonal points nowhere: such a neighbour is concentric."""

CLOUD_SIZE = 128
"""Surface samples of each part that the chamfer distance compares."""


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
class FramePair:
    """The aligned canonical frames of a source part and a target part.

    Attributes:
        source: Frame of the source part.
        target: Frame of the target part: points with equal canonical coordinates correspond.
        score: What the winner scored, lower is better.
        margin: Score of the best candidate that points elsewhere minus `score`; inf when there is none.
    """

    source: CanonicalFrame
    target: CanonicalFrame
    score: float
    margin: float


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


def _fitted(points: Floats, rotation: Floats, floor: float) -> CanonicalFrame:
    """Return the frame of given rotation whose box bounds `points` (p, 3)."""
    turned = points @ rotation
    low, high = turned.min(axis=0), turned.max(axis=0)
    return CanonicalFrame(rotation, rotation @ ((low + high) / 2), np.maximum((high - low) / 2, floor))


def _offsets(graph: PartGraph, part: int) -> Floats:
    """Return (n, 3) the parts' centres seen from `part`, in shares of the diagonal, object frame."""
    offsets: Floats = (graph.centers - graph.centers[part]) / graph.diagonal
    return offsets


def _round_axis(half_extents: Floats) -> int | None:
    """Return the column about which a box is round, or None."""
    ratios = [abs(np.log(half_extents[(k + 1) % 3] / half_extents[(k + 2) % 3])) for k in range(3)]
    axis = int(np.argmin(ratios))
    return axis if ratios[axis] < ROUND_TIE else None


def _companion(graph: PartGraph, part: int) -> Floats:
    """Return (3,) where the rest of the object lies, seen from `part`: the area-weighted mean offset."""
    weights = np.delete(graph.areas, part)
    if not len(weights) or weights.sum() <= 0:
        return np.zeros(3)
    mean: Floats = weights @ np.delete(_offsets(graph, part), part, axis=0) / weights.sum()
    return mean


def _faced(graph: PartGraph, part: int) -> CanonicalFrame:
    """Return the part's frame, turned, when the part is round, so that the other parts lie on an axis."""
    frame = box_frame(graph, part)
    axis = _round_axis(frame.half_extents)
    if axis is None:
        return frame
    toward = _companion(graph, part) @ frame.rotation
    toward[axis] = 0.0
    if np.linalg.norm(toward) < DIRECTION_FLOOR:
        return frame
    first = toward / np.linalg.norm(toward)
    basis = np.zeros((3, 3))
    basis[axis, axis] = 1.0
    basis[:, (axis + 1) % 3] = first
    basis[:, (axis + 2) % 3] = np.cross(basis[:, axis], first)
    return _fitted(graph.points[part], frame.rotation @ basis, float(frame.half_extents.min()) * 1e-3)


def _unit_rows(offsets: Floats) -> Floats:
    """Normalise (..., 3); rows shorter than the floor shrink towards zero and say nothing."""
    length = np.linalg.norm(offsets, axis=-1, keepdims=True)
    rows: Floats = offsets / np.maximum(length, DIRECTION_FLOOR)
    return rows


def align_parts(source: PartGraph, source_part: int, target: PartGraph, target_part: int, plan: Floats) -> FramePair:
    """Align the canonical frames of two matched parts.

    Args:
        source: n parts.
        source_part: Index of the part in the source.
        target: m parts.
        target_part: Index of the part in the target.
        plan: (n, m) transport plan; tells which neighbours correspond.
    """
    frame_s = _faced(source, source_part)
    cloud_s = frame_s.to_canonical(source.points[source_part])
    cloud_s = cloud_s[:: max(1, len(cloud_s) // CLOUD_SIZE)]
    tree_s = cKDTree(cloud_s)

    weights = plan.copy()
    weights[source_part, :] = 0.0
    weights[:, target_part] = 0.0
    total = float(weights.sum())
    seen_s = _unit_rows(_offsets(source, source_part)) @ frame_s.rotation
    rest_s = _unit_rows(_companion(source, source_part)) @ frame_s.rotation
    rest_t = _unit_rows(_companion(target, target_part))
    seen_t = _unit_rows(_offsets(target, target_part))
    ups = source.object.up is not None and target.object.up is not None

    bases = [box_frame(target, target_part)]
    if _round_axis(bases[0].half_extents) is not None:
        bases.insert(0, _faced(target, target_part))

    candidates: list[tuple[float, CanonicalFrame]] = []
    for base in bases:
        points = target.points[target_part]
        points = points[:: max(1, len(points) // CLOUD_SIZE)]
        for turn in CUBE_ROTATIONS:
            frame = CanonicalFrame(base.rotation @ turn, base.center, np.abs(turn).T @ base.half_extents)
            cloud_t = frame.to_canonical(points)
            chamfer = (tree_s.query(cloud_t)[0].mean() + cKDTree(cloud_t).query(cloud_s)[0].mean()) / 2
            score = SHAPE_WEIGHT * float(chamfer)
            ratios = np.log(frame.half_extents / frame_s.half_extents)
            score += EXTENT_WEIGHT * float(ratios.std())
            # What lies where: matched neighbours, and the rest of the object as a whole, in equal parts.
            apart = float(np.square(rest_s - rest_t @ frame.rotation).sum())
            if total > 0:
                turned = seen_t @ frame.rotation
                pairwise = np.square(seen_s[:, None, :] - turned[None, :, :]).sum(axis=-1)
                apart = (apart + float((weights * pairwise).sum()) / total) / 2
            score += NEIGHBOUR_WEIGHT * apart / 4
            if ups:
                cosine = float((source.object.up @ frame_s.rotation) @ (target.object.up @ frame.rotation))
                score += UP_WEIGHT * (1 - cosine) / 2
            candidates.append((score, frame))

    best = 0
    for index, (score, _) in enumerate(candidates):
        if score < candidates[best][0] - TIE_TOLERANCE:
            best = index
    score, frame = candidates[best]
    others = [s for s, f in candidates if np.trace(f.rotation.T @ frame.rotation) < 1.0 + np.sqrt(2.0)]
    return FramePair(frame_s, frame, score, min(others, default=float("inf")) - score)

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

ELSEWHERE = float(np.cos(np.deg2rad(45)))
"""Frames that differ by a turn whose cosine is below this point elsewhere; they set the margin."""

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
    bases = [box_frame(target, target_part)]
    if _round_axis(bases[0].half_extents) is not None:
        bases.insert(0, _faced(target, target_part))
    cues = _SourceCues.of(source, source_part, target_part, frame_s, plan)
    scores = np.concatenate([cues.scores(target, target_part, base) for base in bases])
    rotations = np.concatenate([base.rotation @ CUBE_ROTATIONS for base in bases])

    best = int(np.argmax(scores <= scores.min() + TIE_TOLERANCE))
    base, turn = bases[best // len(CUBE_ROTATIONS)], CUBE_ROTATIONS[best % len(CUBE_ROTATIONS)]
    frame = CanonicalFrame(rotations[best], base.center, base.half_extents @ np.abs(turn))
    cosines = (np.einsum("kij,ij->k", rotations, frame.rotation) - 1.0) / 2.0
    elsewhere = scores[cosines < ELSEWHERE]
    margin = float(elsewhere.min() - scores[best]) if len(elsewhere) else float("inf")
    return FramePair(frame_s, frame, float(scores[best]), margin)


@dataclass(frozen=True, eq=False)
class _SourceCues:
    """What the candidates are judged by: the source part's cloud, its neighbours and its up axis, in its frame."""

    half_extents: Floats
    cloud: Floats
    seen: Floats
    rest: Floats
    up: Floats | None
    weights: Floats

    @classmethod
    def of(cls, graph: PartGraph, part: int, target_part: int, frame: CanonicalFrame, plan: Floats) -> _SourceCues:
        weights = plan.copy()
        weights[part, :] = 0.0
        weights[:, target_part] = 0.0
        return cls(
            half_extents=frame.half_extents,
            cloud=frame.to_canonical(_thinned(graph.points[part])),
            seen=_unit_rows(_offsets(graph, part)) @ frame.rotation,
            rest=_unit_rows(_companion(graph, part)) @ frame.rotation,
            up=None if graph.object.up is None else graph.object.up @ frame.rotation,
            weights=weights / max(float(weights.sum()), np.finfo(np.float64).tiny),
        )

    def scores(self, target: PartGraph, part: int, base: CanonicalFrame) -> Floats:
        """Return (24,) the score of `base` turned by each of the cube's rotations, lower is better."""
        cloud = base.to_canonical(_thinned(target.points[part])) @ CUBE_ROTATIONS
        scores = SHAPE_WEIGHT * _chamfer(self.cloud, cloud)
        half_extents = base.half_extents @ np.abs(CUBE_ROTATIONS)
        scores += EXTENT_WEIGHT * np.log(half_extents / self.half_extents).std(axis=1)

        # What lies where: matched neighbours, and the rest of the object as a whole, in equal parts.
        rest = _unit_rows(_companion(target, part)) @ base.rotation @ CUBE_ROTATIONS
        apart = np.square(self.rest - rest).sum(axis=1)
        if self.weights.any():
            seen = _unit_rows(_offsets(target, part)) @ base.rotation
            squares = self.weights.sum(axis=1) @ np.square(self.seen).sum(axis=1)
            squares += self.weights.sum(axis=0) @ np.square(seen).sum(axis=1)
            agreement = np.einsum("ij,ia,jb,kba->k", self.weights, self.seen, seen, CUBE_ROTATIONS, optimize=True)
            apart = (apart + squares - 2.0 * agreement) / 2.0
        scores += NEIGHBOUR_WEIGHT * apart / 4.0

        if self.up is not None and target.object.up is not None:
            up = target.object.up @ base.rotation @ CUBE_ROTATIONS
            scores += UP_WEIGHT * (1.0 - up @ self.up) / 2.0
        return scores


def _thinned(points: Floats) -> Floats:
    """Return every so many of the samples, at least `CLOUD_SIZE` where there are as many."""
    return points[:: max(1, len(points) // CLOUD_SIZE)]


def _chamfer(cloud: Floats, candidates: Floats) -> Floats:
    """Return (k,) the mean nearest distances, both ways, between cloud (a, 3) and each of (k, b, 3)."""
    squares = np.square(cloud).sum(axis=1)[:, None] + np.square(candidates).sum(axis=2)[:, None, :]
    squares -= 2.0 * (cloud @ candidates.transpose(0, 2, 1))
    distance = np.sqrt(np.maximum(squares, 0.0))
    mean: Floats = (distance.min(axis=2).mean(axis=1) + distance.min(axis=1).mean(axis=1)) / 2.0
    return mean

"""What candidate frames of a target part are judged by, given the frame of the source part.

* extents: how far the box has to be distorted to carry one part onto the other;
* neighbours: whether the other parts, weighted by what the plan says of them, lie on the same sides;
* up: whether the up axes agree, where both objects have one;
* outlook: where a contact is given, whether it looks at as much of the object as the demonstrated one does: the
  outer side of a bar looks away from the object, the inner side looks at it;
* shape: the chamfer distance of the two parts in the canonical box;
* surroundings: the chamfer distance of everything else the objects show, seen from the part. It is what tells
  how a bucket is turned, whose handle is centred over it.

The first four are closed forms in the rotation (`Cues.quick`); distances are dear and never negative, so the search
in `graft.contact.frames` asks for them (`Cues.dear`) only where the first four leave a candidate in the running.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from graft._core import chamfer_distances
from graft.contact.canonical import CanonicalFrame, CanonicalFrames
from graft.graph import PartGraph
from graft.objects import Floats

SHAPE_WEIGHT = 1.0
"""Weight of the chamfer distance, in canonical units (the box is 2 wide)."""

SURROUNDINGS_WEIGHT = 1.0
"""Weight of the surroundings' chamfer distance, in shares of the diagonal."""

EXTENT_WEIGHT = 0.3
"""Weight of the spread of log extent ratios."""

NEIGHBOUR_WEIGHT = 1.0
"""Weight of the neighbours' mean squared direction difference, in [0, 4], scaled to [0, 1]."""

UP_WEIGHT = 1.0
"""Weight of (1 - cos) / 2 between the up axes, in [0, 1]."""

OUTLOOK_WEIGHT = 1.0
"""Weight of the difference of the outlooks, each in [0, 1]."""

OUTLOOK = float(np.cos(np.deg2rad(45)))
"""A contact looks at what lies within this cosine of its normal."""

DIRECTION_FLOOR = 0.1
"""An offset shorter than this share of the object's diagonal says less the shorter it is: the screen of a phone is
concentric with its body, and where its centre lies to a hundredth of the phone must not decide which way it is held."""

CLOUD_SIZE = 96
"""Surface samples of the part, and of all other parts together, that the chamfer distances compare."""


@dataclass(frozen=True, eq=False)
class View:
    """What one object shows of itself from one of its parts, in the object's frame.

    Attributes:
        center: (3,) of the part's box, object units.
        diagonal: Of the object, object units.
        cloud: (a, 3) samples of the part, object units.
        surroundings: (b, 3) samples of the other parts from the part's centre, in shares of the diagonal; b may be 0.
        seen: (n, 3) directions of all parts' centres; shorter than 1 when nearly concentric, 0 for the part itself.
        rest: (3,) direction of the area-weighted mean of the other parts' centres, likewise.
        up: (3,) or None.
        other_cloud: (a, 3) other samples of the part.
        other_surroundings: (b, 3) other samples of the other parts.
    """

    center: Floats
    diagonal: float
    cloud: Floats
    surroundings: Floats
    seen: Floats
    rest: Floats
    up: Floats | None
    other_cloud: Floats
    other_surroundings: Floats

    @classmethod
    def of(cls, graph: PartGraph, part: int) -> View:
        """Return the view that a graph's object offers from `part`."""
        offsets = (graph.centers - graph.centers[part]) / graph.diagonal
        others = [i for i in range(len(graph)) if i != part]
        each = -(-CLOUD_SIZE // max(1, len(others)))
        cloud, other_cloud = _draws(graph.points[part], CLOUD_SIZE)
        around = [_draws(graph.points[i] - graph.centers[part], each) for i in others]
        nothing = [(np.zeros((0, 3)), np.zeros((0, 3)))]
        surroundings = [np.concatenate(draw) / graph.diagonal for draw in zip(*(around or nothing), strict=True)]
        return cls(
            center=graph.centers[part],
            diagonal=graph.diagonal,
            cloud=cloud,
            surroundings=surroundings[0],
            seen=_unit_rows(offsets),
            rest=_unit_rows(companion(graph, part)),
            up=graph.object.up,
            other_cloud=other_cloud,
            other_surroundings=surroundings[1],
        )

    def outlook(self, points: Floats, normals: Floats) -> Floats:
        """Return (k,) the share of the surroundings that points (k, 3) with normals (k, 3) look at, object frame.

        0 where there are no surroundings.
        """
        if not len(self.surroundings):
            return np.zeros(len(points))
        places = (points - self.center) / self.diagonal
        ahead = normals @ self.surroundings.T - (normals * places).sum(axis=1)[:, None]
        squares = np.square(self.surroundings).sum(axis=1) - 2.0 * (places @ self.surroundings.T)
        squares += np.square(places).sum(axis=1)[:, None]
        share: Floats = ((ahead > 0.0) & (np.square(ahead) > OUTLOOK**2 * squares)).mean(axis=1)
        return share

    def within(self, frame: CanonicalFrame) -> View:
        """Return the view with its cloud in canonical coordinates and its directions along the frame's axes."""
        return replace(
            self,
            cloud=frame.to_canonical(self.cloud),
            surroundings=frame.directions(self.surroundings),
            seen=frame.directions(self.seen),
            rest=frame.directions(self.rest),
            up=None if self.up is None else frame.directions(self.up),
            other_cloud=frame.to_canonical(self.other_cloud),
            other_surroundings=frame.directions(self.other_surroundings),
        )


@dataclass(frozen=True, eq=False)
class Spot:
    """A demonstrated contact in the source part's canonical frame.

    Attributes:
        place: (3,) canonical coordinates.
        facing: (3,) outward unit normal along the frame's axes.
        outlook: Share of the surroundings that it looks at.
    """

    place: Floats
    facing: Floats
    outlook: float


@dataclass(frozen=True, eq=False)
class Cues:
    """The cues for frames of one target part; `source` is given in the source part's canonical frame.

    Attributes:
        half_extents: (3,) of the source part's frame.
        source: The source's view; its cloud in canonical coordinates, its directions along the frame's axes.
        target: The target's view, in the target's object frame.
        weights: (n, m) the plan without the two parts, adding up to 1, or all 0.
        spot: The demonstrated contact, or None.
    """

    half_extents: Floats
    source: View
    target: View
    weights: Floats
    spot: Spot | None

    def quick(self, frames: CanonicalFrames) -> Floats:
        """Return (k,) the score of k target frames by extents, neighbours, up and outlook."""
        rotations = frames.rotations
        scores: Floats = EXTENT_WEIGHT * np.log(frames.half_extents / self.half_extents).std(axis=1)
        # What lies where: matched neighbours, and the rest of the object as a whole, in equal parts.
        apart = np.square(self.source.rest - self.target.rest @ rotations).sum(axis=1)
        if self.weights.any():
            squares = self.weights.sum(axis=1) @ np.square(self.source.seen).sum(axis=1)
            squares += self.weights.sum(axis=0) @ np.square(self.target.seen).sum(axis=1)
            agreement = self.source.seen.T @ self.weights @ self.target.seen
            apart = (apart + squares - 2.0 * np.einsum("ab,kba->k", agreement, rotations)) / 2.0
        scores += NEIGHBOUR_WEIGHT * apart / 4.0
        if self.source.up is not None and self.target.up is not None:
            scores += UP_WEIGHT * (1.0 - self.target.up @ rotations @ self.source.up) / 2.0
        if self.spot is not None:
            points = frames.centers + np.einsum("kab,kb->ka", rotations, frames.half_extents * self.spot.place)
            outlook = self.target.outlook(points, rotations @ self.spot.facing)
            scores += OUTLOOK_WEIGHT * np.abs(outlook - self.spot.outlook)
        return scores

    def dear(self, frames: CanonicalFrames) -> Floats:
        """Return (k,) the score of k target frames by shape and surroundings."""
        scores = SHAPE_WEIGHT * chamfer_distances(self.source.cloud, frames.to_canonical(self.target.cloud))
        if len(self.source.surroundings) and len(self.target.surroundings):
            around = self.target.surroundings @ frames.rotations
            scores += SURROUNDINGS_WEIGHT * chamfer_distances(self.source.surroundings, around)
        return scores

    def noise(self) -> float:
        """Return the score by distances of the source against another draw of its own samples.

        No score below this is evidence: samples that coincide, as those of an object and its copy do, make every
        other frame look worse than it is.
        """
        source = self.source
        noise = SHAPE_WEIGHT * chamfer_distances(source.cloud, source.other_cloud[None])
        if len(source.surroundings):
            noise += SURROUNDINGS_WEIGHT * chamfer_distances(source.surroundings, source.other_surroundings[None])
        return float(noise[0])

    def scores(self, frames: CanonicalFrames) -> Floats:
        """Return (k,) the whole score of k target frames, lower is better."""
        total: Floats = self.quick(frames) + self.dear(frames)
        return total

    def closest_turn(self, frame: CanonicalFrame) -> Floats:
        """Return the rotation (3, 3) of `frame` after one step of iterative closest points in which only it moves.

        Nearest points are paired both ways, the part's in the canonical box, the surroundings' in shares of the
        diagonal; the rotation that brings the pairs together in the least squares is the orthogonal factor of their
        correlation (Arun, Huang, Blostein 1987).
        """
        cloud = (self.target.cloud - frame.center) @ frame.rotation
        correlation = SHAPE_WEIGHT * _pairs(
            self.source.cloud, cloud / frame.half_extents, self.source.cloud * self.half_extents, cloud
        )
        if len(self.source.surroundings) and len(self.target.surroundings):
            around = self.target.surroundings @ frame.rotation
            correlation += SURROUNDINGS_WEIGHT * _pairs(
                self.source.surroundings, around, self.source.surroundings, around
            )
        left, _, right = np.linalg.svd(correlation)
        sign = np.array([1.0, 1.0, np.linalg.det(left @ right)])
        turn: Floats = frame.rotation @ (right.T * sign) @ left.T
        return turn


def companion(graph: PartGraph, part: int) -> Floats:
    """Return (3,) where the rest of the object lies, seen from `part`: the area-weighted mean offset / diagonal."""
    weights = graph.areas.copy()
    weights[part] = 0.0
    total = float(weights.sum())
    if total <= 0:
        return np.zeros(3)
    mean: Floats = (weights @ graph.centers / total - graph.centers[part]) / graph.diagonal
    return mean


def _unit_rows(offsets: Floats) -> Floats:
    """Normalise (..., 3); rows shorter than the floor shrink towards zero and say nothing."""
    length = np.linalg.norm(offsets, axis=-1, keepdims=True)
    rows: Floats = offsets / np.maximum(length, DIRECTION_FLOOR)
    return rows


def _draws(points: Floats, size: int) -> tuple[Floats, Floats]:
    """Return twice `size` of the samples, evenly spread over their order; the same ones where there are few."""
    first = np.arange(min(size, len(points))) * len(points) // min(size, len(points))
    step = max(1, len(points) // size)
    return points[first], points[np.minimum(first + step // 2, len(points) - 1)]


def _pairs(cloud: Floats, other: Floats, values: Floats, others: Floats) -> Floats:
    """Return (3, 3) the correlation of `values` (a, 3) with `others` (b, 3), paired by nearest points both ways.

    Nearness is between cloud (a, 3) and other (b, 3). Each set of values counts as of unit size.
    """
    squares = np.square(other).sum(axis=1) - 2.0 * (cloud @ other.T) + np.square(cloud).sum(axis=1)[:, None]
    there, back = squares.argmin(axis=1), squares.argmin(axis=0)
    correlation = values.T @ others[there] / len(values) + values[back].T @ others / len(others)
    size = np.sqrt(np.square(values).sum(axis=1).mean() * np.square(others).sum(axis=1).mean())
    scaled: Floats = correlation / max(float(size), np.finfo(np.float64).tiny)
    return scaled

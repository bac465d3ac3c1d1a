"""Where a predicted contact lies against where a person takes the object: ASR, NSS, DTM. Numpy only.

The truth is a mask on the target's surface: its graspable parts. For one predicted point p

* inside: the surface nearest to p is graspable. ASR is the mean of it;
* distance: from p to the nearest graspable point, over the object's diagonal, 0 inside. DTM is its mean;
* NSS: (w(p) - mean w) / std w, where w is the mask blurred on the surface by a Gaussian of standard deviation
  `BLUR` of the diagonal, and mean and deviation are taken over the surface's area.

The blur is Euclidean, normalised by the kernel's mass: w(p) = sum a_q K(|p-q|) m(q) / sum a_q K(|p-q|).
A geodesic one needs one connected surface; objects made of a watertight mesh per part, point clouds and
scans with holes are none. At a fiftieth of the diagonal the two differ only where sheets of different parts
run closer than that, and there (the mask shines through a thin wall) by no more than the mask is uncertain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graft.errors import InputError
from graft.objects import Floats, Ints, Part, PartObject

BLUR = 0.02
"""Standard deviation of the blur in shares of the diagonal."""

REACH = 5.0
"""The kernel is cut off at so many standard deviations, where it has fallen to 4e-6."""

SURFACE_POINTS = 4096
"""Points that stand for the surface: about ten under the kernel on an object as compact as a sphere."""

TIE = 1e-6
"""Distances closer than this share of the diagonal are equal; a tie of mask and rest is inside."""

BLOCK = 256
"""Points smoothed at a time; bounds the memory of the blur."""


@dataclass(frozen=True, eq=False)
class Surface:
    """Points that stand for an object's surface.

    Attributes:
        points: (s, 3) object frame and units.
        weights: (s,) share of the surface's area that each stands for; they sum to one.
        part: (s,) index of the part each lies on.
    """

    points: Floats
    weights: Floats
    part: Ints


def sample_surface(obj: PartObject, count: int = SURFACE_POINTS, seed: int = 0) -> Surface:
    """Return points spread over the surface of `obj` by area.

    Faces are drawn systematically (one uniform offset, equal steps of area), so that every part gets its
    share to within one point. The points of a cloud are taken as they are, each with the same weight.

    Raises:
        InputError: Some parts have faces and others are clouds, or no face has any area.
    """
    clouds = [part.is_point_cloud for part in obj.parts]
    if all(clouds):
        owner = np.repeat(np.arange(len(obj.parts)), [len(part.vertices) for part in obj.parts])
        points = np.concatenate([part.vertices for part in obj.parts])
        return Surface(points, np.full(len(points), 1.0 / len(points)), owner)
    if any(clouds):
        raise InputError(f"object {obj.name!r}: expected meshes only or point clouds only, got both")
    triangles = np.concatenate([part.vertices[part.faces] for part in obj.parts])
    owner = np.repeat(np.arange(len(obj.parts)), [len(part.faces) for part in obj.parts])
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    covered = np.cumsum(np.linalg.norm(np.cross(first, second), axis=1))
    if not covered[-1] > 0:
        raise InputError(f"object {obj.name!r}: expected a surface, got no face with an area")
    rng = np.random.default_rng(seed)
    steps = (np.arange(count) + rng.random()) / count * covered[-1]
    face = np.minimum(np.searchsorted(covered, steps, side="right"), len(covered) - 1)
    # Uniform on a triangle: fold the unit square over its diagonal.
    u, v = rng.random((2, count))
    fold = u + v > 1.0
    u, v = np.where(fold, 1.0 - u, u)[:, None], np.where(fold, 1.0 - v, v)[:, None]
    points = triangles[face, 0] + u * first[face] + v * second[face]
    return Surface(points, np.full(count, 1.0 / count), owner[face])


def blur(surface: Surface, values: Floats, sigma: float, places: Floats | None = None) -> Floats:
    """Smooth values given on surface points with a normalised Gaussian.

    Args:
        surface: s points with weights.
        values: (s,) what is smoothed.
        sigma: Standard deviation, object units.
        places: (q, 3) where the result is wanted; the surface's own points by default. A place with no point
            within reach takes the value of the nearest.

    Returns:
        (q,) smoothed values, between the least and the greatest of `values`.
    """
    places = surface.points if places is None else places
    # Sorted along the longest side, the points within reach of a block of places are one slice.
    axis = int(np.argmax(np.ptp(surface.points, axis=0)))
    order = np.argsort(surface.points[:, axis], kind="stable")
    points, mass = surface.points[order], surface.weights[order]
    weighted = mass * values[order]
    result = np.empty(len(places))
    queue = np.argsort(places[:, axis], kind="stable")
    for start in range(0, len(places), BLOCK):
        rows = queue[start : start + BLOCK]
        near = places[rows]
        low, high = near[0, axis] - REACH * sigma, near[-1, axis] + REACH * sigma
        window = slice(*np.searchsorted(points[:, axis], (low, high)))
        squares = _squared_distances(near, points[window])
        kernel = np.where(squares <= (REACH * sigma) ** 2, np.exp(squares / (-2.0 * sigma**2)), 0.0)
        total = kernel @ mass[window]
        lonely = total <= 0
        result[rows] = kernel @ weighted[window] / np.where(lonely, 1.0, total)
        for row in rows[lonely]:
            result[row] = values[order][np.argmin(np.square(points - places[row]).sum(axis=1))]
    return result


def _squared_distances(a: Floats, b: Floats) -> Floats:
    """Return (p, q) squared distances between (p, 3) and (q, 3)."""
    squares = np.zeros((len(a), len(b)))
    for axis in range(3):
        squares += np.square(a[:, None, axis] - b[None, :, axis])
    return squares


@dataclass(frozen=True, eq=False)
class PartSurface:
    """One part's surface, ready to be asked for distances.

    Attributes:
        triangles: (t, 3, 3) corners; a cloud's points are triangles of no extent.
        centers: (t, 3) their centroids.
        radii: (t,) about the centroid; the triangle lies within.
    """

    triangles: Floats
    centers: Floats
    radii: Floats

    @classmethod
    def of(cls, part: Part) -> PartSurface:
        """Gather the triangles of a part, or the points of a cloud."""
        corners = np.arange(len(part.vertices))[:, None].repeat(3, 1) if part.is_point_cloud else part.faces
        triangles = part.vertices[corners]
        centers = triangles.mean(axis=1)
        radii = np.sqrt(np.square(triangles - centers[:, None]).sum(axis=2).max(axis=1))
        return cls(triangles, centers, radii)

    def distance(self, point: Floats) -> float:
        """Return the exact distance from `point` (3,) to the surface, object units."""
        away = np.sqrt(np.square(self.centers - point).sum(axis=1))
        # A triangle reaches its centroid, so one that stays beyond the nearest centroid cannot be nearest.
        near = self.triangles[away - self.radii <= away.min()]
        edges = np.roll(near, -1, axis=1) - near
        offset = point - near
        length = np.square(edges).sum(axis=2)
        along = np.clip((offset * edges).sum(axis=2) / np.where(length > 0, length, 1.0), 0.0, 1.0)
        best = float(np.square(offset - along[..., None] * edges).sum(axis=2).min())
        normal = np.cross(edges[:, 0], -edges[:, 2])
        area = np.square(normal).sum(axis=1)
        # Over a triangle's inside its plane is nearer than any edge.
        over = (np.einsum("ti,tki->tk", normal, np.cross(edges, offset)) >= 0).all(axis=1) & (area > 0)
        if over.any():
            height = (offset[over, 0] * normal[over]).sum(axis=1) ** 2 / area[over]
            best = min(best, float(height.min()))
        return float(np.sqrt(best))


@dataclass(frozen=True, eq=False)
class Measures:
    """What the metrics say of k predicted points.

    Attributes:
        inside: (k,) whether each lies in the mask; its mean is the ASR.
        nss: (k,) normalised scanpath saliency of each.
        distance: (k,) to the mask over the diagonal; its mean is the DTM.
    """

    inside: NDArray[np.bool_]
    nss: Floats
    distance: Floats


@dataclass(frozen=True, eq=False)
class GraspableMask:
    """The truth about one object, ready to measure predictions.

    Attributes:
        object: With `graspable` parts.
        diagonal: Of its box, object units.
        parts: (n) their surfaces.
        surface: Points that stand for all of them.
        mask: (s,) 1 on graspable parts, 0 elsewhere.
        mean: Of the blurred mask over the surface.
        deviation: Its standard deviation; 0 when everything is graspable.
    """

    object: PartObject
    diagonal: float
    parts: tuple[PartSurface, ...]
    surface: Surface
    mask: Floats
    mean: float
    deviation: float

    @classmethod
    def of(cls, obj: PartObject, diagonal: float, *, count: int = SURFACE_POINTS, seed: int = 0) -> GraspableMask:
        """Blur the mask of `obj`.

        Raises:
            InputError: The object says of no part that it is graspable, or has no surface.
        """
        if not obj.graspable:
            raise InputError(f"object {obj.name!r} graspable: expected at least one part, got none")
        surface = sample_surface(obj, count, seed)
        mask = np.isin(surface.part, obj.graspable).astype(np.float64)
        smooth = blur(surface, mask, BLUR * diagonal)
        mean = float(surface.weights @ smooth)
        deviation = float(np.sqrt(surface.weights @ np.square(smooth - mean)))
        parts = tuple(PartSurface.of(part) for part in obj.parts)
        return cls(obj, diagonal, parts, surface, mask, mean, deviation)

    def measure(self, points: Floats) -> Measures:
        """Measure predicted points (k, 3), object frame and units.

        Where the whole surface is graspable every place is as good as any other, and NSS is 0.
        """
        parts = np.array([[part.distance(point) for part in self.parts] for point in points])
        distance = parts[:, list(self.object.graspable)].min(axis=1) / self.diagonal
        inside = distance <= parts.min(axis=1) / self.diagonal + TIE
        saliency = blur(self.surface, self.mask, BLUR * self.diagonal, points)
        nss = (saliency - self.mean) / self.deviation if self.deviation > TIE else np.zeros(len(points))
        return Measures(inside, nss, np.where(inside, 0.0, distance))

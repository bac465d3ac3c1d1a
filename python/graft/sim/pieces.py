"""Convex pieces: what an object collides with. Metres, object frame.

Parts that know how they are swept (the zoo's) are cut along their sweeps; convex parts are their hull; the rest is
decomposed by CoACD (`graft.sim.decompose`).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from graft import _core
from graft.objects import Floats, Ints, Part, PartObject
from graft.sim.decompose import DecompositionConfig, decompose

FLAT = 1e-11
"""Volume in cubic metres below which a piece is flat and left out: a box of a fifth of a millimetre."""

CONCAVITY = 0.0015
"""A part whose surface nowhere lies deeper than this under its hull, metres, is its hull."""

SWEEP_TOLERANCE = 0.0006
"""How deep, metres, the surface of a swept part may lie under a piece ..."""

SWEEP_TOLERANCE_SHARE = 1 / 400
"""... or this share of the part's diagonal, if that is more: a basket's weave needs no pieces of its own."""

CLOSED_DIGITS = 9
"""Vertices equal to this many digits of a metre are one when we ask whether a surface is closed."""


def collision_pieces(
    obj: PartObject, config: DecompositionConfig | None = None, *, cache: Path | None = None
) -> tuple[Floats, ...]:
    """Return the convex pieces of an object, the parts' one after the other.

    Args:
        obj: In metres (`graft.grasp.in_metres`).
        config: How concave parts are cut.
        cache: Folder of decompositions; the user's cache folder when None.

    Returns:
        (v, 3) corners of each piece, metres; empty when the object has no volume.

    Raises:
        MissingExtraError: A concave part is to be cut and coacd is not installed.
    """
    pieces: list[Floats] = []
    for part in obj.parts:
        pieces += _part_pieces(part, config or DecompositionConfig(), cache)
    return tuple(pieces)


def _part_pieces(part: Part, config: DecompositionConfig, cache: Path | None) -> list[Floats]:
    if part.sweeps:
        swept = [piece for sweep in part.sweeps for piece in _sweep_pieces(part.vertices, sweep)]
        return [hull for piece in swept if (hull := hull_corners(piece)) is not None]
    hull = hull_corners(part.vertices)
    if hull is None:
        return []
    if part.is_point_cloud or _depth_under_hull(part.vertices[np.unique(part.faces)], hull) <= CONCAVITY:
        return [hull]
    cut = decompose(part.vertices, part.faces, config, cache=cache, what=part.name)
    return [corners for piece in cut if (corners := hull_corners(piece)) is not None]


def hull_corners(points: Floats) -> Floats | None:
    """Return the corners (v, 3) of the convex hull of points (p, 3), or None when it is flat."""
    corners, faces = _core.convex_hull(np.ascontiguousarray(points))
    if len(faces) == 0:
        return None
    a, b, c = (corners[faces[:, i]] - corners[0] for i in range(3))
    volume = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0
    return corners if volume > FLAT else None


def _depth_under_hull(points: Floats, corners: Floats) -> float:
    """Return how deep the deepest of `points` (p, 3) lies under the faces of the hull of `corners`."""
    try:
        planes = ConvexHull(corners).equations
    except QhullError:
        return 0.0
    planes = np.unique(planes.round(12), axis=0)
    depths = [float((-(block @ planes[:, :3].T + planes[:, 3])).min(axis=1).max()) for block in _blocks(points)]
    return max(depths)


def _blocks(points: Floats) -> list[Floats]:
    return [points[i : i + 2048] for i in range(0, len(points), 2048)]


def _sweep_pieces(vertices: Floats, sweep: Ints) -> list[Floats]:
    """Return the points of each piece of a sweep (k, m): as many loops as are convex to the tolerance."""
    tolerance = max(SWEEP_TOLERANCE, SWEEP_TOLERANCE_SHARE * float(np.linalg.norm(np.ptp(vertices, axis=0))))
    loops = vertices[sweep]
    middles = loops.mean(axis=1)
    pieces = []
    start = 0
    while start < len(loops) - 1:
        end = start + 1
        while end + 1 < len(loops) and _bulge(loops, middles, start, end + 1) <= tolerance:
            end += 1
        pieces.append(loops[start : end + 1].reshape(-1, 3))
        start = end
    return pieces


def _bulge(loops: Floats, middles: Floats, start: int, end: int) -> float:
    """Return how far chords from loop `end` back to loops from `start` on run outside the loops between them.

    A hull contains the chords; where a chord runs further from a loop's middle than the loop itself, the hull bulges
    over the surface by the distance.
    """
    first, between = np.triu_indices(end - start, k=1)
    if len(first) == 0:
        return 0.0
    a, v, b = loops[start + first], loops[start + between], loops[end]
    chord = b - a
    length2 = np.maximum(np.einsum("ijk,ijk->ij", chord, chord), 1e-18)
    along = np.clip(np.einsum("ijk,ijk->ij", v - a, chord) / length2, 0.0, 1.0)
    nearest = a + along[..., None] * chord
    outward = v - middles[start + between][:, None]
    outward /= np.maximum(np.linalg.norm(outward, axis=2, keepdims=True), 1e-12)
    return float(np.einsum("ijk,ijk->ij", nearest - v, outward).max())


def mass_properties(obj: PartObject, pieces: tuple[Floats, ...]) -> tuple[float, Floats, Floats]:
    """Return volume, centre of mass (3,) and inertia (3, 3) about it, both of unit mass; uniform density.

    A closed surface is integrated exactly (signed tetrahedra); an open one says nothing of what it encloses, so the
    collision pieces are taken instead. The same integral over either: an object's parts may overlap a little.
    """
    vertices, faces = _merged(obj)
    if not (len(faces) and _is_closed(vertices, faces)):
        hulls = [_core.convex_hull(np.ascontiguousarray(piece)) for piece in pieces]
        starts = np.cumsum([0, *(len(v) for v, _ in hulls)])
        vertices = np.vstack([v for v, _ in hulls])
        faces = np.vstack([f + start for (_, f), start in zip(hulls, starts[:-1], strict=True)])
    middle = vertices.mean(axis=0)
    a, b, c = (vertices[faces[:, i]] - middle for i in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    volume = float(volumes.sum())
    if volume <= FLAT:
        return volume, middle, np.zeros((3, 3))
    center = np.einsum("i,ij->j", volumes, a + b + c) / (4.0 * volume)
    # Second moments of a tetrahedron with one corner at the origin: V/20 (sum of corners' squares + square of the sum).
    total = a + b + c
    second = sum(np.einsum("i,ij,ik->jk", volumes, x, x) for x in (a, b, c, total)) / (20.0 * volume)
    second = second - np.outer(center, center)
    inertia: Floats = np.trace(second) * np.eye(3) - second
    return volume, middle + center, inertia


def _merged(obj: PartObject) -> tuple[Floats, Ints]:
    starts = np.cumsum([0, *(len(part.vertices) for part in obj.parts)])
    vertices = np.vstack([part.vertices for part in obj.parts])
    faces = np.vstack([part.faces + start for part, start in zip(obj.parts, starts[:-1], strict=True)])
    return vertices, faces


def _is_closed(vertices: Floats, faces: Ints) -> bool:
    """Whether every edge is walked as often in one direction as in the other, so that the volume has no hole."""
    _, same = np.unique(vertices.round(CLOSED_DIGITS), axis=0, return_inverse=True)
    corners = same.reshape(-1)[faces]
    edges = np.vstack([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    edges = edges[edges[:, 0] != edges[:, 1]]
    count = len(vertices)
    ahead = np.sort(edges[:, 0] * count + edges[:, 1])
    back = np.sort(edges[:, 1] * count + edges[:, 0])
    return bool((ahead == back).all())

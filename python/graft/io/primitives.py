"""Triangle meshes of the primitive shapes of MJCF and URDF, centred at the origin, closed, faces outward.

Round shapes are surfaces of revolution around z. Their vertices lie on the surface, so the mesh is inscribed:
with `SEGMENTS` corners round the axis a cylinder of radius 1 loses 1 - cos(pi / 32) = 0.5 % of it between two
corners, while the extremes along x, y and z are met exactly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from graft.objects import Floats, Ints

SEGMENTS = 32
"""Corners around the axis of a round shape; a multiple of four puts vertices at the extremes in x and y."""

RINGS = 16
"""Bands from pole to pole of a sphere; even, so that the equator is a ring."""

Triangles = tuple[Floats, Ints]
"""Vertices (v, 3) and faces (f, 3)."""


def box(half_extents: ArrayLike) -> Triangles:
    """Return a box of `half_extents` (3,), lengths."""
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [(a, b, c) for a, b, c, _ in quads] + [(a, c, d) for a, _, c, d in quads]
    return signs * np.asarray(half_extents, np.float64), np.array(faces, np.int64)


def ellipsoid(radii: ArrayLike) -> Triangles:
    """Return an ellipsoid of `radii` (3,), lengths."""
    polar = np.linspace(0.0, np.pi, RINGS + 1)[1:-1]
    vertices, faces = _revolve(np.sin(polar), -np.cos(polar), -1.0, 1.0)
    return vertices * np.asarray(radii, np.float64), faces


def sphere(radius: float) -> Triangles:
    """Return a sphere of `radius`."""
    return ellipsoid((radius, radius, radius))


def cylinder(radius: float, half_length: float) -> Triangles:
    """Return a cylinder along z of `radius`, from -`half_length` to `half_length`."""
    return _revolve(np.full(2, radius), np.array([-half_length, half_length]), -half_length, half_length)


def capsule(radius: float, half_length: float) -> Triangles:
    """Return a cylinder along z of `radius` and `half_length` with a half sphere at either end."""
    polar = np.linspace(0.0, np.pi / 2, RINGS // 2 + 1)[1:]
    radii, heights = radius * np.sin(polar), half_length + radius * np.cos(polar)
    top = half_length + radius
    return _revolve(np.r_[radii, radii[::-1]], np.r_[-heights, heights[::-1]], -top, top)


def _revolve(radii: Floats, heights: Floats, bottom: float, top: float) -> Triangles:
    """Turn a rising profile (`radii`, `heights`) around z and close it at heights `bottom` and `top`."""
    angles = np.arange(SEGMENTS) * (2 * np.pi / SEGMENTS)
    round_ = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rings = [np.c_[r * round_, np.full(SEGMENTS, z)] for r, z in zip(radii, heights, strict=True)]
    vertices = np.concatenate([[[0.0, 0.0, bottom]], *rings, [[0.0, 0.0, top]]])

    here = np.arange(SEGMENTS)
    ahead = (here + 1) % SEGMENTS
    faces = [np.c_[np.zeros(SEGMENTS, np.int64), 1 + ahead, 1 + here]]
    for ring in range(len(radii) - 1):
        low, high = 1 + ring * SEGMENTS, 1 + (ring + 1) * SEGMENTS
        faces += [np.c_[low + here, low + ahead, high + ahead], np.c_[low + here, high + ahead, high + here]]
    last, pole = 1 + (len(radii) - 1) * SEGMENTS, len(vertices) - 1
    faces.append(np.c_[last + here, last + ahead, np.full(SEGMENTS, pole)])
    return vertices, np.concatenate(faces).astype(np.int64)

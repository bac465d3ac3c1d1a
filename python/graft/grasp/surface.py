"""An object's whole surface as the core wants it: one array of vertices, one of faces, and balls for clouds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from graft.checks import Floats, Ints
from graft.errors import InputError
from graft.objects import PartObject

BALL_SPACINGS = 1.0
"""Radius of a cloud point's ball in median distances to the nearest neighbour: balls then overlap into a skin."""

NEIGHBOURS = 16
"""Points by whose plane a cloud's unknown normals are estimated; the core's number."""

OFF_SURFACE = 0.01
"""Distance, in metres, from which a contact no longer lies on the surface: half a Panda's pad. Transferred contacts lie
on it; marked ones may be off by the coarseness of another mesh of the same object."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A metric object's triangles and balls.

    Attributes:
        vertices: (v, 3) metres.
        faces: (f, 3) vertex indices.
        face_parts: (f,) the part each face belongs to.
        points: (p, 3) of cloud parts, metres.
        normals: (p, 3) of those points; zero where unknown.
        radii: (p,) of their balls, metres.
        point_parts: (p,) the part each point belongs to.
    """

    vertices: Floats
    faces: Ints
    face_parts: Ints
    points: Floats
    normals: Floats
    radii: Floats
    point_parts: Ints


def surface_of(obj: PartObject) -> Surface:
    """Join the parts of an object that is already in metres."""
    meshes = [(i, p) for i, p in enumerate(obj.parts) if not p.is_point_cloud]
    clouds = [(i, p) for i, p in enumerate(obj.parts) if p.is_point_cloud]
    offsets = np.cumsum([0, *(len(p.vertices) for _, p in meshes)])
    no_points, no_numbers = np.empty((0, 3)), np.empty(0, np.int64)
    return Surface(
        vertices=np.concatenate([no_points, *(p.vertices for _, p in meshes)]),
        faces=np.concatenate(
            [np.empty((0, 3), np.int64), *(p.faces + o for (_, p), o in zip(meshes, offsets[:-1], strict=True))]
        ),
        face_parts=np.concatenate([no_numbers, *(np.full(len(p.faces), i) for i, p in meshes)]),
        points=np.concatenate([no_points, *(p.vertices for _, p in clouds)]),
        normals=np.concatenate(
            [no_points, *(np.zeros_like(p.vertices) if p.normals is None else p.normals for _, p in clouds)]
        ),
        radii=np.concatenate([np.empty(0), *(np.full(len(p.vertices), _ball_radius(p.vertices)) for _, p in clouds)]),
        point_parts=np.concatenate([no_numbers, *(np.full(len(p.vertices), i) for i, p in clouds)]),
    )


def _ball_radius(points: Floats) -> float:
    if len(points) < 2:
        return 0.0
    # The nearest point is the point itself.
    distances, _ = cKDTree(points).query(points, k=[2])
    return BALL_SPACINGS * float(np.median(distances))


def with_surfels(surface: Surface) -> Surface:
    """Return a surface whose points have become squares across their normals, as wide as their balls.

    Unknown normals are those of the plane through the nearest `NEIGHBOURS` points.
    """
    if not len(surface.points):
        return surface
    unknown = ~surface.normals.any(axis=1)
    normals = surface.normals.copy()
    if unknown.any():
        normals[unknown] = _plane_normals(surface.points)[unknown]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normals, first)
    reach = surface.radii[:, None]
    corners = np.stack(
        [surface.points + reach * (a * first + b * second) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))], axis=1
    )
    start = len(surface.vertices) + 4 * np.arange(len(surface.points))[:, None]
    squares = np.concatenate([start + [0, 1, 2], start + [0, 2, 3]], axis=1).reshape(-1, 3)
    return Surface(
        vertices=np.concatenate([surface.vertices, corners.reshape(-1, 3)]),
        faces=np.concatenate([surface.faces, squares]),
        face_parts=np.concatenate([surface.face_parts, np.repeat(surface.point_parts, 2)]),
        points=np.empty((0, 3)),
        normals=np.empty((0, 3)),
        radii=np.empty(0),
        point_parts=np.empty(0, np.int64),
    )


def _plane_normals(points: Floats) -> Floats:
    _, neighbours = cKDTree(points).query(points, k=min(NEIGHBOURS, len(points)))
    around = points[neighbours.reshape(len(points), -1)]
    centred = around - around.mean(axis=1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", centred, centred))
    normals: Floats = vectors[:, :, 0]
    return normals


def check_on_surface(surface: Surface, point: Floats, name: str) -> None:
    """Raise `InputError` when a point is farther than `OFF_SURFACE` from the triangles' planes and edges."""
    distance = surface_distance(surface, point)
    if distance > OFF_SURFACE:
        raise InputError(
            f"contact of object {name!r}: expected a point within {1e3 * OFF_SURFACE:g} mm of the surface, got "
            f"{point.round(4).tolist()} m, {1e3 * distance:.3g} mm off it"
        )


def surface_distance(surface: Surface, point: Floats) -> float:
    """Return the distance of a point (3,) from the nearest triangle, metres; infinity where there is none.

    Ericson 2005, "Real-Time Collision Detection", 5.1.5: the foot on the plane where it falls inside, else on an edge.
    """
    a, b, c = (surface.vertices[surface.faces[:, k]] - point for k in range(3))
    if not len(a):
        return float("inf")
    nearest = np.inf
    for start, end in ((a, b), (b, c), (c, a)):
        along = end - start
        length = np.einsum("ij,ij->i", along, along)
        share = np.clip(-np.einsum("ij,ij->i", start, along) / np.where(length > 0, length, 1.0), 0.0, 1.0)
        nearest = min(nearest, float(np.linalg.norm(start + share[:, None] * along, axis=1).min()))
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    inside = size > 0
    for start, end in ((a, b), (b, c), (c, a)):
        # The foot of the origin lies on the inner side of every edge.
        inside &= np.einsum("ij,ij->i", np.cross(end - start, -start), normal) >= 0
    if inside.any():
        height = np.abs(np.einsum("ij,ij->i", a[inside], normal[inside])) / size[inside]
        nearest = min(nearest, float(height.min()))
    return nearest

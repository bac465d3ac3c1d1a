"""Distances between meshes and from points to them, by brute force over the nearest faces."""

from __future__ import annotations

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from graft.objects import Floats, Part, PartObject

NEAREST = 40
"""Vertices and faces that are compared exactly, the nearest by vertex and by centroid."""


def point_to_part(point: Floats, part: Part) -> float:
    """Return the exact distance from a point to a part's surface."""
    triangles = part.vertices[part.faces]
    closest = trimesh.triangles.closest_point(triangles, np.broadcast_to(point, (len(triangles), 3)))
    return float(np.linalg.norm(closest - point, axis=1).min())


def winding_numbers(points: Floats, part: Part) -> Floats:
    """Return how often a part's surface goes around each point (n, 3): 0 outside, 1 inside.

    Sum of solid angles (Van Oosterom and Strackee 1983).
    """
    corners = part.vertices[part.faces][None] - points[:, None, None]
    lengths = np.linalg.norm(corners, axis=-1)
    a, b, c = (corners[:, :, i] for i in range(3))
    la, lb, lc = (lengths[:, :, i] for i in range(3))
    volume = np.einsum("nfi,nfi->nf", a, np.cross(b, c))
    below = la * lb * lc + (a * b).sum(-1) * lc + (b * c).sum(-1) * la + (c * a).sum(-1) * lb
    return np.arctan2(volume, below).sum(axis=1) / (2 * np.pi)


def floating_parts(obj: PartObject, tolerance: float) -> set[str]:
    """Return the names of the parts that no chain of parts nearer than `tolerance` joins to the first."""
    trees = [cKDTree(part.vertices[part.faces].mean(axis=1)) for part in obj.parts]
    linked, waiting = [0], list(range(1, len(obj.parts)))
    for i in linked:
        touching = [j for j in waiting if _near(obj.parts[i], trees[i], obj.parts[j], trees[j], tolerance)]
        linked += touching
        waiting = [j for j in waiting if j not in touching]
    return {obj.part_names[j] for j in waiting}


def _near(a: Part, tree_a: cKDTree, b: Part, tree_b: cKDTree, tolerance: float) -> bool:
    distance = min(_distance(a, b, tree_b), _distance(b, a, tree_a))
    return distance < tolerance or bool((winding_numbers(a.vertices[::300], b) > 0.5).any())


def _distance(a: Part, b: Part, tree_b: cKDTree) -> float:
    """Return the distance from the vertices of `a` to the surface of `b`."""
    away, _ = tree_b.query(a.vertices)
    nearest = a.vertices[np.argsort(away)[:NEAREST]]
    _, faces = tree_b.query(nearest, k=NEAREST)
    points = np.repeat(nearest, NEAREST, axis=0)
    closest = trimesh.triangles.closest_point(b.vertices[b.faces][faces.ravel()], points)
    return float(np.linalg.norm(closest - points, axis=1).min())

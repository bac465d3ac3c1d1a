"""Fused solids with known parts: the surfaces of voxels, moved off the grid by smoothing."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from graft.objects import Floats, Ints

Rule = Callable[[Floats, Floats, Floats], Ints]
"""x, y, z of voxel centres -> part of each, -1 outside."""


def voxel_mesh(rule: Rule, cells: int = 56, smoothing: int = 6) -> tuple[Floats, Ints, Ints]:
    """Return vertices, faces and the part of each face of the surface of a solid in [-1, 1]^3."""
    axis = (np.arange(cells) + 0.5) / cells * 2.0 - 1.0
    labels = np.full((cells + 2,) * 3, -1)
    labels[1:-1, 1:-1, 1:-1] = rule(*np.meshgrid(axis, axis, axis, indexing="ij"))
    quads, owner = [], []
    for k in range(3):
        for sign in (-1, 1):
            outside = np.roll(labels, -sign, axis=k) < 0
            cell = np.argwhere((labels >= 0) & outside)
            a, b = np.eye(3, dtype=int)[(k + 1) % 3], np.eye(3, dtype=int)[(k + 2) % 3]
            base = cell + np.eye(3, dtype=int)[k] * (sign > 0)
            ring = [base, base + a, base + a + b, base + b]
            quads.append(np.stack(ring if sign > 0 else ring[::-1], axis=1))
            owner.append(labels[tuple(cell.T)])
    corners = np.concatenate(quads)
    vertices, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    quad = index.reshape(-1, 4)
    faces = np.concatenate([quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]])
    points = vertices / cells * 2.0 - 1.0
    edges = np.concatenate([quad[:, [i, (i + 1) % 4]] for i in range(4)])
    for _ in range(smoothing):
        sums, counts = np.zeros_like(points), np.zeros(len(points))
        for start, end in ((0, 1), (1, 0)):
            np.add.at(sums, edges[:, start], points[edges[:, end]])
            np.add.at(counts, edges[:, start], 1.0)
        points = 0.5 * points + 0.5 * sums / counts[:, None]
    return points, faces.astype(np.int64), np.tile(np.concatenate(owner), 2).astype(np.int64)


def mug(x: Floats, y: Floats, z: Floats) -> Ints:
    """A thin wall open above, and a ring of a handle through x > 0."""
    radius = np.hypot(x + 0.3, y)
    wall = (radius < 0.6) & (np.abs(z) < 0.7) & ~((radius < 0.52) & (z > -0.6))
    ring = (np.hypot(np.hypot(x - 0.3, z) - 0.4, y) < 0.09) & (radius >= 0.6)
    return np.where(wall, 0, np.where(ring, 1, -1))


def pan(x: Floats, y: Floats, z: Floats) -> Ints:
    """A flat dish of thin walls, open above, and a straight handle."""
    radius = np.hypot(x + 0.45, y)
    dish = (radius < 0.5) & (np.abs(z) < 0.12) & ~((radius < 0.43) & (z > -0.06))
    rod = (np.hypot(y, z) < 0.07) & (x < 0.95) & (x > -0.4) & (radius >= 0.5)
    return np.where(dish, 0, np.where(rod, 1, -1))


def dumbbell(x: Floats, y: Floats, z: Floats) -> Ints:
    """Two balls on a bar."""
    left, right = (np.sqrt((x - side) ** 2 + y**2 + z**2) < 0.35 for side in (-0.6, 0.6))
    bar = np.hypot(y, z) < 0.12
    return np.where(left, 0, np.where(right, 1, np.where(bar & (np.abs(x) < 0.6), 2, -1)))


def ball(x: Floats, y: Floats, z: Floats) -> Ints:
    """A ball, which has no parts."""
    return np.where(x**2 + y**2 + z**2 < 0.64, 0, -1)


def bent_tube(x: Floats, y: Floats, z: Floats) -> Ints:
    """Half a ring: a bend alone is no border."""
    return np.where((np.hypot(np.hypot(x, z) - 0.6, y) < 0.15) & (z > 0), 0, -1)

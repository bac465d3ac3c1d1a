"""Holes in a part's surface, closed before it is cut into pieces.

A part cut out of a solid's surface is open where it was cut; left so, CoACD takes it for a thin shell and cuts it into
hundreds of flakes.
"""

from __future__ import annotations

import numpy as np

from graft.objects import Floats, Ints

RING = 0.5
"""Two rims whose middles are nearer than this share of the larger one's radius bound a ring (a cut through a wall)."""


def capped(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Return the surface with its holes closed.

    A rim alone is closed by a fan around its middle; two that lie in each other and run in opposite senses, as where a
    vessel's wall was cut, by a strip between them.
    """
    _, first, same = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    points = vertices[first]
    corners = same.reshape(-1)[faces]
    rims = _rims(corners)
    middles = [points[rim].mean(axis=0) for rim in rims]
    sweeps = [_area(points[rim]) for rim in rims]
    radii = [
        float(np.linalg.norm(points[rim] - middle, axis=1).mean()) for rim, middle in zip(rims, middles, strict=True)
    ]
    added, closing = [points], [corners]
    count = len(points)
    left = sorted(range(len(rims)), key=lambda i: (-radii[i], i))
    while left:
        outer = left.pop(0)
        inside = [
            i
            for i in left
            if np.linalg.norm(middles[i] - middles[outer]) < RING * radii[outer] and sweeps[i] @ sweeps[outer] < 0
        ]
        if inside:
            left.remove(inside[0])
            closing.append(_strip(points, rims[outer], rims[inside[0]]))
            continue
        rim = rims[outer]
        added.append(middles[outer][None])
        closing.append(np.stack([rim, np.roll(rim, -1), np.full(len(rim), count)], axis=1))
        count += 1
    return np.vstack(added), np.vstack(closing)


def enclosed(vertices: Floats, faces: Ints) -> float:
    """Return the volume that a closed surface encloses; negative when it is inside out, as that of a cavity is."""
    middle = vertices.mean(axis=0)
    a, b, c = (vertices[faces[:, i]] - middle for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def _rims(corners: Ints) -> list[Ints]:
    """Return the loops of edges that only one face has, each walked against its faces."""
    edges = np.vstack([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    known = set(map(tuple, edges.tolist()))
    following: dict[int, list[int]] = {}
    for a, b in sorted(known):
        if (b, a) not in known:
            following.setdefault(b, []).append(a)
    rims = []
    while following:
        start = min(following)
        rim = [start]
        while rim[-1] in following:
            ends = following[rim[-1]]
            if not ends[1:]:
                del following[rim[-1]]
            rim.append(ends.pop())
            if rim[-1] == start:
                break
        # What does not come back is the fold of a broken mesh: it stays open.
        if rim[-1] == start and len(rim) > 3:
            rims.append(np.array(rim[:-1]))
    return rims


def _area(loop: Floats) -> Floats:
    """Return the vector area (3,) of a loop (n, 3)."""
    area: Floats = np.cross(loop, np.roll(loop, -1, axis=0)).sum(axis=0) / 2
    return area


def _strip(points: Floats, outer: Ints, inner: Ints) -> Ints:
    """Return the faces of a strip between two loops that run in opposite senses."""
    back = inner[::-1]
    start = int(np.linalg.norm(points[back] - points[outer[0]], axis=1).argmin())
    back = np.roll(back, -start)
    n, m = len(outer), len(back)
    faces = []
    i = j = 0
    while i < n or j < m:
        if j == m or (i < n and (i + 1) * m <= (j + 1) * n):
            faces.append((outer[i % n], outer[(i + 1) % n], back[j % m]))
            i += 1
        else:
            faces.append((outer[i % n], back[(j + 1) % m], back[j % m]))
            j += 1
    return np.array(faces)

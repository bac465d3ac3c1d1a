"""Trimmed ICP from several starts, at equal size.

The scale is that of the root mean square radii and stays: an ICP that may scale shrinks the source into the
target.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from graft.contact.canonical import CUBE_ROTATIONS
from graft.objects import Floats

TRIM = 0.8
"""Share of the points, those that fit best, that a step fits (Chetverikov, Stepanov and Krsek 2005)."""

FIRST_STEPS = 4
"""Steps from every start, after which the best few go on."""

FINALISTS = 3
"""Starts that go on."""

LAST_STEPS = 25
"""Steps of the finalists."""


@dataclass(frozen=True, eq=False)
class Alignment:
    """A similarity that lays one point set on another.

    Attributes:
        transform: (4, 4) takes source points to target points.
        error: Root mean square of the trimmed distances, to the target and back, in target radii.
    """

    transform: Floats
    error: float


def rigid(source: Floats, target: Floats) -> Floats:
    """Return the rotation and translation (4, 4) that best takes points (s, 3) to others (Umeyama 1991)."""
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    u, _, vt = np.linalg.svd(b.T @ a)
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    transform = np.eye(4)
    transform[:3, :3] = u @ (signs[:, None] * vt)
    transform[:3, 3] = target.mean(axis=0) - transform[:3, :3] @ source.mean(axis=0)
    return transform


def align(source: Floats, target: Floats) -> Alignment:
    """Lay `source` (s, 3) on `target` (t, 3).

    Starts are the 24 ways to lay principal axes on principal axes, at equal radius.
    """
    frame_s, center_s, radius_s = _principal(source)
    frame_t, center_t, radius_t = _principal(target)
    scaled = np.eye(4)
    scaled[:3, :3] *= radius_t / radius_s
    scaled[:3, 3] = -scaled[:3, :3] @ center_s
    laid = (source - center_s) * (radius_t / radius_s)
    tree = cKDTree(target)
    started = []
    for turn in CUBE_ROTATIONS:
        start = np.eye(4)
        start[:3, :3] = frame_t @ turn @ frame_s.T
        start[:3, 3] = center_t
        started.append(_stepped(laid, target, tree, start, FIRST_STEPS))
    started.sort(key=lambda found: found[0])
    ended = [_stepped(laid, target, tree, start, LAST_STEPS) for _, start in started[:FINALISTS]]
    error, transform = min(ended, key=lambda found: found[0])
    return Alignment(transform @ scaled, error / radius_t)


def _principal(points: Floats) -> tuple[Floats, Floats, float]:
    """Return principal axes (columns, right-handed), centroid and root mean square radius."""
    center = points.mean(axis=0)
    axes = np.linalg.svd(points - center, full_matrices=False)[2].T
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    radius = float(np.sqrt(np.square(points - center).sum(axis=1).mean()))
    return axes, center, max(radius, np.finfo(float).tiny)


def _stepped(source: Floats, target: Floats, tree: cKDTree, transform: Floats, steps: int) -> tuple[float, Floats]:
    """Return the error after so many steps, and the transform then."""
    kept = max(4, int(TRIM * len(source)))
    for _ in range(steps):
        distances, nearest = tree.query(source @ transform[:3, :3].T + transform[:3, 3])
        best = np.argpartition(distances, kept - 1)[:kept]
        transform = rigid(source[best], target[np.asarray(nearest)[best]])
    moved = source @ transform[:3, :3].T + transform[:3, 3]
    both = (np.sort(tree.query(moved)[0]), np.sort(cKDTree(moved).query(target)[0]))
    errors = [np.square(apart[: max(4, int(TRIM * len(apart)))]).mean() for apart in both]
    return float(np.sqrt(np.mean(errors))), transform

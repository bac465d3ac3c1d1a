"""What a motion must not run into, as the core reads it."""

from __future__ import annotations

import numpy as np

from graft.checks import Floats, Ints
from graft.grasp import Support, metric_scale
from graft.grasp.surface import surface_of
from graft.objects import PartObject

World = tuple[Floats, Ints, Floats, Floats, tuple[float, float, float, float] | None]
"""What the core reads: vertices, faces, centres and radii of the balls of clouds, the support's normal and offset."""


def metric_world(obj: PartObject, support: Support | None) -> World:
    """Return the obstacles that an object and its support are, metres, the object's own frame.

    Raises:
        InputError: See `graft.grasp.metric_scale`.
    """
    scale, surface = metric_scale(obj), surface_of(obj)
    balls = surface.points * scale, surface.radii * scale
    return surface.vertices * scale, surface.faces, *balls, plane_of(support)


def nothing_but(support: Support | None) -> World:
    """Return a world without an object."""
    return np.empty((0, 3)), np.empty((0, 3), np.int64), np.empty((0, 3)), np.empty(0), plane_of(support)


def moved(world: World, pose: Floats) -> World:
    """Return the object moved by `pose` (4, 4); the support stays."""
    vertices, faces, points, radii, plane = world
    turn, offset = pose[:3, :3].T, pose[:3, 3]
    return vertices @ turn + offset, faces, points @ turn + offset, radii, plane


def plane_of(support: Support | None) -> tuple[float, float, float, float] | None:
    """Return normal and offset."""
    if support is None:
        return None
    x, y, z = (float(v) for v in support.normal)
    return x, y, z, float(support.offset)


def workspaces(world: World, starts: Floats, goals: Floats, margin: float) -> Floats:
    """Return for each problem the corners (n, 2, 3) of the box of object, start and goal, `margin` larger all around.

    Args:
        world: What stands in the way.
        starts: (n, 4, 4) poses.
        goals: (n, 4, 4) poses.
        margin: Metres.
    """
    points = np.concatenate([world[0], world[2]]).T.copy()  # columns are reduced an order of magnitude sooner than rows
    low = np.minimum(starts[:, :3, 3], goals[:, :3, 3])
    high = np.maximum(starts[:, :3, 3], goals[:, :3, 3])
    low, high = np.minimum(low, points.min(axis=1)), np.maximum(high, points.max(axis=1))
    return np.stack([low - margin, high + margin], axis=1)

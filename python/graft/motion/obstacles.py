"""What a motion must not run into, as the core reads it."""

from __future__ import annotations

import numpy as np

from graft.checks import Floats, Ints
from graft.errors import InputError
from graft.grasp import Support, metric_scale
from graft.objects import PartObject

World = tuple[Floats, Ints, tuple[float, float, float, float] | None]
"""What the core reads: vertices, faces, the support's normal and offset."""


def metric_world(obj: PartObject, support: Support | None) -> World:
    """Return the obstacles that an object and its support are, metres, the object's own frame.

    Raises:
        InputError: A part is a point cloud, through which a gripper would pass; see also `graft.grasp.metric_scale`.
    """
    for part in obj.parts:
        if part.is_point_cloud:
            raise InputError(f"object {obj.name!r} part {part.name!r}: motions need faces, this is a point cloud")
    counts = np.cumsum([0] + [len(part.vertices) for part in obj.parts])
    vertices = np.concatenate([part.vertices for part in obj.parts]) * metric_scale(obj)
    faces = np.concatenate([part.faces + first for part, first in zip(obj.parts, counts[:-1], strict=True)])
    return vertices, faces, plane_of(support)


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
    points = world[0].T.copy()  # columns are reduced an order of magnitude sooner than rows
    low = np.minimum(starts[:, :3, 3], goals[:, :3, 3])
    high = np.maximum(starts[:, :3, 3], goals[:, :3, 3])
    low, high = np.minimum(low, points.min(axis=1)), np.maximum(high, points.max(axis=1))
    return np.stack([low - margin, high + margin], axis=1)

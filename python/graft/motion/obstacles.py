"""What a motion must not run into, as the core reads it."""

from __future__ import annotations

import numpy as np

from graft.checks import Floats, Ints
from graft.errors import InputError
from graft.grasp import Support, in_metres
from graft.io import ObjectLike, as_object
from graft.objects import PartObject

World = tuple[Floats, Ints, tuple[float, float, float, float] | None]
"""What the core reads: vertices, faces, the support's normal and offset."""


def metric_mesh(obj: ObjectLike) -> PartObject:
    """Return an object in metres whose parts are all meshes.

    Raises:
        InputError: A part is a point cloud, through which a gripper would pass; see also `graft.grasp.metric_scale`.
    """
    metric = in_metres(as_object(obj))
    for part in metric.parts:
        if part.is_point_cloud:
            raise InputError(f"object {metric.name!r} part {part.name!r}: motions need faces, this is a point cloud")
    return metric


def world_of(metric: PartObject, support: Support | None) -> World:
    """Return the obstacles that an object in metres and its support are."""
    counts = np.cumsum([0] + [len(part.vertices) for part in metric.parts])
    vertices = np.concatenate([part.vertices for part in metric.parts])
    faces = np.concatenate([part.faces + first for part, first in zip(metric.parts, counts[:-1], strict=True)])
    return np.ascontiguousarray(vertices), np.ascontiguousarray(faces), plane_of(support)


def plane_of(support: Support | None) -> tuple[float, float, float, float] | None:
    """Return normal and offset."""
    if support is None:
        return None
    x, y, z = (float(v) for v in support.normal)
    return x, y, z, float(support.offset)

"""Which poses of a gripper touch an object or its support."""

from __future__ import annotations

from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graft import _core
from graft.checks import Floats, checked_array
from graft.errors import InputError
from graft.grasp.gripper import Gripper
from graft.grasp.metric import Support, in_metres
from graft.grasp.surface import surface_of
from graft.objects import PartObject


class BoxArrays(TypedDict):
    """A gripper's boxes as the core takes them: the palm's, then the finger's, the pad first among these."""

    centers: Floats
    half_extents: Floats
    rotations: Floats
    fingers: int


def box_arrays(gripper: Gripper) -> BoxArrays:
    """Return the gripper's boxes as arrays: (b, 3) centres, (b, 3) half extents, (b, 3, 3) axes in columns."""
    boxes = gripper.palm + gripper.finger
    return BoxArrays(
        centers=np.array([box.center for box in boxes]),
        half_extents=np.array([box.half_extents for box in boxes]),
        rotations=np.array([box.rotation for box in boxes]),
        fingers=len(gripper.finger),
    )


def gripper_collisions(
    obj: PartObject,
    gripper: Gripper,
    poses: ArrayLike,
    openings: ArrayLike,
    *,
    margin: float = 0.0,
    support: Support | None = None,
    solid: bool = False,
) -> NDArray[np.bool_]:
    """Say which poses of a gripper touch an object, or come nearer to it than a margin.

    Box against triangle is exact in double precision (separating axes, Akenine-Möller 2001); touching counts. Only the
    surface counts, as in FCL, unless `solid`. The points of clouds are balls as wide as the points are apart.

    Args:
        obj: The object.
        gripper: What moves.
        poses: (q, 4, 4) T_object_gripper, metres.
        openings: (q,) between the pads, metres; a single number serves every pose.
        margin: By which every face of every box is moved out, metres.
        support: A plane that no box may go below, nor nearer to than the margin.
        solid: Boxes wholly inside a mesh collide too; its parts must be closed and wound outward.

    Returns:
        (q,) True where it collides.

    Raises:
        InputError: Wrong shapes, numbers that are not finite, openings below zero, a negative margin; or the object's
            size: see `graft.grasp.metric.metric_scale`.
    """
    matrices: Floats = checked_array("poses", poses, (None, 4, 4))
    widths: Floats = checked_array("openings", np.broadcast_to(np.asarray(openings, float), len(matrices)), (None,))
    if (widths < 0).any():
        raise InputError(f"openings: expected numbers of at least 0, got {widths.min():g}")
    if not (np.isfinite(margin) and margin >= 0):
        raise InputError(f"margin: expected a number of at least 0, got {margin}")
    surface = surface_of(in_metres(obj))
    return _core.gripper_collisions(
        vertices=surface.vertices,
        faces=surface.faces,
        points=surface.points,
        radii=surface.radii,
        poses=matrices,
        openings=widths,
        margin=margin,
        plane=None if support is None else (*support.normal.tolist(), support.offset),
        solid=solid,
        **box_arrays(gripper),
    )

"""Motions of a gripper that flies freely, around the object to where it is sent."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from graft import _core
from graft.checks import Floats
from graft.errors import InputError
from graft.grasp import Gripper, Support
from graft.io import ObjectLike, as_object
from graft.motion.config import MotionConfig
from graft.motion.obstacles import World, metric_world, workspaces
from graft.motion.trajectory import Motion, checked_pose, no_motion, stamp

DEFAULTS = MotionConfig()


def plan_motion(
    obj: ObjectLike,
    start: ArrayLike,
    goal: ArrayLike,
    gripper: Gripper,
    *,
    support: Support | None = None,
    opening: float | None = None,
    config: MotionConfig = DEFAULTS,
) -> Motion:
    """Plan how a gripper flies from one pose to another without touching the object or going below its support.

    Args:
        obj: The object, anything `graft.as_object` takes.
        start: (4, 4) T_object_gripper, metres; frame as in `graft.grasp.gripper`.
        goal: (4, 4) T_object_gripper, metres.
        gripper: What moves.
        support: What the object stands on; None for nothing.
        opening: Between the pads, metres; the stroke by default. It does not change on the way.
        config: How to plan and how fast to move.

    Returns:
        The motion, or a motion without poses that says why there is none.

    Raises:
        InputError: A pose is no rigid motion, the opening is beyond the stroke, or the object's size is none in metres.
    """
    return plan_motions(obj, [start], [goal], gripper, support=support, opening=opening, config=config)[0]


def plan_motions(
    obj: ObjectLike,
    starts: ArrayLike | list[ArrayLike],
    goals: ArrayLike | list[ArrayLike],
    gripper: Gripper,
    *,
    support: Support | None = None,
    opening: float | None = None,
    config: MotionConfig = DEFAULTS,
) -> list[Motion]:
    """Plan from each start to the goal of the same index; the object's tree of boxes is built once.

    Args:
        obj: See `plan_motion`.
        starts: (n, 4, 4) T_object_gripper, metres.
        goals: (n, 4, 4) T_object_gripper, metres.
        gripper: See `plan_motion`.
        support: See `plan_motion`.
        opening: See `plan_motion`.
        config: See `plan_motion`; every problem begins with the same seed.

    Raises:
        InputError: See `plan_motion`; or there are not as many starts as goals.
    """
    begins = _checked_poses("start", starts)
    ends = _checked_poses("goal", goals)
    if len(begins) != len(ends):
        raise InputError(f"goals: expected one for each of {len(begins)} starts, got {len(ends)}")
    width = checked_opening(gripper, opening)
    world = metric_world(as_object(obj), support)
    return plan_among(world, begins, ends, gripper, width, config)


def plan_among(
    world: World, starts: Floats, goals: Floats, gripper: Gripper, opening: float, config: MotionConfig
) -> list[Motion]:
    """Plan among obstacles as the core reads them; arguments are checked, metres. See `plan_motions`."""
    boxes = gripper.boxes(opening)
    waypoints, rows = _core.plan_hands(
        world=world,
        box_centers=np.stack([box.center for box in boxes]),
        box_rotations=np.stack([box.rotation for box in boxes]),
        box_half_extents=np.stack([box.half_extents for box in boxes]),
        bounds=workspaces(world, starts, goals, config.margin),
        starts=starts,
        goals=goals,
        settings=config.settings,
    )
    motions = []
    first = 0
    for i, (outcome, count, iterations, nodes, checks) in enumerate(rows.tolist()):
        reason = config.reason(outcome, iterations, nodes)
        if reason:
            motions.append(no_motion(reason, iterations, nodes, checks))
            continue
        poses = waypoints[first : first + count]
        poses[0], poses[-1] = starts[i], goals[i]  # as given, not as they came back from quaternions
        times = stamp(poses, config.linear_speed, config.angular_speed)
        motions.append(Motion(poses, times, "", iterations, nodes, checks))
        first += count
    return motions


def checked_opening(gripper: Gripper, opening: float | None) -> float:
    """Return the opening, the gripper's stroke for None.

    Raises:
        InputError: It is not in [0, stroke].
    """
    if opening is None:
        return gripper.stroke
    if not 0.0 <= opening <= gripper.stroke:
        stroke = f"the stroke {gripper.stroke:g} of gripper {gripper.name!r}"
        raise InputError(f"opening: expected metres from 0 to {stroke}, got {opening}")
    return float(opening)


def _checked_poses(name: str, values: ArrayLike | list[ArrayLike]) -> Floats:
    try:
        items = list(values)  # type: ignore[arg-type]
    except TypeError:
        raise InputError(f"{name}s: expected poses (n, 4, 4), got {type(values).__name__}") from None
    named = (checked_pose(name if len(items) == 1 else f"{name} {i}", item) for i, item in enumerate(items))
    return np.array(list(named)).reshape(-1, 4, 4)

"""From where the gripper is to a grasp and up: around the object, the last centimetres straight, then the lift."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from graft.checks import Floats
from graft.errors import InputError
from graft.grasp import Grasp, Support
from graft.io import ObjectLike, as_object
from graft.motion.config import MotionConfig
from graft.motion.hand import DEFAULTS, checked_opening, plan_among
from graft.motion.obstacles import metric_world
from graft.motion.trajectory import Motion, checked_pose, no_motion, stamp

STRAIGHT = 0.08
"""Length of the straight end of an approach, metres: a Panda's fingers then enter a handle along their own axis."""

LIFT = 0.1
"""Metres that a grasped object is lifted by."""

STRAIGHT_CLEARANCE = 1e-4
"""Clearance of the straight end, metres: a grasp may lie nearer to the surface than a motion in the open should."""

SPARE = (0.02, 0.01, 0.005)
"""Metres that the pads stand wider apart than the object is thick, tried in this order where the whole stroke does not
fit."""


@dataclass(frozen=True, eq=False)
class Approach:
    """The three legs of taking an object, or why they are not.

    Attributes:
        transit: From the start to the pre-grasp, around the object.
        straight: From the pre-grasp along the gripper's z to the grasp.
        lift: From the grasp away from the support; the object moves with the gripper.
        opening: Between the pads on transit and straight, metres.
        reason: "" when all three were found, else which was not and why.
    """

    transit: Motion
    straight: Motion
    lift: Motion
    opening: float
    reason: str = ""

    @property
    def found(self) -> bool:
        """Whether there are all three legs."""
        return not self.reason


def plan_approach(
    obj: ObjectLike,
    grasp: Grasp,
    start: ArrayLike,
    *,
    support: Support | None = None,
    opening: float | None = None,
    straight: float = STRAIGHT,
    lift: float = LIFT,
    config: MotionConfig = DEFAULTS,
) -> Approach:
    """Plan to the pre-grasp, straight to the grasp, and the lift.

    Args:
        obj: The object, anything `graft.as_object` takes.
        grasp: Where to close, in the object's frame.
        start: (4, 4) T_object_gripper, metres.
        support: What the object stands on; the lift goes along its normal. None: the lift goes along the object's
            up, or z.
        opening: Between the pads, metres; by default the stroke, or the widest of the thickness plus `SPARE` with
            which the straight end is free.
        straight: Length of the straight end, metres.
        lift: Length of the lift, metres.
        config: How to plan and how fast to move.

    Raises:
        InputError: See `graft.motion.plan_motion`; or a length is negative.
    """
    begin = checked_pose("start", start)
    end = checked_pose("grasp pose", grasp.pose)
    for name, length in (("straight", straight), ("lift", lift)):
        if not (np.isfinite(length) and length >= 0):
            raise InputError(f"{name}: expected metres, at least 0, got {length}")
    given = as_object(obj)
    world = metric_world(given, support)
    before = end @ translation(np.array([0.0, 0.0, -straight]))
    direct = replace(config, max_iterations=0, clearance=min(STRAIGHT_CLEARANCE, config.clearance))

    def fly(start: Floats, goal: Floats, width: float, how: MotionConfig) -> Motion:
        return plan_among(world, start[None], goal[None], grasp.gripper, width, how)[0]

    openings = _openings(grasp, opening)
    ends = (fly(before, end, width, direct) for width in openings)
    width, end_leg = next(((w, leg) for w, leg in zip(openings, ends, strict=True) if leg.found), (openings[-1], None))
    if end_leg is None:
        reason = f"the last {100 * straight:g} cm to the grasp are blocked, at openings {_millimetres(openings)} mm"
        return _unreached(width, reason)
    transit = fly(begin, before, width, config)
    if not transit.found:
        return _unreached(width, f"to the pre-grasp: {transit.reason}", transit)
    raised = _raised(end, given.up if support is None else support.normal, lift)
    times = stamp(raised, config.linear_speed, config.angular_speed)
    return Approach(transit, end_leg, Motion(raised, times), width)


def translation(offset: Floats) -> Floats:
    """Return the (4, 4) motion by `offset` (3,)."""
    matrix: Floats = np.eye(4)
    matrix[:3, 3] = offset
    return matrix


def _openings(grasp: Grasp, opening: float | None) -> tuple[float, ...]:
    if opening is not None:
        return (checked_opening(grasp.gripper, opening),)
    stroke = grasp.gripper.stroke
    narrower = (grasp.width + spare for spare in SPARE)
    return stroke, *(width for width in narrower if width < stroke)


def _raised(pose: Floats, up: Floats | None, lift: float) -> Floats:
    direction = np.array([0.0, 0.0, 1.0]) if up is None else up
    return np.stack([pose, translation(lift * direction) @ pose])


def _unreached(opening: float, reason: str, transit: Motion | None = None) -> Approach:
    leg = no_motion(reason)
    return Approach(leg if transit is None else transit, leg, leg, opening, reason)


def _millimetres(openings: tuple[float, ...]) -> str:
    return ", ".join(f"{1e3 * width:.0f}" for width in openings)

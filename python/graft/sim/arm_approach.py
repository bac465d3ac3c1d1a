"""An arm to a grasp and up: around the object, the last centimetres straight, then the lift."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from graft.checks import Floats
from graft.errors import InputError
from graft.grasp import Grasp, Support
from graft.io import ObjectLike
from graft.motion import MotionConfig
from graft.motion.approach import LIFT, STRAIGHT, STRAIGHT_CLEARANCE, translation
from graft.motion.joints import JointMotion, no_joint_motion, plan_joints, world_around
from graft.motion.obstacles import World, nothing_but
from graft.motion.trajectory import checked_pose
from graft.sim.arm import DEFAULTS, IK_DEFAULTS, Arm, IkConfig, begin_at, held_at, ik_solutions

STEP = 0.01
"""Metres between solutions of the inverse kinematics on a straight line; between them an arm of a Panda's size is off
the line by less than a tenth of a millimetre."""

LARGEST_CHANGE = 0.35
"""Radians that a joint may turn on one step of a line: more is a jump to another branch of solutions."""


@dataclass(frozen=True, eq=False)
class ArmApproach:
    """The three legs of taking an object with an arm, or why they are not.

    Attributes:
        transit: From the start to the pre-grasp.
        straight: From the pre-grasp along the gripper's z to the grasp.
        lift: From the grasp away from the support; the object moves with the gripper.
        reason: "" when all three were found, else why not.
    """

    transit: JointMotion
    straight: JointMotion
    lift: JointMotion
    reason: str = ""

    @property
    def found(self) -> bool:
        """Whether there are all three legs."""
        return not self.reason


def plan_arm_approach(
    arm: Arm,
    obj: ObjectLike,
    T_world_object: ArrayLike,
    grasp: Grasp,
    start: ArrayLike | None = None,
    *,
    support: Support | None = None,
    opening: float | None = None,
    straight: float = STRAIGHT,
    lift: float = LIFT,
    config: MotionConfig = DEFAULTS,
    ik: IkConfig = IK_DEFAULTS,
) -> ArmApproach:
    """Plan to the pre-grasp, straight to the grasp, and the lift.

    Args:
        arm: The arm.
        obj: The object, anything `graft.as_object` takes.
        T_world_object: (4, 4) where the object stands, metres.
        grasp: Where to close, in the object's frame.
        start: (j,) joint values; home by default.
        support: The plane that nothing but the arm's base goes below, world frame; the lift goes along its normal,
            without one along z.
        opening: Between the pads, metres; as at `home` by default.
        straight: Length of the straight end, metres.
        lift: Length of the lift, metres.
        config: How to plan and how fast to move.
        ik: How inverse kinematics is solved; every solution at the grasp is tried until all legs are found.

    Raises:
        InputError: See `graft.sim.arm.plan_arm`; or a length is negative.
        MissingExtraError: mink is not installed.
    """
    for name, value in (("straight", straight), ("lift", lift)):
        if not (np.isfinite(value) and value >= 0):
            raise InputError(f"{name}: expected metres, at least 0, got {value}")
    held = held_at(arm, opening)
    begin = begin_at(held, start)
    world = world_around(obj, T_world_object, support)
    end = checked_pose("T_world_object", T_world_object) @ checked_pose("grasp pose", grasp.pose)
    up = np.array([0.0, 0.0, 1.0]) if support is None else support.normal
    before = [end @ translation(np.array([0.0, 0.0, -step])) for step in _steps(straight)]
    above = [translation(step * up) @ end for step in _steps(lift)]
    direct = replace(config, max_iterations=0, clearance=min(STRAIGHT_CLEARANCE, config.clearance))
    nothing = no_joint_motion(held.chain, "not reached")
    reason = f"grasp out of reach, after {ik.attempts} attempts"
    for at_grasp in ik_solutions(held, end, begin, ik):
        back = _follow(held, at_grasp, before, ik)
        raised = _follow(held, at_grasp, above, ik)
        if back is None or raised is None:
            reason = (
                f"no straight line of {100 * straight:g} cm to the grasp and {100 * lift:g} cm up within the joints"
            )
            continue
        straight_leg = _joined(held, world, back[::-1], direct)
        if not straight_leg.found:
            reason = f"the last {100 * straight:g} cm to the grasp are blocked"
            continue
        # The object goes along: only the support and the arm itself are in the way.
        lift_leg = _joined(held, nothing_but(support), raised, direct)
        if not lift_leg.found:
            reason = "the lift is blocked"
            continue
        transit = plan_joints(held.chain, world, begin[None], straight_leg.joints[:1], config)[0]
        if transit.found:
            return ArmApproach(transit, straight_leg, lift_leg)
        reason = f"to the pre-grasp: {transit.reason}"
    return ArmApproach(nothing, nothing, nothing, reason)


def _steps(length: float) -> Floats:
    """Return distances from 0 to `length`, at most `STEP` apart."""
    return np.linspace(0.0, length, int(np.ceil(length / STEP)) + 1)


def _follow(arm: Arm, at_grasp: Floats, poses: Iterable[Floats], ik: IkConfig) -> Floats | None:
    """Return joint values along poses, from a solution of the first on; None where the arm cannot follow."""
    once = replace(ik, attempts=1)
    path = [at_grasp]
    for pose in itertools.islice(poses, 1, None):
        q = next(ik_solutions(arm, pose, path[-1], once), None)
        if q is None or np.abs(q - path[-1]).max() > LARGEST_CHANGE:
            return None
        path.append(q)
    return np.array(path)


def _joined(arm: Arm, world: World, path: Floats, direct: MotionConfig) -> JointMotion:
    """Return the motion through all of a path, or the first reason against it."""
    if len(path) == 1:
        path = np.repeat(path, 2, axis=0)
    legs = plan_joints(arm.chain, world, path[:-1], path[1:], direct)
    for leg in legs:
        if not leg.found:
            return leg
    times = np.cumsum([0.0] + [leg.duration for leg in legs])
    return JointMotion(path, times, checks=sum(leg.checks for leg in legs))

"""Inverse kinematics by mink, and plans of an arm to a gripper pose in the world.

Collisions are the core's: boxes around the model's collision shapes against the object's own triangles. MuJoCo would
take an object's convex hull for the object, and then no finger gets into a handle.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from graft.checks import Floats, checked_array
from graft.errors import InputError, MissingExtraError
from graft.grasp import Support
from graft.io import ObjectLike
from graft.motion import MotionConfig
from graft.motion.joints import JointMotion, clear_joints, no_joint_motion, plan_joints, world_around
from graft.motion.trajectory import checked_pose
from graft.sim.arm_model import Arm, load_arm, panda_arm

__all__ = ["Arm", "IkConfig", "load_arm", "panda_arm", "plan_arm", "solve_ik"]

LARGEST_STEP = 0.5
"""Radians (or metres) that a joint moves at most in one step: Newton's method overshoots near singularities."""

DAMPING = 1e-6
"""Damping of the least squares, so that they are solvable where the arm is straight."""

SOLVER = "daqp"
"""Of the quadratic programmes: the one that mink installs."""

SAME_SOLUTION = 0.05
"""Solutions whose joints all agree to this, radians or metres, count as one."""

DEFAULTS = MotionConfig()


@dataclass(frozen=True)
class IkConfig:
    """How inverse kinematics is solved.

    Attributes:
        attempts: Starts at most: the given joints, home, then random ones.
        solutions: Different solutions that are enough.
        iterations: Steps of one attempt.
        position_tolerance: Metres by which a solution may miss.
        angle_tolerance: Radians by which a solution may miss.
        seed: Of the random starts.
    """

    attempts: int = 24
    solutions: int = 4
    iterations: int = 60
    position_tolerance: float = 1e-4
    angle_tolerance: float = 1e-3
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("attempts", "solutions", "iterations"):
            if getattr(self, name) < 1:
                raise InputError(f"{name}: expected at least 1, got {getattr(self, name)}")
        for name in ("position_tolerance", "angle_tolerance"):
            if not 0 < getattr(self, name) < np.inf:
                raise InputError(f"{name}: expected a positive number, got {getattr(self, name)}")


IK_DEFAULTS = IkConfig()


def solve_ik(
    arm: Arm, T_world_gripper: ArrayLike, start: ArrayLike | None = None, *, config: IkConfig = IK_DEFAULTS
) -> Floats:
    """Return joint values that bring the gripper to a pose, without a look at collisions.

    Args:
        arm: The arm; its fingers stay as in `start`.
        T_world_gripper: (4, 4) metres.
        start: (j,) joint values to begin at; home by default.
        config: How hard to try.

    Returns:
        (k, j) different solutions within the joint limits, k <= `config.solutions`, the nearest to `start` (largest
        difference of a joint) first; none where no attempt arrived.

    Raises:
        InputError: The pose is no rigid motion, or the joint values are not finite.
        MissingExtraError: mink is not installed.
    """
    begin = checked_array("start joints", arm.home if start is None else start, (arm.chain.n_joints,))
    pose = checked_pose("T_world_gripper", T_world_gripper)
    found = list(itertools.islice(ik_solutions(arm, pose, begin, config), config.solutions))
    found.sort(key=lambda q: float(np.abs(q - begin).max()))
    return np.array(found).reshape(-1, arm.chain.n_joints)


def ik_solutions(arm: Arm, pose: Floats, begin: Floats, config: IkConfig) -> Iterator[Floats]:
    """Yield different solutions as they are found."""
    try:
        import mink
    except ImportError:
        raise MissingExtraError("inverse kinematics", package="mink", extra="sim") from None
    task = mink.FrameTask(arm.site, "site", position_cost=1.0, orientation_cost=1.0, lm_damping=DAMPING)
    task.set_target(mink.SE3.from_matrix(pose))
    configuration = mink.Configuration(arm.model)
    limits = [mink.ConfigurationLimit(arm.model)]
    rng = np.random.default_rng(config.seed)
    low, high = arm.chain.limits.T
    moving = arm.arm_joints
    found: list[Floats] = []
    for attempt in range(config.attempts):
        q = np.clip(begin, low, high)
        if attempt > 0:
            q[moving] = (arm.home if attempt == 1 else rng.uniform(low, high))[moving]
        for _ in range(config.iterations):
            configuration.update(q)
            error = task.compute_error(configuration)
            misses = np.linalg.norm(error[:3]), np.linalg.norm(error[3:])
            if misses[0] <= config.position_tolerance and misses[1] <= config.angle_tolerance:
                if all(np.abs(q - other).max() > SAME_SOLUTION for other in found):
                    found.append(q)
                    yield q
                break
            # The whole error as the velocity of one second: a Newton step, within the limits.
            step = mink.solve_ik(configuration, [task], 1.0, SOLVER, limits=limits)[moving]
            q = q.copy()
            q[moving] += step * (LARGEST_STEP / max(np.abs(step).max(), LARGEST_STEP))
            q[moving] = np.clip(q, low, high)[moving]


def plan_arm(
    arm: Arm,
    obj: ObjectLike | None,
    T_world_object: ArrayLike,
    T_world_gripper: ArrayLike,
    start: ArrayLike | None = None,
    *,
    support: Support | None = None,
    opening: float | None = None,
    config: MotionConfig = DEFAULTS,
    ik: IkConfig = IK_DEFAULTS,
) -> JointMotion:
    """Plan how an arm brings its gripper to a pose without touching the object, the support or itself.

    Args:
        arm: The arm.
        obj: The object, anything `graft.as_object` takes; None for none.
        T_world_object: (4, 4) where the object stands, metres.
        T_world_gripper: (4, 4) where the gripper goes, metres.
        start: (j,) joint values; home by default. Fingers are set to `opening`.
        support: The plane that nothing but the arm's base goes below, world frame.
        opening: Between the pads, metres; as at `home` by default.
        config: How to plan and how fast to move.
        ik: How inverse kinematics is solved. Its solutions are tried as they are found, the first from `start`.

    Returns:
        The motion, or one without waypoints that says why there is none.

    Raises:
        InputError: A pose is no rigid motion, an opening that the fingers do not reach, joint values that are not
            finite.
        MissingExtraError: mink is not installed.
    """
    held = held_at(arm, opening)
    begin = begin_at(held, start)
    world = world_around(obj, T_world_object, support)
    if not clear_joints(held.chain, world, begin[None], config.clearance)[0]:
        return no_joint_motion(held.chain, config.reason(1, 0, 0))
    target = checked_pose("T_world_gripper", T_world_gripper)
    # A share of the iterations for each solution, so that the whole search is no longer than one.
    share = replace(config, max_iterations=config.max_iterations // ik.solutions)
    motion, colliding, tried = no_joint_motion(held.chain, "goal out of reach"), 0, 0
    for goal in ik_solutions(held, target, begin, ik):
        if not clear_joints(held.chain, world, goal[None], config.clearance)[0]:
            colliding += 1
            continue
        motion = plan_joints(held.chain, world, begin[None], goal[None], share)[0]
        tried += 1
        if motion.found or tried == ik.solutions:
            return motion
    if tried:
        return motion
    why = f"goal in collision in all {colliding} solutions of the joints" if colliding else "goal out of reach"
    return no_joint_motion(held.chain, f"{why}, after {ik.attempts} attempts")


def held_at(arm: Arm, opening: float | None) -> Arm:
    """Return the arm with its fingers held at an opening, for None at that of its home.

    Raises:
        InputError: The fingers do not reach it.
    """
    fingers = arm.fingers
    if opening is None:
        return arm.holding(float(2.0 * arm.home[fingers].max(initial=0.0)))
    reach = 2.0 * float(arm.chain.limits[fingers, 1].min()) if len(fingers) else 0.0
    if not 0.0 <= opening <= reach:
        raise InputError(f"opening: expected metres from 0 to {reach:g}, got {opening}")
    return arm.holding(opening)


def begin_at(held: Arm, start: ArrayLike | None) -> Floats:
    """Return the joint values (j,) to start at, home for None, with the fingers where they are held.

    Raises:
        InputError: They are not finite, or not one for each joint.
    """
    begin = np.array(checked_array("start joints", held.home if start is None else start, (held.chain.n_joints,)))
    begin[held.fingers] = held.home[held.fingers]
    return begin

"""Demonstrations by script: plan a grasp at a contact, fly there, take the object, lift it; recorded in physics."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from graft.checks import Floats
from graft.datagen.config import CONTROL_RATE, REACH
from graft.datagen.judge import AttemptOutcome, Bounds, Judge
from graft.datagen.retarget import HOLD
from graft.datagen.rollout import FINGER_SPEED, Diverged, Rollout, grip_for
from graft.datagen.rotations import interpolated, inverse, rotation_about
from graft.datagen.scene import episode_scene
from graft.errors import InputError
from graft.grasp import PANDA_HAND, Grasp, Gripper, metric_scale, plan_grasps
from graft.motion import Motion, plan_approach
from graft.objects import Demonstration
from graft.sim import PreparedObject, SimulationConfig, prepare
from graft.trajectory import CLOSE, DEMONSTRATED, Segment, Trajectory

STRAIGHT_SPEED = 0.2
"""Metres a second of the last centimetres and of the lift."""

LIFT = 0.15
"""Metres that a demonstration lifts by."""

SQUEEZE = 8
"""Actions that the fingers press before the lift, after the time that the whole stroke takes."""

HELD = 10
"""Actions that a demonstration holds at the top, half a second."""

TRIED = 10
"""Grasps that are tried, best first, until one holds."""

ABOVE, ASIDE = 0.25, 0.2
"""Metres from the table's object to where the hand starts: above half its height, and beside its circle."""

PLACE = 0.1
"""Metres from the origin within which objects stand; see `graft.sim.prepared.XY_RANGE`."""


def start_pose(prepared: PreparedObject) -> Floats:
    """Return where the hand starts (4, 4) T_world_gripper: beside the object and above, pointing down."""
    pose = prepared.T_world_object
    corners = prepared.body.hull @ pose[:3, :3].T + pose[:3, 3]
    radius = float(np.linalg.norm(corners[:, :2], axis=1).max())
    start = np.diag([1.0, -1.0, -1.0, 1.0])
    start[:3, 3] = -(radius + PLACE + ASIDE), 0.0, corners[:, 2].max() / 2 + ABOVE
    return start


def closing_actions(gripper: Gripper) -> int:
    """Return how many actions it takes to close the whole stroke and press."""
    return int(np.ceil(gripper.stroke / 2 / FINGER_SPEED * CONTROL_RATE)) + SQUEEZE


@dataclass(frozen=True, eq=False)
class Script:
    """What the hand is told: targets (t, 4, 4), gripper actions (t,), and the stretches by name."""

    targets: Floats
    grips: Floats
    segments: tuple[Segment, ...]


def lift_script(transit: Floats, grasp: Floats, before: Floats, grip: float, closing: int) -> Script:
    """Return the script of a lift.

    Args:
        transit: (t, 4, 4) targets to the pre-grasp, T_world_gripper.
        grasp: (4, 4) where the gripper closes.
        before: (4, 4) the pre-grasp.
        grip: Gripper action on the way.
        closing: Actions that it closes for.
    """
    way = float(np.linalg.norm(grasp[:3, 3] - before[:3, 3]))
    straight = interpolated(before, grasp, max(1, round(way / STRAIGHT_SPEED * CONTROL_RATE)))
    straight = np.concatenate([straight, np.repeat(grasp[None], SETTLED, axis=0)])
    shut = np.repeat(grasp[None], closing, axis=0)
    steps = round(LIFT / STRAIGHT_SPEED * CONTROL_RATE) + 1
    # A cosine: the pads need not carry more than the weight at the start.
    rise = LIFT * (1 - np.cos(np.pi * np.arange(1, steps + 1) / steps)) / 2
    lift = np.repeat(grasp[None], steps, axis=0)
    lift[:, 2, 3] += rise
    hold = np.repeat(lift[-1:], HELD, axis=0)
    pieces = [transit, np.concatenate([straight, shut]), lift, hold]
    ends = np.cumsum([len(piece) for piece in pieces]).tolist()
    starts = [0, *ends[:-1]]
    names = (("reach", "reached"), ("grasp", "grasped"), ("lift", "lifted"), (HOLD, None))
    segments = tuple(
        Segment(name, start, end, DEMONSTRATED, signal)
        for (name, signal), start, end in zip(names, starts, ends, strict=True)
    )
    grips = np.full(ends[-1], CLOSE)
    grips[: len(transit) + len(straight)] = grip
    return Script(np.concatenate(pieces), grips, segments)


SETTLED = 3
"""Actions that the hand rests at the grasp before it closes."""


def demonstrate(
    shown: Demonstration,
    gripper: Gripper = PANDA_HAND,
    *,
    physics: SimulationConfig | None = None,
    seed: int = 0,
) -> Demonstration:
    """Return a demonstration of lifting, made by script and executed in physics without noise.

    Args:
        shown: The object and where it is taken.
        gripper: The floating hand.
        physics: Settings.
        seed: Of the planners.

    Returns:
        The same with grasp and trajectory: targets, reached poses, gripper actions, object poses, and the segments
        reach, grasp, lift and hold with their signals.

    Raises:
        InputError: No grasp of the first `TRIED` held; the message has the last reason.
        MissingExtraError: mujoco is not installed.
    """
    physics = physics or SimulationConfig()
    where = f"object {shown.object.name!r}"
    prepared = prepare(shown.object, physics)
    if not prepared.pose.stable:
        raise InputError(f"{where}: no pose in which it stands was found")
    grasps = plan_grasps(
        shown.object, shown.contact, gripper, support=prepared.support, k=TRIED, seed=seed,
    )  # fmt: skip
    if not len(grasps):
        why = max(grasps.rejected, key=lambda name: grasps.rejected[name], default="no candidate")
        raise InputError(f"{where}: gripper {gripper.name!r} cannot hold it at the contact ({why})")
    reason = ""
    for grasp in grasps:
        trajectory, reason = _executed(prepared, grasp, physics, seed)
        if trajectory is not None:
            contact = shown.contact
            if contact.approach is None:
                contact = replace(contact, approach=grasp.pose[:3, 2])
            metadata = {
                **shown.metadata, "task": "lift", "gripper": gripper.name, "made_by": "script", "seed": seed,
                "metres_per_unit": metric_scale(shown.object),
            }  # fmt: skip
            return replace(shown, contact=contact, grasp=grasp.pose, trajectory=trajectory, metadata=metadata)
    raise InputError(f"{where}: none of {len(grasps)} grasps held; the last: {reason}")


def _executed(
    prepared: PreparedObject, grasp: Grasp, physics: SimulationConfig, seed: int
) -> tuple[Trajectory | None, str]:
    """Return what was recorded, or None and the reason."""
    placed, start = prepared.T_world_object, start_pose(prepared)
    config = replace(REACH, seed=seed)
    plan = plan_approach(
        prepared.object, grasp, inverse(placed) @ start, support=prepared.support, config=config,
    )  # fmt: skip
    if not plan.found:
        return None, plan.reason
    transit = placed @ sampled(plan.transit)
    goal = placed @ grasp.pose
    grip = grip_for(plan.opening, grasp.gripper.stroke)
    script = lift_script(transit, goal, placed @ plan.straight.poses[0], grip, closing_actions(grasp.gripper))
    _, scene = episode_scene(prepared.body, physics, grasp.gripper)
    judge = Judge(Bounds.of(LIFT - physics.secured_height, physics))
    rollout = Rollout(scene, physics.timeout, judge)
    with scene.quiet():
        try:
            rollout.begin(placed, start, physics.settle_time)
            for target, action in zip(script.targets, script.grips, strict=True):
                rollout.toward(target, float(action))
        except Diverged as trouble:
            return None, str(trouble)
        outcome, reason = judge.verdict(rollout)
    if outcome is not AttemptOutcome.SUCCESS:
        return None, f"{outcome}: {reason}"
    return recorded(rollout, script.segments), ""


def sampled(motion: Motion) -> Floats:
    """Return (t, 4, 4) poses of a planned motion at the control rate, the start left out, at least one."""
    poses = motion.sampled(1 / CONTROL_RATE).poses
    return poses[1:] if len(poses) > 1 else poses


def recorded(rollout: Rollout, segments: tuple[Segment, ...]) -> Trajectory:
    """Return the trajectory of a rollout: each action, with the poses before it."""
    count = len(rollout.actions)
    return Trajectory(
        times=np.arange(count) / CONTROL_RATE,
        T_world_target=np.array(rollout.targets),
        gripper=np.array(rollout.grips),
        T_world_gripper=np.array(rollout.hands[:count]),
        T_world_object={DEMONSTRATED: np.array(rollout.objects[:count])},
        segments=segments,
    )


def turned_start(start: Floats, offset: Floats, yaw: float) -> Floats:
    """Return a start (4, 4) moved by `offset` (3,) metres and turned about its z by `yaw` radians."""
    moved = np.array(start)
    moved[:3, 3] += offset
    moved[:3, :3] = moved[:3, :3] @ rotation_about(np.array([0.0, 0.0, yaw]))
    return moved

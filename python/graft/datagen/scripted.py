"""Demonstrations by script: plan a grasp at a contact, fly there, take the object, lift or pour; in physics."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from graft.checks import Floats
from graft.datagen.config import CONTROL_RATE, REACH, Task, checked_force
from graft.datagen.judge import AttemptOutcome, Bounds, Judge
from graft.datagen.retarget import LEVEL, spout_of
from graft.datagen.rollout import Diverged, Rollout, grip_for
from graft.datagen.scene import episode_scene
from graft.datagen.script import LIFT, TILT, closing_actions, script
from graft.errors import InputError
from graft.grasp import PANDA_HAND, Grasp, Gripper, metric_scale, plan_grasps
from graft.grasp.conventions import rigid_inverse
from graft.grasp.planner import AntipodalPlanner
from graft.marking import mark_contact
from graft.motion import Motion, plan_approach
from graft.objects import Contact, Demonstration
from graft.sim import PreparedObject, SimulationConfig, prepare
from graft.trajectory import DEMONSTRATED, Segment, Trajectory

THOROUGH = AntipodalPlanner(samples=400, pairs=300, wider=())
"""What plans grasps: of what lies on the table few pairs can be reached, so more are tried than by default. It looks no
wider by itself: where nothing near a contact holds, the contact moves, and that is decided here."""

TRIED = 20
"""Grasps that are tried, best first, until one holds."""

TOLERANCE = 15.0
"""Degrees by which an object may hang back in the hand of a demonstrated pour."""

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


def demonstrate(
    shown: Demonstration,
    gripper: Gripper = PANDA_HAND,
    *,
    task: Task = "lift",
    physics: SimulationConfig | None = None,
    seed: int = 0,
) -> Demonstration:
    """Return a demonstration of a task, made by script and executed in physics without noise.

    Args:
        shown: The object and where it is taken.
        gripper: The floating hand.
        task: Lift; or lift and pour, towards the spout or, without one, away from the hand.
        physics: Settings.
        seed: Of the planners.

    Returns:
        The same with grasp and trajectory, taken elsewhere on the contact's part, and the contact there, where nothing
        near it holds as the object stands: targets, reached poses, gripper actions, object poses, and the segments
        reach, grasp, lift, for a pour pour, and hold with their signals.

    Raises:
        InputError: No grasp of the first `TRIED` at the contact and on its part held; the message has the last reason.
        MissingExtraError: mujoco is not installed.
    """
    physics = physics or SimulationConfig()
    checked_force(gripper, physics)
    where = f"object {shown.object.name!r}"
    prepared = prepare(shown.object, physics)
    if not prepared.pose.stable:
        raise InputError(f"{where}: no pose in which it stands was found")
    tried, reason = 0, ""
    for contact in (shown.contact, None):
        grasps = plan_grasps(
            shown.object, contact, gripper, part=shown.contact.part, support=prepared.support, planner=THOROUGH,
            k=TRIED, seed=seed,
        )  # fmt: skip
        for grasp in grasps:
            trajectory, reason = _executed(prepared, grasp, task, physics, seed)
            if trajectory is not None:
                return _shown(shown, contact, grasp, trajectory, {"task": task, "made_by": "script", "seed": seed})
        tried += len(grasps)
        if not tried:
            reason = grasps.chief_rejection or "no candidate"
    part = shown.object.parts[shown.contact.part].name
    if not tried:
        raise InputError(f"{where}: gripper {gripper.name!r} cannot hold its part {part!r} as it stands ({reason})")
    raise InputError(f"{where}: none of {tried} grasps held; the last: {reason}")


def _shown(
    shown: Demonstration, contact: Contact | None, grasp: Grasp, trajectory: Trajectory, how: dict[str, Any]
) -> Demonstration:
    """Return the demonstration; where the object was taken elsewhere, its contact is there."""
    metadata = {**shown.metadata, **how, "gripper": grasp.gripper.name}
    if contact is None:
        place = grasp.contacts[0] / metric_scale(shown.object)
        made = mark_contact(
            shown.object, shown.contact.part, place, approach=grasp.pose[:3, 2], name=shown.name, metadata=metadata
        )
        return replace(made, grasp=grasp.pose, trajectory=trajectory)
    if contact.approach is None:
        contact = replace(contact, approach=grasp.pose[:3, 2])
    return replace(shown, contact=contact, grasp=grasp.pose, trajectory=trajectory, metadata=metadata)


def _executed(
    prepared: PreparedObject, grasp: Grasp, task: Task, physics: SimulationConfig, seed: int
) -> tuple[Trajectory | None, str]:
    """Return what was recorded, or None and the reason."""
    placed, start = prepared.T_world_object, start_pose(prepared)
    config = replace(REACH, seed=seed)
    plan = plan_approach(
        prepared.object, grasp, rigid_inverse(placed) @ start, support=prepared.support, config=config,
    )  # fmt: skip
    if not plan.found:
        return None, plan.reason
    transit = placed @ sampled(plan.transit)
    goal = placed @ grasp.pose
    grip = grip_for(plan.opening, grasp.gripper.stroke)
    front = None
    if task == "pour":
        center = prepared.body.center_of_mass
        spout = spout_of(prepared.object, center)
        front = placed[:3, :3] @ (center if spout is None else spout)
        front += 0.0 if spout is not None else placed[:3, 3] - goal[:3, 3]
        front[2] = 0.0
        if np.linalg.norm(front) < LEVEL:
            return None, "the hand is straight above the object, and there is no spout to pour towards"
    told = script(transit, goal, placed @ plan.straight.poses[0], grip, closing_actions(grasp.gripper), front)
    _, scene = episode_scene(prepared.body, physics, grasp.gripper)
    height = LIFT - physics.secured_height
    bounds = Bounds.of(height, physics)
    if task == "pour":
        bounds = Bounds.of(height, physics, TILT - TOLERANCE, spout_of(prepared.object, prepared.body.center_of_mass))
    judge = Judge(bounds)
    rollout = Rollout(scene, physics.timeout, judge)
    with scene.quiet():
        try:
            rollout.begin(placed, start, physics.settle_time)
            for target, action in zip(told.targets, told.grips, strict=True):
                rollout.toward(target, float(action))
        except Diverged as trouble:
            return None, str(trouble)
        outcome, reason = judge.verdict(rollout)
    if outcome is not AttemptOutcome.SUCCESS:
        return None, f"{outcome}: {reason}"
    return recorded(rollout, told.segments), ""


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

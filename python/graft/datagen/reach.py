"""Where an attempt takes the object and how the hand gets there; or why it does not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from graft.checks import Floats
from graft.contact import TransferredContact
from graft.datagen.config import GenerationConfig
from graft.datagen.judge import AttemptOutcome
from graft.datagen.retarget import Source, retargeted
from graft.datagen.rollout import grip_for
from graft.datagen.scripted import THOROUGH, sampled
from graft.grasp import Gripper, plan_grasps
from graft.grasp.conventions import rigid_inverse
from graft.motion import plan_approach, plan_motion
from graft.objects import Contact
from graft.sim import PreparedObject

SEEDS = 2**31
"""Planners take seeds below this."""


@dataclass(frozen=True, eq=False)
class Plan:
    """What was planned for an attempt.

    Attributes:
        outcome: SUCCESS when there is a plan.
        reason: Why there is none.
        grasp: (4, 4) T_object_gripper that the motion is anchored at; None anchors at the object.
        transit: (t, 4, 4) T_world_gripper targets of a planned reach; None replays the source's.
        grip: Gripper action until it closes; None takes the source's.
    """

    outcome: AttemptOutcome = AttemptOutcome.SUCCESS
    reason: str = ""
    grasp: Floats | None = None
    transit: Floats | None = None
    grip: float | None = None


def plan_reach(
    prepared: PreparedObject,
    source: Source,
    contacts: Sequence[TransferredContact],
    placed: Floats,
    start: Floats,
    gripper: Gripper,
    config: GenerationConfig,
    seed: int,
) -> Plan:
    """Plan an attempt as its configuration says.

    Args:
        prepared: The object.
        source: What is replayed.
        contacts: Where it may be taken, best first; not read when the anchor is the object.
        placed: (4, 4) T_world_object.
        start: (4, 4) T_world_gripper.
        gripper: The hand.
        config: How.
        seed: Of the planners.
    """
    if config.anchor == "grasp":
        return _to_grasp(prepared, contacts, placed, start, gripper, config, seed)
    if config.reach == "linear":
        return Plan()
    goal = retargeted(source.targets(source.reach)[:1], source.object_pose(source.reach), placed)[0]
    back = rigid_inverse(placed)
    motion = plan_motion(
        prepared.object, back @ start, back @ goal, gripper,
        support=prepared.support, config=replace(config.motion, seed=seed % SEEDS),
    )  # fmt: skip
    if not motion.found:
        return Plan(AttemptOutcome.NO_MOTION, motion.reason)
    return Plan(transit=placed @ sampled(motion))


def _to_grasp(
    prepared: PreparedObject,
    contacts: Sequence[TransferredContact],
    placed: Floats,
    start: Floats,
    gripper: Gripper,
    config: GenerationConfig,
    seed: int,
) -> Plan:
    """Plan to the first grasp that can be reached, contact by contact, then part by part."""
    if not contacts:
        return Plan(AttemptOutcome.NO_SOURCE, "no contact lands on it")
    why, blocked = "no candidate", ""
    places: list[tuple[Contact | None, int]] = [(t.contact, t.target_part) for t in contacts]
    if config.anywhere:
        places += [(None, part) for part in dict.fromkeys(part for _, part in places)]
    for contact, part in places:
        grasps = plan_grasps(
            prepared.object, contact, gripper,
            part=part, support=prepared.support, planner=THOROUGH, k=config.grasps, seed=seed % SEEDS,
        )  # fmt: skip
        if not len(grasps):
            why = grasps.chief_rejection or why
            continue
        if config.reach == "linear":
            return Plan(grasp=grasps[0].pose)
        for grasp in grasps:
            approach = plan_approach(
                prepared.object, grasp, rigid_inverse(placed) @ start,
                support=prepared.support, config=replace(config.motion, seed=seed % SEEDS),
            )  # fmt: skip
            if approach.found:
                grip = grip_for(approach.opening, gripper.stroke)
                return Plan(grasp=grasp.pose, transit=placed @ sampled(approach.transit), grip=grip)
            blocked = approach.reason
    if blocked:
        return Plan(AttemptOutcome.NO_MOTION, blocked)
    where = "on the contact's part" if config.anywhere else "near the contact"
    return Plan(AttemptOutcome.NO_GRASP, f"no grasp {where}: {why}")

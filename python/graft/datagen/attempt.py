"""One attempt: choose a source, carry its contact over, plan, replay its motion with noise, judge."""

from __future__ import annotations

import hashlib
import json
import time
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from graft.checks import Floats
from graft.datagen.config import CONTROL_RATE, GenerationConfig, Task
from graft.datagen.episode import Episode
from graft.datagen.execution import Execution
from graft.datagen.judge import AttemptOutcome, Bounds, Judge
from graft.datagen.reach import plan_reach
from graft.datagen.retarget import Source, spout_of
from graft.datagen.rollout import Diverged, Rollout
from graft.datagen.scene import episode_scene
from graft.datagen.scripted import recorded, start_pose
from graft.datagen.selection import Chooser
from graft.grasp import Gripper
from graft.library import Library
from graft.objects import PartObject
from graft.sim import PreparedObject, SimulationConfig, prepare
from graft.trajectory import Segment

ENVIRONMENTS: dict[Task, str] = {"lift": "graft/Lift-v0", "pour": "graft/Pour-v0"}
"""What episodes call the environment of a task."""


def derived_seed(*what: str | int) -> int:
    """Return 63 bits that names and numbers tell: the same on any machine, in any process."""
    return int.from_bytes(hashlib.sha256(json.dumps(what).encode()).digest()[:8], "big") >> 1


@dataclass(frozen=True, eq=False)
class Target:
    """An object made ready for many attempts.

    Attributes:
        prepared: In metres, standing.
        chooser: Knows the sources.
    """

    prepared: PreparedObject
    chooser: Chooser

    @classmethod
    def lay(cls, obj: PartObject, library: Library, sources: dict[str, Source], physics: SimulationConfig) -> Target:
        """Let an object come to rest and build its part graph.

        Raises:
            InputError: It has no volume or no plausible size.
        """
        prepared = prepare(obj, physics)
        return cls(prepared, Chooser(library, sources, library.graph(prepared.object)))


@dataclass(frozen=True, eq=False)
class Attempt:
    """What came of an attempt.

    Attributes:
        name: Of its episode: task, object, number.
        object: Name of the object.
        number: Of the attempt on this object.
        seed: hash(run, object, demonstration, number).
        outcome: The class.
        reason: What decided it.
        demonstration: The source; "" when there was none.
        any_step: Whether the object was `graft.datagen.judge.RAISED` above its place at any step: MimicGen's success.
        steps: Actions.
        seconds: Of the wall clock.
        episode: Of a success, when it was asked for.
    """

    name: str
    object: str
    number: int
    seed: int
    outcome: AttemptOutcome
    reason: str
    demonstration: str = ""
    any_step: bool = False
    steps: int = 0
    seconds: float = 0.0
    episode: Episode | None = field(default=None, repr=False)

    def document(self) -> dict[str, Any]:
        """Return the attempt for JSON; the same for the same attempt wherever it ran."""
        return {
            "name": self.name,
            "object": self.object,
            "demonstration": self.demonstration,
            "attempt": self.number,
            "seed": self.seed,
            "outcome": self.outcome.value,
            "reason": self.reason,
            "any_step": self.any_step,
            "steps": self.steps,
        }


def attempt_name(task: str, obj: str, number: int) -> str:
    """Return the name of an attempt, and of its episode."""
    return f"{task}_{obj}_{number:05d}"


def bounds_of(prepared: PreparedObject, config: GenerationConfig, physics: SimulationConfig) -> Bounds:
    """Return what a success of a task on an object must keep within."""
    if config.task == "lift":
        return Bounds.of(config.height, physics)
    return Bounds.of(config.height, physics, config.tilt, spout_of(prepared.object, prepared.body.center_of_mass))


@dataclass(frozen=True)
class _Draw:
    """What an attempt's scene is: the same for every method."""

    placed: Floats
    start: Floats
    physics: SimulationConfig


def draw_scene(prepared: PreparedObject, config: GenerationConfig, seed: int) -> _Draw:
    """Draw the object's pose, the hand's start and the physics of an attempt."""
    rng, ranges = np.random.default_rng(seed), config.random
    u = rng.uniform(-1.0, 1.0, 8)
    yaw = np.radians(ranges.yaw) * u[0]
    turn = np.eye(4)
    turn[:2, :2] = (np.cos(yaw), -np.sin(yaw)), (np.sin(yaw), np.cos(yaw))
    turn[:2, 3] = ranges.place * u[1:3]
    start = start_pose(prepared)
    start[:3, 3] += ranges.start * u[3:6]
    physics = config.physics
    for name, pair, share in (("mass", ranges.mass, u[6]), ("friction", ranges.friction, u[7])):
        if pair is not None:
            physics = replace(physics, **{name: pair[0] + (share + 1) / 2 * (pair[1] - pair[0])})
    return _Draw(turn @ prepared.T_world_object, start, physics)


def run_attempt(
    target: Target, gripper: Gripper, config: GenerationConfig, *, run: int, number: int, keep: bool = True
) -> Attempt:
    """Make one attempt.

    Args:
        target: The object.
        gripper: The floating hand.
        config: How.
        run: Seed of the run.
        number: Of the attempt on this object.
        keep: Whether to return the episode of a success.
    """
    began, prepared, name = time.perf_counter(), target.prepared, target.prepared.object.name
    scene = draw_scene(prepared, config, derived_seed(run, name, number))
    label = attempt_name(config.task, name, number)
    if not prepared.pose.stable:
        seed = derived_seed(run, name, "", number)
        return Attempt(label, name, number, seed, AttemptOutcome.UNSTABLE, "no pose in which it stands was found")
    chooser = target.chooser
    rng = np.random.default_rng(derived_seed(run, name, number, "selection"))
    source = chooser.choose(config.select, rng, scene.placed, scene.start)
    seed = derived_seed(run, name, source.name, number)
    contacts = chooser.contacts(source, config.select, config.contacts) if config.anchor == "grasp" else []
    plan = plan_reach(prepared, source, contacts, scene.placed, scene.start, gripper, config, seed)
    result = Attempt(label, name, number, seed, plan.outcome, plan.reason, source.name)
    if plan.outcome is AttemptOutcome.SUCCESS:
        xml, compiled = episode_scene(prepared.body, scene.physics, gripper)
        judge = Judge(bounds_of(prepared, config, scene.physics))
        rollout = Rollout(compiled, scene.physics.timeout, judge)
        replay = Execution(rollout, judge, source, plan, config, np.random.default_rng(seed), target.prepared)
        with compiled.quiet():
            try:
                rollout.begin(scene.placed, scene.start, scene.physics.settle_time)
                replay.run()
                outcome, reason = judge.verdict(rollout)
            except Diverged as trouble:
                outcome, reason = AttemptOutcome.UNSTABLE, str(trouble)
        result = replace(
            result, outcome=outcome, reason=reason, any_step=judge.any_step, steps=len(rollout.actions),
        )  # fmt: skip
        if keep and outcome is AttemptOutcome.SUCCESS:
            settings = config.document() | {
                "run": run, "attempt": number, "object": name, "mass": scene.physics.mass,
                "friction": scene.physics.friction, "bounds": judge.bounds.document(),
            }  # fmt: skip
            episode = _episode(rollout, replay.segments, label, prepared, xml, gripper, settings, seed, source.name)
            result = replace(result, episode=episode)
    return replace(result, seconds=time.perf_counter() - began)


def _episode(
    rollout: Rollout, segments: list[Segment], name: str, prepared: PreparedObject, xml: str, gripper: Gripper,
    settings: dict[str, Any], seed: int, source: str,
) -> Episode:  # fmt: skip
    count = len(rollout.actions)
    last = np.zeros(count, np.int64)
    last[-1] = 1
    obj = prepared.object
    return Episode(
        name=name,
        trajectory=recorded(rollout, tuple(segments)),
        actions=np.array(rollout.actions),
        states=np.array(rollout.states),
        observations=rollout.observations(),
        rewards=last.astype(np.float64),
        dones=last,
        model_xml=xml,
        env_args={
            "env_name": ENVIRONMENTS[settings["task"]],
            "env_kwargs": {"control_freq": CONTROL_RATE, "gripper": gripper.name, "object": obj.name},
        },
        seed=seed,
        outcome=AttemptOutcome.SUCCESS.value,
        task=f"{settings['task']} the {(obj.category or obj.name).replace('_', ' ')}",
        source=source,
        settings=settings,
    )

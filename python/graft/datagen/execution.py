"""A source's segments, executed on another object action by action, with noise."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from graft.checks import Floats
from graft.datagen.config import CONTROL_RATE, GenerationConfig
from graft.datagen.judge import Judge
from graft.datagen.reach import Plan
from graft.datagen.retarget import CLOSING, HOLD, Source, carried, retargeted, spout_of, upright_frame
from graft.datagen.rollout import Rollout
from graft.datagen.rotations import interpolated, rotation_vector
from graft.sim import PreparedObject
from graft.trajectory import DEMONSTRATED, Segment

JOINED = (0.02, 0.1)
"""Metres and radians: nearer than this the next segment goes on where the last ended, and nothing is interpolated."""


class Execution:
    """One attempt's course.

    Args:
        rollout: Begun.
        judge: Watches it; where it finds the object lost, the course ends.
        source: What is replayed.
        plan: Where the object is taken, and how the hand gets there.
        config: Noise, interpolation, settling, hold.
        rng: Of the noise.
        prepared: The object.

    Attributes:
        segments: What was done so far, by stretches.
    """

    def __init__(
        self, rollout: Rollout, judge: Judge, source: Source, plan: Plan, config: GenerationConfig, rng: Generator,
        prepared: PreparedObject,
    ) -> None:  # fmt: skip
        self.rollout, self.judge, self.source, self.plan = rollout, judge, source, plan
        self.config, self.rng, self.prepared = config, rng, prepared
        self.spout = spout_of(prepared.object, prepared.body.center_of_mass)
        self.segments: list[Segment] = []
        self._grip = plan.grip if plan.grip is not None else float(source.trajectory.gripper[0])

    def run(self) -> None:
        """Reach, replay, hold; stops where the object is lost."""
        source, config = self.source, self.config
        first = 0
        if self.plan.transit is not None:
            first = source.reach
            for target in self.plan.transit:
                self._go(target, self._grip)
            before = source.trajectory.segments[first - 1] if first else None
            name, signal = ("reach", "reached") if before is None else (before.name, before.signal)
            self._end(name, signal)
        for index in range(first, len(source.trajectory.segments)):
            self._segment(index)
            if self.judge.lost:
                break
        last = self.rollout.aim
        for _ in range(round(config.hold * CONTROL_RATE)):
            if self.judge.lost:
                break
            self.rollout.toward(last, self._grip)
        self._end(HOLD, None)

    def _segment(self, index: int) -> None:
        """Replay one segment: interpolate to it, settle before the gripper turns."""
        source, rollout, config = self.source, self.rollout, self.config
        segment = source.trajectory.segments[index]
        targets = self._targets(index)
        if _apart(rollout.aim, targets[0]):
            for target in interpolated(rollout.aim, targets[0], config.interpolation):
                rollout.toward(target, self._grip)
        grips = source.trajectory.gripper[segment.start : segment.end]
        for target, told in zip(targets, grips, strict=True):
            grip = float(told) if self.plan.grip is None or told > CLOSING else self.plan.grip
            if (grip > CLOSING) != (self._grip > CLOSING):
                self._settle(target)
            self._grip = grip
            self._go(target, grip)
            if self.judge.lost:
                break
        self._end(segment.name, None if self.judge.lost else segment.signal)

    def _targets(self, index: int) -> Floats:
        source, rollout = self.source, self.rollout
        now, given = rollout.objects[-1], source.targets(index)
        if self.plan.grasp is None:
            return retargeted(given, source.object_pose(index), now)
        grasp = now @ self.plan.grasp
        if index <= source.reach:
            return retargeted(given, source.object_pose(index) @ source.grasp, grasp)
        center = now[:3, :3] @ self.prepared.body.center_of_mass + now[:3, 3]
        front = None if self.spout is None else now[:3, :3] @ self.spout
        upright = upright_frame(grasp[:3, 3], center, front)
        return carried(given, source.upright(index), upright, rollout.aim)

    def _settle(self, target: Floats) -> None:
        """Wait at a target, without noise, until the hand is there."""
        for _ in range(self.config.settle):
            self.rollout.toward(target, self._grip)
            if np.linalg.norm(self.rollout.hands[-1][:3, 3] - target[:3, 3]) < self.config.settled:
                break

    def _go(self, target: Floats, grip: float) -> None:
        self.rollout.toward(target, grip, self.config.noise, self.rng)

    def _end(self, name: str, signal: str | None) -> None:
        begin, end = self.segments[-1].end if self.segments else 0, len(self.rollout.actions)
        if end > begin:
            self.segments.append(Segment(name, begin, end, DEMONSTRATED, signal))


def _apart(a: Floats, b: Floats) -> bool:
    """Whether two targets are further apart than `JOINED`."""
    far, turned = JOINED
    return bool(
        np.linalg.norm(a[:3, 3] - b[:3, 3]) > far or np.linalg.norm(rotation_vector(a[:3, :3] @ b[:3, :3].T)) > turned
    )

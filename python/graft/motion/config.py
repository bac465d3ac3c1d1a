"""How to plan and how fast to move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graft.errors import InputError

Settings = tuple[float, float, float, int, float | None, int, int]
"""What the core reads: clearance, step, goal bias, iterations, time limit, shortcuts, seed."""


@dataclass(frozen=True)
class MotionConfig:
    """How to plan and how fast to move.

    Attributes:
        clearance: Metres. Motions that come nearer to an obstacle may be refused; nothing ever touches.
        step: A tree grows by at most this at once: metres that a point of the hand or the arm travels at most.
        goal_bias: Share of growths that go straight for the other end, in [0, 1].
        max_iterations: Growths of a tree before giving up; 0 tries the direct motion only.
        time_limit: Seconds before giving up; None for no limit. With one, results depend on the machine.
        shortcuts: Random shortcuts that are tried on a path.
        margin: The hand's workspace is the box of object, start and goal, this much larger on every side, metres.
        linear_speed: Of the gripper's TCP, metres a second. A third of a Panda's 1.7.
        angular_speed: Of the gripper, radians a second. A third of a Panda's 2.5.
        joint_speed: Of every hinge of an arm, radians a second (of a slide, metres a second). A Panda's slowest
            joints make 2.175.
        seed: Of the random numbers.
    """

    clearance: float = 0.001
    step: float = 0.2
    goal_bias: float = 0.05
    max_iterations: int = 5000
    time_limit: float | None = None
    shortcuts: int = 30
    margin: float = 0.3
    linear_speed: float = 0.5
    angular_speed: float = 0.8
    joint_speed: float = 1.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("clearance", "step", "linear_speed", "angular_speed", "joint_speed"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"{name}: expected a positive number, got {value}")
        if not 0 <= self.goal_bias <= 1:
            raise InputError(f"goal_bias: expected a number in [0, 1], got {self.goal_bias}")
        if not (np.isfinite(self.margin) and self.margin >= 0):
            raise InputError(f"margin: expected metres, at least 0, got {self.margin}")
        for name in ("max_iterations", "shortcuts", "seed"):
            number = getattr(self, name)
            if not (isinstance(number, int | np.integer) and 0 <= number < 2**63):
                raise InputError(f"{name}: expected an integer, at least 0, got {number}")
        if self.time_limit is not None and not (np.isfinite(self.time_limit) and self.time_limit > 0):
            raise InputError(f"time_limit: expected seconds above 0 or None, got {self.time_limit}")

    @property
    def settings(self) -> Settings:
        """What the core reads."""
        return (
            float(self.clearance),
            float(self.step),
            float(self.goal_bias),
            int(self.max_iterations),
            None if self.time_limit is None else float(self.time_limit),
            int(self.shortcuts),
            int(self.seed),
        )

    def reason(self, outcome: int, iterations: int, nodes: int) -> str:
        """Say why there is no motion, given how the core ended; "" for outcome 0, a motion."""
        near = f"nearer than {1e3 * self.clearance:g} mm to an obstacle"
        return (
            "",
            f"start in collision, or {near}",
            f"goal in collision, or {near}",
            f"no way found after {iterations} iterations and {nodes} nodes",
            f"timed out after {self.time_limit} s, {iterations} iterations and {nodes} nodes",
        )[outcome]

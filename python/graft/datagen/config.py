"""Every number of an attempt, with its unit and where it comes from."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, fields
from typing import Any, Literal, get_args

import numpy as np

from graft.errors import InputError
from graft.grasp import Gripper
from graft.motion import MotionConfig
from graft.sim import SimulationConfig

Selection = Literal["graft", "random", "nearest_neighbor_object", "nearest_neighbor_robot_distance"]
Anchor = Literal["grasp", "object"]
Reach = Literal["rrt", "linear"]
Task = Literal["lift", "pour"]

TASKS: tuple[Task, ...] = get_args(Task)

CONTROL_RATE = 20.0
"""Actions a second; robosuite's, and so MimicGen's."""

LARGEST_MOVE, LARGEST_TURN = 0.05, 0.5
"""Metres and radians that an action of 1 moves and turns the hand; those of robosuite's OSC_POSE controller."""

REACH = MotionConfig(linear_speed=0.5, angular_speed=1.6)
"""How a reach is planned. Turning at .08 rad a step is a sixth of what an action can ask for."""


@dataclass(frozen=True)
class Randomisation:
    """Ranges that every attempt draws its scene from, evenly.

    Attributes:
        yaw: Half range of the object's turn about the vertical, degrees.
        place: Half range of its place along x and y, metres.
        start: Half range of the hand's start along each axis, metres.
        mass: Lowest and highest of the object, kilograms; None keeps the simulation's.
        friction: Lowest and highest; None keeps the simulation's.
    """

    yaw: float = 180.0
    place: float = 0.1
    start: float = 0.02
    mass: tuple[float, float] | None = None
    friction: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        for name in ("yaw", "place", "start"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise InputError(f"randomisation {name}: expected a number of at least 0, got {value}")
        for name in ("mass", "friction"):
            pair = getattr(self, name)
            if pair is not None and not (np.isfinite(pair).all() and 0 < pair[0] <= pair[1]):
                raise InputError(f"randomisation {name}: expected 0 < low <= high, got {pair[0]:g} {pair[1]:g}")


@dataclass(frozen=True)
class GenerationConfig:
    """How attempts are made. The defaults are graft's; `vanilla` gives MimicGen's.

    Attributes:
        task: What is done.
        select: How the source is picked: graft's retrieval and vote, or MimicGen's strategies.
        anchor: What a source's motion is replayed relative to: the planned grasp, or the object's body frame.
        reach: How the hand gets to where the interaction begins: RRT-Connect around the object, or MimicGen's way,
            linear interpolation to the source's own reach, which is then replayed.
        noise: Standard deviation of what is added to normalised delta actions, MimicGen's; 0 switches it off.
        interpolation: Steps from the last target to the first of a segment, without noise; MimicGen's.
        settle: Most steps that the hand is given to come to rest before the gripper turns, without noise; the same for
            every method.
        settled: Metres from its target within which the hand is at rest.
        grasps: Most planned grasps to which a reach is planned, best first.
        contacts: Most contacts, in the order of the vote, at which grasps are planned.
        anywhere: Whether the part that a contact lies on is taken anywhere else where nothing near the contacts can be
            held and reached: the contact of an object that lies may face the table.
        height: Metres that the object must have been lifted by when the hold ends.
        tilt: Degrees by which a pour must have tilted the spout below the horizontal when the hold ends.
        hold: Seconds at the last target before the outcome is judged.
        random: What each attempt draws.
        physics: Of the simulation and its outcomes.
        motion: Of the reach.
    """

    task: Task = "lift"
    select: Selection = "graft"
    anchor: Anchor = "grasp"
    reach: Reach = "rrt"
    noise: float = 0.05
    interpolation: int = 5
    settle: int = 10
    settled: float = 0.002
    grasps: int = 10
    contacts: int = 3
    anywhere: bool = True
    height: float = 0.1
    tilt: float = 40.0
    hold: float = 1.0
    random: Randomisation = field(default_factory=Randomisation)
    physics: SimulationConfig = field(default_factory=SimulationConfig)
    motion: MotionConfig = REACH

    def __post_init__(self) -> None:
        choices = (("task", Task), ("select", Selection), ("anchor", Anchor), ("reach", Reach))
        for name, kind in choices:
            if getattr(self, name) not in get_args(kind):
                raise InputError(f"{name}: expected one of {', '.join(get_args(kind))}, got {getattr(self, name)!r}")
        for name in ("noise", "settled", "height", "tilt", "hold"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise InputError(f"{name}: expected a number of at least 0, got {value}")
        for name, least in (("interpolation", 1), ("settle", 0), ("grasps", 1), ("contacts", 1)):
            if getattr(self, name) < least:
                raise InputError(f"{name}: expected at least {least}, got {getattr(self, name)}")
        steps = 1 / (CONTROL_RATE * self.physics.timestep)
        if abs(steps - round(steps)) > 1e-6 * steps:
            raise InputError(f"timestep: expected a whole number of steps in 1/{CONTROL_RATE:g} s, got {steps:g}")

    def document(self) -> dict[str, Any]:
        """Return the settings for JSON."""
        document = {f.name: getattr(self, f.name) for f in fields(self)}
        random = {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(self.random).items()}
        return document | {"random": random, "physics": self.physics.document(), "motion": asdict(self.motion)}


def vanilla(
    *,
    task: Task = "lift",
    select: Selection = "random",
    noise: float = GenerationConfig.noise,
    random: Randomisation | None = None,
    physics: SimulationConfig | None = None,
) -> GenerationConfig:
    """Return MimicGen as published: body frames, linear reach, a random source."""
    return GenerationConfig(
        task=task, select=select, anchor="object", reach="linear", noise=noise,
        random=random or Randomisation(), physics=physics or SimulationConfig(),
    )  # fmt: skip


def checked_force(gripper: Gripper, physics: SimulationConfig) -> None:
    """Refuse a closing force that the gripper does not give.

    Raises:
        InputError: It does not.
    """
    if physics.force > gripper.max_force:
        raise InputError(
            f"force: gripper {gripper.name!r} gives at most {gripper.max_force:g} N a finger, got {physics.force:g}"
        )

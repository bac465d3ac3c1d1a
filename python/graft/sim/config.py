"""Every number of a trial, with its unit and where it comes from."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from graft.errors import InputError


@dataclass(frozen=True)
class SimulationConfig:
    """Settings of the physics and of a trial; saved in every result.

    The paper names neither friction nor force nor mass; the defaults are those at which results are published, and
    `graft evaluate simulation` shows how outcomes depend on them.

    Attributes:
        friction: Sliding friction between pads and object, and between object and table (plastic on rubber).
        torsional_friction: Metres; torque about a contact's normal over its force (MuJoCo's default).
        force: Newtons that each finger presses with.
        mass: Of the object, kilograms, spread evenly.
        gravity: Metres per second squared, downwards.
        timestep: Seconds.
        impratio: How much stiffer friction is than the normal force; 1 lets held objects creep, 100 sinks pads into walls.
        condim: Dimensions of a contact: 3 slides, 4 also twists, 6 also rolls.
        contact_solref: Time constant in seconds and damping ratio of contacts.
        contact_solimp: Lowest and highest impedance, and the width in metres between them.
        weld_solref: Likewise of the weld by which the hand follows its path.
        approach_distance: Metres from the pre-grasp straight to the grasp.
        approach_speed: Metres per second.
        closing_speed: Metres per second of each finger before it touches.
        squeeze_time: Seconds that the fingers press before the lift.
        lift_height: Metres.
        lift_speed: Metres per second.
        hold_time: Seconds at the top.
        shake_amplitude: Metres, to and fro along each world axis after holding; 0 leaves the shake out.
        shake_frequency: Hertz, three periods an axis.
        tilt: Degrees by which the hand is turned to both sides about its approach's horizontal normal; 0 leaves it out.
        tilt_speed: Degrees per second.
        secured_height: Metres of lift after which both pads must carry.
        least_force: Newtons that a pad must carry to count.
        least_rise: Share of the lift that the object's point between the pads must rise by.
        slip_distance: Metres that the object may move between the pads, measured where the grasp's centre was.
        slip_angle: Degrees that it may turn in the hand.
        drift_distance: Metres that the object may move before it is touched.
        drift_angle: Degrees, likewise.
        settle_time: Seconds at rest before the approach.
        position_noise: Standard deviation of the reached grasp's place, metres along each axis.
        angle_noise: Standard deviation of its rotation, degrees about each axis.
        seed: Of the noise.
        timeout: Seconds of wall clock after which a trial is given up.
    """

    friction: float = 0.5
    torsional_friction: float = 0.005
    force: float = 15.0
    mass: float = 0.4
    gravity: float = 9.81
    timestep: float = 0.002
    impratio: float = 20.0
    condim: int = 4
    contact_solref: tuple[float, float] = (0.008, 1.0)
    contact_solimp: tuple[float, float, float] = (0.95, 0.99, 0.001)
    weld_solref: tuple[float, float] = (0.01, 1.0)
    approach_distance: float = 0.08
    approach_speed: float = 0.25
    closing_speed: float = 0.1
    squeeze_time: float = 0.2
    lift_height: float = 0.2
    lift_speed: float = 0.25
    hold_time: float = 1.0
    shake_amplitude: float = 0.0
    shake_frequency: float = 3.0
    tilt: float = 0.0
    tilt_speed: float = 90.0
    secured_height: float = 0.02
    least_force: float = 0.5
    least_rise: float = 0.8
    slip_distance: float = 0.02
    slip_angle: float = 45.0
    drift_distance: float = 0.005
    drift_angle: float = 5.0
    settle_time: float = 0.1
    position_noise: float = 0.0
    angle_noise: float = 0.0
    seed: int = 0
    timeout: float = 20.0

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not np.isfinite(value).all():
                raise InputError(f"simulation {entry.name}: expected finite numbers, got {value}")
            low_open = entry.name in _POSITIVE
            least = np.min(value)
            if least < 0 or (low_open and least <= 0):
                wanted = "a positive number" if low_open else "at least 0"
                raise InputError(f"simulation {entry.name}: expected {wanted}, got {value}")
        if self.condim not in (3, 4, 6):
            raise InputError(f"simulation condim: expected 3, 4 or 6, got {self.condim}")
        if self.timestep > LONGEST_STEP:
            raise InputError(f"simulation timestep: expected at most {LONGEST_STEP:g} s, got {self.timestep:g}")
        if self.lift_height < self.secured_height:
            raise InputError(
                f"simulation lift_height: expected at least secured_height {self.secured_height:g} m, got "
                f"{self.lift_height:g}"
            )

    def document(self) -> dict[str, Any]:
        """Return the settings for JSON."""
        return {key: list(value) if isinstance(value, tuple) else value for key, value in asdict(self).items()}


LONGEST_STEP = 0.005
"""Seconds; MuJoCo wants a contact's time constant to be at least two steps, and fast fingers to be caught."""

_POSITIVE = {
    "force", "mass", "gravity", "timestep", "impratio", "contact_solref", "contact_solimp", "weld_solref",
    "approach_speed", "closing_speed", "lift_height", "lift_speed", "shake_frequency", "tilt_speed", "timeout",
}  # fmt: skip

"""What came of an attempt: the same classes as a trial of `graft.sim`, told from actions and scene alone."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from graft.checks import Floats
from graft.datagen.retarget import CLOSING, LEVEL
from graft.datagen.rollout import Rollout
from graft.sim import SimulationConfig
from graft.sim.poses import displacement

RAISED = 0.04
"""Metres that the object must have risen by at any step to count as robosuite's Lift and MimicGen count success."""

CHECKED = 2
"""Actions, together a tenth of a second, that forces are averaged over; a grasp in motion flickers."""


class AttemptOutcome(StrEnum):
    """How attempts end; the classes of `graft.sim.Outcome`, and what can go wrong before the physics."""

    SUCCESS = "success"
    """Held and high enough at the end of the hold."""
    NO_SOURCE = "no_source"
    """No demonstration has a contact that lands on the object."""
    NO_GRASP = "no_grasp"
    """No grasp without collision within the stroke near the contacts."""
    NO_MOTION = "no_motion"
    """No collision-free reach to where the interaction begins."""
    GRASP_FAILURE = "grasp_failure"
    """After a lift of `secured_height` not both fingers carried."""
    SLIPPAGE = "slippage"
    """Secured, but lost, lagging or slipped at the end."""
    NOT_POURED = "not_poured"
    """Held at the end, but not tilted towards its front as far as asked."""
    UNSTABLE = "unstable"
    """The object does not stand, the simulation diverged, or the worker died."""
    INVALID = "invalid"
    """The object cannot be simulated: no volume, no plausible size."""


@dataclass(frozen=True)
class Bounds:
    """What a success must keep within; numbers as in `graft.sim.SimulationConfig`.

    Attributes:
        height: Metres that the object's point between the pads must have risen by at the end.
        secured_height: Metres of lift after which both pads must carry.
        least_force: Newtons.
        slip_distance: Metres.
        slip_angle: Degrees.
        tilt: Degrees by which the front must point below the horizontal at the end; 0 asks for none.
        front: (3,) of the object, its frame; None is from the hand to the centre of mass when it closes. Levelled.
    """

    height: float
    secured_height: float = SimulationConfig.secured_height
    least_force: float = SimulationConfig.least_force
    slip_distance: float = SimulationConfig.slip_distance
    slip_angle: float = SimulationConfig.slip_angle
    tilt: float = 0.0
    front: tuple[float, ...] | None = None

    @classmethod
    def of(cls, height: float, physics: SimulationConfig, tilt: float = 0.0, front: Floats | None = None) -> Bounds:
        """Return the bounds of a simulation."""
        return cls(
            height, physics.secured_height, physics.least_force, physics.slip_distance, physics.slip_angle,
            tilt, None if front is None else tuple(front.tolist()),
        )  # fmt: skip

    def document(self) -> dict[str, Any]:
        """Return the bounds for JSON."""
        return asdict(self)


class Judge:
    """Watches a rollout, action by action."""

    def __init__(self, bounds: Bounds) -> None:
        self.bounds = bounds
        self.any_step = False
        self.lost = False
        self._height: float | None = None
        self._begun: Floats | None = None
        self._hand = np.eye(4)
        self._secured: tuple[float, float] | None = None
        self._reference: tuple[Floats, Floats] | None = None
        self._forces: list[tuple[float, float]] = []

    def __call__(self, rollout: Rollout) -> None:
        """Look at the scene after an action."""
        scene = rollout.scene
        if self._height is None:
            if rollout.grips[-1] <= CLOSING:
                return
            self._height, self._begun = float(rollout.hands[-2][2, 3]), rollout.objects[-2]
            self._hand = rollout.hands[-2]
        assert self._begun is not None
        self._forces.append(scene.finger_forces())
        pose = rollout.objects[-1]
        center = scene.center_of_mass
        self.any_step |= bool(_height(pose, center) - _height(self._begun, center) >= RAISED)
        rise = float(rollout.hands[-1][2, 3]) - self._height
        if self._reference is None and rise >= self.bounds.secured_height / 2:
            self._reference = (scene.object_in_hand(), scene.grasp_point_on_object())
        if self._secured is None and rise >= self.bounds.secured_height:
            self._secured = self._mean()
        if self._secured is not None and max(self._mean()) == 0.0:
            self.lost = True

    def verdict(self, rollout: Rollout) -> tuple[AttemptOutcome, str]:
        """Return outcome and reason at the end."""
        bounds, scene = self.bounds, rollout.scene
        if self._height is None:
            return AttemptOutcome.GRASP_FAILURE, "the gripper never closed"
        if self._secured is None or self._reference is None or self._begun is None:
            return AttemptOutcome.GRASP_FAILURE, f"the hand rose less than {1000 * bounds.secured_height:.0f} mm"
        if min(self._secured) <= bounds.least_force:
            left, right = self._secured
            return (
                AttemptOutcome.GRASP_FAILURE,
                f"after a lift of {1000 * bounds.secured_height:.0f} mm the fingers carry {left:.2f} and {right:.2f} N",
            )
        left, right = self._mean()
        if min(left, right) <= bounds.least_force:
            return AttemptOutcome.SLIPPAGE, f"at the end the fingers carry {left:.2f} and {right:.2f} N"
        held, spot = self._reference
        rise = scene.height(spot) - _height(self._begun, spot)
        if rise < bounds.height:
            return AttemptOutcome.SLIPPAGE, f"it rose {1000 * rise:.0f} mm, {1000 * bounds.height:.0f} mm are asked"
        if scene.object_touches_table():
            return AttemptOutcome.SLIPPAGE, "it still touches the table"
        slip, angle = displacement(held, scene.object_in_hand(), spot)
        if slip > bounds.slip_distance:
            return AttemptOutcome.SLIPPAGE, f"it slipped {1000 * slip:.1f} mm between the fingers"
        if angle > bounds.slip_angle:
            return AttemptOutcome.SLIPPAGE, f"it turned {angle:.0f} degrees in the hand"
        if bounds.tilt > 0:
            tilted = self._tilted(rollout.objects[-1], self._begun, scene.center_of_mass)
            if tilted < bounds.tilt:
                return AttemptOutcome.NOT_POURED, f"tilted by {tilted:.0f} of {bounds.tilt:.0f} degrees"
        return AttemptOutcome.SUCCESS, "held"

    def _tilted(self, now: Floats, begun: Floats, center: Floats) -> float:
        """Return by how many degrees the front, level when the gripper closed, points below the horizontal."""
        if self.bounds.front is None:
            front = begun[:3, :3] @ center + begun[:3, 3] - self._hand[:3, 3]
        else:
            front = begun[:3, :3] @ np.array(self.bounds.front)
        level = np.array([front[0], front[1], 0.0])
        length = float(np.linalg.norm(level))
        if length < LEVEL:
            return 0.0
        turned = now[:3, :3] @ begun[:3, :3].T @ (level / length)
        return float(np.degrees(np.arcsin(np.clip(-turned[2], -1.0, 1.0))))

    def _mean(self) -> tuple[float, float]:
        left, right = np.mean(self._forces[-CHECKED:], axis=0)
        return float(left), float(right)


def _height(pose: Floats, point: Floats) -> float:
    return float(pose[2, :3] @ point + pose[2, 3])

"""What came of a trial, with the numbers behind it."""

from __future__ import annotations

import platform
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from graft import __version__
from graft.grasp import Grasp
from graft.objects import Floats
from graft.sim.config import SimulationConfig


class Outcome(StrEnum):
    """The classes of the paper's table 2 (success, no grasp AG, grasp failure GF, slippage SL), and unstable scenes."""

    SUCCESS = "success"
    """Lifted, held, and it neither slipped nor turned in the hand beyond the bounds."""
    NO_GRASP = "no_grasp"
    """The planner found no grasp without collision within the stroke near the contact."""
    GRASP_FAILURE = "grasp_failure"
    """After closing and a lift of `secured_height` not both fingers carried `least_force`."""
    SLIPPAGE = "slippage"
    """Secured, but lost, lagging or slipped at the end."""
    UNSTABLE = "unstable"
    """The scene is no trial: it diverged, the object moved before it was touched, or time ran out."""


@dataclass(frozen=True)
class Measurements:
    """What was measured; None when the trial ended before.

    Attributes:
        drift_distance: Metres that the centre of mass moved before anything touched the object.
        drift_angle: Degrees, likewise.
        touched_before_closing: Whether the hand touched the object on its way.
        pushed_distance: Metres that the centre of mass had moved when the fingers began to close.
        pushed_angle: Degrees, likewise.
        table_contact: Whether the hand touched the table on its way.
        closed_forces: Newtons on the fingers at +y and -y after closing.
        closed_width: Metres between the pads then.
        secured_forces: Newtons after the lift by `secured_height`.
        final_forces: Newtons at the end.
        lift: Metres that the hand rose.
        rise: Metres that the object's point between the pads rose.
        center_rise: Metres that the centre of mass rose: less than `rise` when the object turned in the hand.
        slip_distance: Metres that the object's point between the pads moved in the hand from closing to the end.
        slip_angle: Degrees that the object turned in the hand, likewise.
    """

    drift_distance: float | None = None
    drift_angle: float | None = None
    touched_before_closing: bool | None = None
    pushed_distance: float | None = None
    pushed_angle: float | None = None
    table_contact: bool | None = None
    closed_forces: tuple[float, float] | None = None
    closed_width: float | None = None
    secured_forces: tuple[float, float] | None = None
    final_forces: tuple[float, float] | None = None
    lift: float | None = None
    rise: float | None = None
    center_rise: float | None = None
    slip_distance: float | None = None
    slip_angle: float | None = None


@dataclass(frozen=True, eq=False)
class Trial:
    """One grasp in physics.

    Attributes:
        outcome: The class.
        reason: One line: what decided it.
        object_name: What was grasped.
        config: All settings.
        grasp: What was tried; None when there was none.
        T_world_object: (4, 4) pose of the object before the trial, metres; None when it never stood.
        measurements: The numbers.
        warnings: What the simulator said.
        simulator: "mujoco" or "sapien".
        versions: Package -> version.
        steps: Steps simulated.
        wall_seconds: Of the wall clock; the only field that differs between runs.
    """

    outcome: Outcome
    reason: str
    object_name: str
    config: SimulationConfig
    grasp: Grasp | None = None
    T_world_object: Floats | None = None
    measurements: Measurements = field(default_factory=Measurements)
    warnings: tuple[str, ...] = ()
    simulator: str = "mujoco"
    versions: dict[str, str] = field(default_factory=lambda: versions_of("mujoco"))
    steps: int = 0
    wall_seconds: float = 0.0

    @classmethod
    def no_grasp(cls, object_name: str, reason: str, config: SimulationConfig | None = None) -> Trial:
        """Return the trial of a planner that gave nothing: outcome NO_GRASP."""
        return cls(Outcome.NO_GRASP, reason, object_name, config or SimulationConfig())

    @property
    def succeeded(self) -> bool:
        """Whether the outcome is SUCCESS."""
        return self.outcome is Outcome.SUCCESS

    def document(self, *, timing: bool = True) -> dict[str, Any]:
        """Return the trial for JSON: strings, finite numbers, lists.

        Args:
            timing: Whether to say how long it took; without it two runs of a trial give the same document.
        """
        grasp = None
        if self.grasp is not None:
            grasp = {
                "pose": self.grasp.pose.tolist(),
                "width": self.grasp.width,
                "score": self.grasp.score,
                "contacts": self.grasp.contacts.tolist(),
                "distance": self.grasp.distance,
                "gripper": self.grasp.gripper.name,
            }
        measured = {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(self.measurements).items()}
        document = {
            "object": self.object_name,
            "outcome": self.outcome.value,
            "reason": self.reason,
            "measurements": measured,
            "warnings": list(self.warnings),
            "grasp": grasp,
            "T_world_object": None if self.T_world_object is None else self.T_world_object.tolist(),
            "steps": self.steps,
            "config": self.config.document(),
            "simulator": self.simulator,
            "versions": dict(self.versions),
        }
        return document | {"wall_seconds": self.wall_seconds} if timing else document


def versions_of(engine: str) -> dict[str, str]:
    """Return the versions that a trial's numbers depend on."""
    return {
        "graft": __version__,
        "numpy": np.__version__,
        "python": platform.python_version(),
        engine: _version(engine),
    }


@cache
def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"

"""What a simulator is, so that another one can take MuJoCo's place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from numpy.typing import ArrayLike

from graft.grasp import Grasp
from graft.sim.config import SimulationConfig
from graft.sim.outcome import Trial
from graft.sim.prepare import PreparedObject
from graft.sim.trial import run_trial


@runtime_checkable
class Simulator(Protocol):
    """Tries grasps. It is sent to worker processes, so it must be picklable and hold no open scene."""

    @property
    def name(self) -> str:
        """Of the simulator, for `Trial.simulator`."""

    def simulate(
        self, prepared: PreparedObject, grasp: Grasp, config: SimulationConfig, *, pose: ArrayLike | None = None
    ) -> Trial:
        """Try a grasp on an object standing at `pose` (4, 4), or where it was prepared."""


@dataclass(frozen=True)
class MujocoSimulator:
    """The default."""

    name: str = "mujoco"

    def simulate(
        self, prepared: PreparedObject, grasp: Grasp, config: SimulationConfig, *, pose: ArrayLike | None = None
    ) -> Trial:
        """Try a grasp; see `graft.sim.simulate_grasp`."""
        return run_trial(prepared, grasp, config, pose=pose)

"""`graft simulate TARGET`: does the grasp hold, in physics?"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro
from rich.table import Table

from graft.cli import EXIT_FAILED, EXIT_OK
from graft.cli.grasp import GraspCommand
from graft.cli.options import check_outputs, print_json, print_table, shown, stdout_console
from graft.errors import InputError
from graft.grasp import GraspSet, find_gripper, load_grasps
from graft.grasp.planner import plan_grasps
from graft.objects import PartObject
from graft.sim import Job, PreparedObject, SimulationConfig, Trial, prepare, simulate_grasps
from graft.sim.engine import choose_gl
from graft.sim.pictures import save_trial, view_trial

PICTURES = (".png", ".mp4")
"""What a trial can be saved as."""


@dataclass(frozen=True)
class Simulate(GraspCommand):
    """Try grasps of an object in physics: from a file, or planned as `graft grasp` does.

    Exits with 1 when a trial does not succeed.
    """

    grasps: Path | None = None
    """A file of grasps (.npz, .npy, .json) in the object's frame, instead of planning them."""
    k: Annotated[int, tyro.conf.arg(aliases=["-k"])] = 1
    """How many grasps to try, best first."""
    friction: float = SimulationConfig.friction
    """Between pads and object, and object and table."""
    force: float = SimulationConfig.force
    """Newtons a finger."""
    mass: float = SimulationConfig.mass
    """Of the object, kilograms."""
    shake: float = SimulationConfig.shake_amplitude
    """Metres that the lifted object is shaken by; 0 leaves it out."""
    tilt: float = SimulationConfig.tilt
    """Degrees that the lifted object is tilted by; 0 leaves it out."""
    timeout: float = SimulationConfig.timeout
    """Seconds of wall clock for a trial."""
    workers: int = 0
    """Processes; 0 runs the trials in this one."""
    trials: Path | None = None
    """File of trials, one JSON document a line; trials that it holds are not run again."""
    view: bool = False
    """Show the first trial in MuJoCo's viewer."""
    out: tuple[Path, ...] = ()
    """Files to write of the first trial; the suffix tells what: .png (strip), .mp4 (film)."""

    def run(self) -> int:
        """Load, stand, plan, try, print, draw; returns the exit code."""
        if self.k < 1:
            raise InputError(f"-k: expected at least 1, got {self.k}")
        given = [
            flag
            for flag, value in (
                ("--grasps", self.grasps), ("--library", self.library), ("--contact", self.contact),
                ("--part", self.part),
            )
            if value is not None
        ]  # fmt: skip
        if len(given) > 1:
            raise InputError(f"{' and '.join(given)}: expected one of them, they each say where to grasp")
        check_outputs(self.out, PICTURES)
        config = SimulationConfig(
            friction=self.friction,
            force=self.force,
            mass=self.mass,
            shake_amplitude=self.shake,
            tilt=self.tilt,
            timeout=self.timeout,
            seed=self.seed,
        )
        choose_gl()  # an MJCF target is read by mujoco
        target = self.loading.load(self.target)
        prepared = prepare(target, config)
        grasps = self._grasps(target, prepared)
        trials = simulate_grasps(_jobs(prepared, grasps, config), workers=self.workers, out=self.trials)
        if self.json:
            print_json(_document(prepared, trials))
        else:
            _print_trials(prepared, trials)
        if trials[0].grasp is not None:
            for path in self.out:
                save_trial(path, prepared, trials[0])
            if self.view:
                view_trial(prepared, trials[0])
        return EXIT_OK if all(trial.succeeded for trial in trials) else EXIT_FAILED

    def _grasps(self, target: PartObject, prepared: PreparedObject) -> GraspSet:
        """Return the grasps to try."""
        gripper = find_gripper(self.gripper, packages=self.loading.packages())
        if self.grasps is not None:
            return load_grasps(self.grasps).top(self.k)
        return plan_grasps(
            target,
            self._contact(target),
            gripper,
            part=None if self.part is None else target.part_index(self.part),
            support=prepared.support if self.support == "auto" else None,
            planner=self._planner(),
            k=self.k,
            seed=self.seed,
        )


def _jobs(prepared: PreparedObject, grasps: GraspSet, config: SimulationConfig) -> list[Job]:
    """Return one job a grasp; one without a grasp when there is none."""
    if len(grasps):
        return [Job(f"{i}", prepared, grasp, config) for i, grasp in enumerate(grasps)]
    why = grasps.chief_rejection
    reason = "the planner gave no grasp"
    if why is not None:
        reason = f"no grasp: {grasps.rejected[why]} candidates rejected for {why}"
    return [Job("0", prepared, None, config, reason=reason)]


def _document(prepared: PreparedObject, trials: list[Trial]) -> dict[str, object]:
    """Describe how the object stands and what came of its trials."""
    pose = prepared.pose
    return {
        "object": prepared.object.name,
        "pose": {
            "T_world_object": pose.T_world_object.tolist(),
            "upright": pose.upright,
            "stable": pose.stable,
            "barrier": pose.barrier,
            "settled_angle": pose.settled_angle,
            "drift_distance": pose.drift_distance,
            "drift_angle": pose.drift_angle,
        },
        "pieces": len(prepared.body.pieces),
        "successes": sum(trial.succeeded for trial in trials),
        "trials": [trial.document() for trial in trials],
    }


def _print_trials(prepared: PreparedObject, trials: list[Trial]) -> None:
    """Print one row per trial."""
    console = stdout_console()
    pose = prepared.pose
    stands = ("upright" if pose.upright else "lying") if pose.stable else "not stable"
    console.print(f"[bold]{shown(prepared.object.name)}[/]  {stands}, {len(prepared.body.pieces)} convex pieces")
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("")
    table.add_column("outcome")
    for column in ("pads N", "rise mm", "slip mm", "turn deg", "s"):
        table.add_column(column, justify="right")
    table.add_column("because")
    for index, trial in enumerate(trials, start=1):
        m = trial.measurements
        forces = m.final_forces or m.secured_forces or m.closed_forces
        table.add_row(
            str(index),
            trial.outcome.value,
            "-" if forces is None else " ".join(f"{force:.1f}" for force in forces),
            "-" if m.rise is None else f"{1000 * m.rise:.0f}",
            "-" if m.slip_distance is None else f"{1000 * m.slip_distance:.1f}",
            "-" if m.slip_angle is None else f"{m.slip_angle:.0f}",
            f"{trial.wall_seconds:.2f}",
            shown(trial.reason),
        )
    print_table(console, table)

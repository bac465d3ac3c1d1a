"""`graft demonstrate OBJECT ...`: demonstrations by script, for a library to generate from."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import tyro
from rich.table import Table

from graft import zoo
from graft.cli import EXIT_FAILED, EXIT_OK
from graft.cli.options import print_json, print_table, shown, stdout_console
from graft.datagen.config import Task
from graft.datagen.scripted import demonstrate
from graft.errors import InputError, MissingExtraError, printable
from graft.grasp import find_gripper
from graft.io import load_demonstration, save_demonstration
from graft.io.folder import DEMONSTRATION_FILE
from graft.objects import Demonstration
from graft.sim import SimulationConfig


@dataclass(frozen=True)
class Demonstrate:
    """Make demonstrations by script, executed in physics by a floating hand, and save them as a library.

    Exits with 1 when an object could not be demonstrated; the others are saved.
    """

    objects: tyro.conf.Positional[tuple[str, ...]]
    """Categories of the zoo (mug, teapot, ...), scans of YCB (ycb:mug, ...), folders of demonstrations without a
    trajectory, or zoo for the paper's four demonstrated categories."""
    out: Path
    """Folder of the library; each demonstration is a folder in it."""
    task: Task = "lift"
    """What is shown: lift, or lift and pour towards the spout, without one away from the hand."""
    gripper: str = "panda_hand"
    """panda_hand, robotiq_2f85, or a TOML, MJCF or URDF file."""
    seed: int = 0
    """Chooses the variants of the zoo's objects, and the planners' draws."""
    friction: float = SimulationConfig.friction
    """Between pads and object, and object and table."""
    force: float = SimulationConfig.force
    """Newtons a finger presses with."""
    mass: float = SimulationConfig.mass
    """Of every object, kilograms."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Demonstrate, save, print; returns the exit code."""
        if self.seed < 0:
            raise InputError(f"--seed: expected at least 0, got {self.seed}")
        if not self.objects:
            raise InputError("objects: expected at least one")
        gripper = find_gripper(self.gripper)
        physics = SimulationConfig(friction=self.friction, force=self.force, mass=self.mass)
        names = [name for given in self.objects for name in (zoo.demonstrated() if given == "zoo" else (given,))]
        rows: list[dict[str, object]] = []
        for shown_object in [_shown(name, self.seed) for name in names]:
            row: dict[str, object] = {"demonstration": shown_object.name}
            try:
                made = demonstrate(shown_object, gripper, task=self.task, physics=physics, seed=self.seed)
            except MissingExtraError:
                raise
            except InputError as error:
                rows.append(row | {"steps": None, "reason": str(error)})
                continue
            save_demonstration(self.out / made.name, made)
            assert made.trajectory is not None
            segments = {segment.name: len(segment) for segment in made.trajectory.segments}
            rows.append(row | {"steps": len(made.trajectory), "segments": segments, "reason": ""})
        if self.json:
            print_json({"out": str(self.out), "demonstrations": rows})
        else:
            _print(rows)
            print(f"{printable(str(self.out))}: {sum(not row['reason'] for row in rows)} demonstrations")
        return EXIT_OK if not any(row["reason"] for row in rows) else EXIT_FAILED


def _shown(name: str, seed: int) -> Demonstration:
    """Return the object and the place where it is taken."""
    if name.startswith("ycb:"):
        return zoo.ycb_demonstration(name.removeprefix("ycb:"))
    folder = Path(name)
    if (folder / DEMONSTRATION_FILE).is_file():
        return replace(load_demonstration(folder), trajectory=None, grasp=None)
    return zoo.demonstration(name, seed)


def _print(rows: list[dict[str, object]]) -> None:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("demonstration", "steps", "segments"):
        table.add_column(column)
    for row in rows:
        segments = row.get("segments")
        text = " ".join(f"{k} {v}" for k, v in segments.items()) if isinstance(segments, dict) else str(row["reason"])
        table.add_row(shown(str(row["demonstration"])), str(row["steps"] or "-"), shown(text))
    print_table(stdout_console(), table)

"""`graft generate`: demonstrations by the thousand."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
from rich.progress import Progress as Bar
from rich.table import Table

from graft import zoo
from graft.cli import EXIT_FAILED, EXIT_OK
from graft.cli.options import print_json, print_table, shown, stdout_console
from graft.datagen.config import TASKS, Anchor, GenerationConfig, Randomisation, Reach, Selection, Task, vanilla
from graft.datagen.generate import Progress, Tally, generate
from graft.datagen.judge import AttemptOutcome
from graft.errors import InputError, printable
from graft.grasp import find_gripper
from graft.io import load_object
from graft.library import Library
from graft.objects import PartObject
from graft.sim import SimulationConfig

LINE_SECONDS = 10.0
"""Seconds between two lines of progress where stderr is no terminal."""

MESHES = (".glb", ".gltf", ".obj", ".ply", ".stl", ".off", ".dae", ".xml", ".urdf")
"""Files of a folder that are objects."""


@dataclass(frozen=True)
class Generate:
    """Replay a library's demonstrations on other objects, in physics, and keep what succeeds as training data.

    State-only: no cameras. Run again, it goes on where it was stopped; episodes and failures do not depend on the
    number of workers. Exits with 1 when nothing was kept.
    """

    library: Path
    """Folder of demonstrations with trajectories, as graft demonstrate makes it."""
    out: Path
    """Folder of the run: episodes.hdf5, failures.jsonl, run.json."""
    objects: str = "zoo"
    """Folder of objects (files, or folders with an object.json), zoo (the paper's eight unseen categories) or ycb."""
    n: int = 500
    """Attempts, evenly over the objects."""
    task: str = "lift"
    """What is done."""
    method: Literal["graft", "vanilla"] = "graft"
    """graft, or MimicGen as published: random source, body frames, linear interpolation. The next three override it."""
    select: Selection | None = None
    """How the source is picked."""
    anchor: Anchor | None = None
    """What the motion is replayed relative to: the planned grasp, or the object's body frame."""
    reach: Reach | None = None
    """How the hand gets there: planned by RRT-Connect, or linearly to the source's own reach."""
    noise: float = GenerationConfig.noise
    """Standard deviation added to normalised actions; 0 switches it off."""
    gripper: str = "panda_hand"
    """panda_hand, robotiq_2f85, or a TOML, MJCF or URDF file."""
    height: float = GenerationConfig.height
    """Metres that the object must be up by when the hold ends."""
    tilt: float = GenerationConfig.tilt
    """Degrees by which a pour must have tilted it towards its spout by then."""
    hold: float = GenerationConfig.hold
    """Seconds that it is held."""
    yaw: float = Randomisation.yaw
    """Half range of the object's turn about the vertical, degrees."""
    place: float = Randomisation.place
    """Half range of its place along x and y, metres."""
    mass: tuple[float, float] = (SimulationConfig.mass, SimulationConfig.mass)
    """Range of its mass, kilograms."""
    friction: tuple[float, float] = (SimulationConfig.friction, SimulationConfig.friction)
    """Range of the friction."""
    force: float = SimulationConfig.force
    """Newtons a finger presses with."""
    variants: int = 1
    """Variants of each category of the zoo."""
    seed: int = 0
    """Of the run, and of the zoo's variants."""
    workers: int = 0
    """Processes; 0 works in this one."""
    format: Literal["robomimic", "lerobot"] = "robomimic"
    """lerobot also writes a LeRobot dataset into the folder lerobot, when all attempts are done."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Generate, print the summary; returns the exit code."""
        config = self._config()
        gripper = find_gripper(self.gripper)
        library = Library.open(self.library)
        objects = find_objects(self.objects, self.seed, self.variants)
        with progress_line() as progress:
            tally = generate(
                library, objects, self.out, n=self.n, gripper=gripper, config=config, seed=self.seed,
                workers=self.workers, format=self.format, progress=progress,
            )  # fmt: skip
        if self.json:
            print_json({"out": str(self.out), "config": config.document(), **tally.document()})
        else:
            _print(tally, self.out)
        never = [name for name, counts in tally.outcomes.items() if set(counts) <= _UNHOLDABLE]
        for name in never:
            print(f"graft: {printable(name)}: {gripper.name} found no way to hold it", file=sys.stderr)
        return EXIT_OK if tally.kept else EXIT_FAILED

    def _config(self) -> GenerationConfig:
        task = _task(self.task)
        physics = SimulationConfig(force=self.force, mass=self.mass[0], friction=self.friction[0])
        random = Randomisation(
            yaw=self.yaw,
            place=self.place,
            mass=None if self.mass[0] == self.mass[1] else self.mass,
            friction=None if self.friction[0] == self.friction[1] else self.friction,
        )
        config = vanilla() if self.method == "vanilla" else GenerationConfig()
        return replace(
            config,
            task=task,
            select=self.select or config.select,
            anchor=self.anchor or config.anchor,
            reach=self.reach or config.reach,
            noise=self.noise,
            height=self.height,
            tilt=self.tilt,
            hold=self.hold,
            random=random,
            physics=physics,
        )


_UNHOLDABLE = {AttemptOutcome.NO_GRASP.value, AttemptOutcome.INVALID.value, AttemptOutcome.NO_SOURCE.value}


def _task(name: str) -> Task:
    for task in TASKS:
        if task == name:
            return task
    raise InputError(f"--task: expected one of {', '.join(TASKS)}, got {name!r}")


def find_objects(where: str, seed: int, variants: int) -> list[PartObject]:
    """Return the objects of the zoo's unseen categories, of YCB, or of a folder.

    Raises:
        InputError: There is no such folder, nothing in it, or an object that cannot be read.
    """
    if variants < 1:
        raise InputError(f"--variants: expected at least 1, got {variants}")
    if where == "zoo":
        return [zoo.make(category, seed * variants + i) for category in zoo.unseen() for i in range(variants)]
    if where == "ycb":
        return [zoo.ycb_object(name) for name in zoo.ycb_names()]
    folder = Path(where)
    if not folder.is_dir():
        raise InputError("--objects: expected a folder of objects, zoo or ycb", path=folder)
    entries = [
        path
        for path in sorted(folder.iterdir())
        if (path / "object.json").is_file() or (path.is_file() and path.suffix.lower() in MESHES)
    ]
    if not entries:
        raise InputError(f"--objects: no object in it; expected {', '.join(MESHES)} or folders", path=folder)
    return [replace(load_object(path), name=path.stem if path.is_file() else path.name) for path in entries]


@contextmanager
def progress_line() -> Iterator[Progress]:
    """Show attempts, success rate and time left on stderr: a bar on a terminal, else a line now and then."""
    console = Console(file=sys.stderr)
    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"))
    last = [time.monotonic()]
    with Bar(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("starting", total=None)

        def told(tally: Tally) -> None:
            text = _standing(tally)
            bar.update(task, description=text, completed=tally.done, total=tally.total)
            if not console.is_terminal and time.monotonic() - last[0] > LINE_SECONDS:
                last[0] = time.monotonic()
                print(f"graft: {tally.done} of {tally.total} attempts, {text}", file=sys.stderr, flush=True)

        yield told


def _standing(tally: Tally) -> str:
    left = tally.remaining
    ready = "" if left is None else f", {left / 60:.1f} min left"
    return f"{tally.kept / max(tally.done, 1):.0%} kept{ready}"


def _print(tally: Tally, out: Path) -> None:
    """Print outcomes per object and what was written."""
    kinds = [outcome.value for outcome in AttemptOutcome if tally.counts[outcome.value]]
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("object")
    for column in ("attempts", *kinds):
        table.add_column(column, justify="right")
    for name, counts in tally.outcomes.items():
        table.add_row(shown(name), str(counts.total()), *[str(counts[kind]) for kind in kinds])
    print_table(stdout_console(), table)
    pace = f", {tally.fresh / tally.seconds:.1f} attempts a second" if tally.fresh else ""
    before = f", {tally.resumed} of them from before" if tally.resumed else ""
    print(
        f"{tally.kept} of {tally.done} attempts kept ({tally.kept / max(tally.done, 1):.0%}){before}; "
        f"{tally.seconds:.1f} s{pace}"
    )
    print(printable(str(out)))

"""`graft evaluate generation`: the paper's second claim, in MuJoCo."""

from __future__ import annotations

import io
import json
import os
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from graft import zoo
from graft.cli import EXIT_OK
from graft.cli.evaluation.progress import progress_bar
from graft.cli.evaluation.tables import TABLE_WIDTH, cell
from graft.cli.generate import find_objects
from graft.cli.options import print_json, shown
from graft.datagen.config import GenerationConfig
from graft.datagen.judge import AttemptOutcome
from graft.errors import InputError
from graft.evaluate.generation import (
    GRAFT,
    QUOTED,
    Field,
    GenerationRate,
    GenerationRow,
    above,
    evaluate_generation,
    generation_methods,
    rate,
    ycb_library,
    zoo_library,
)
from graft.grasp import Gripper, find_gripper
from graft.library import Library
from graft.objects import PartObject
from graft.sim import SimulationConfig

HEADS = {
    AttemptOutcome.NO_SOURCE: "NS", AttemptOutcome.NO_GRASP: "AG", AttemptOutcome.NO_MOTION: "NM",
    AttemptOutcome.GRASP_FAILURE: "GF", AttemptOutcome.SLIPPAGE: "SL", AttemptOutcome.UNSTABLE: "UN",
}  # fmt: skip
"""Failure -> the column's head."""


@dataclass(frozen=True)
class Generation:
    """Make training data from demonstrations on other objects: graft, its two switches alone, and MimicGen."""

    objects: str = "zoo"
    """zoo: the paper's four demonstrated categories answer for its eight unseen ones; ycb: every second scan for the
    others; or a folder of objects, with --library."""
    library: Path | None = None
    """Folder of demonstrations with trajectories, instead of scripted ones."""
    n: int = 500
    """Attempts a method, evenly over the objects, rounded up."""
    variants: int = 1
    """Variants of each category of the zoo."""
    gripper: str = "panda_hand"
    """panda_hand, robotiq_2f85, or a TOML, MJCF or URDF file."""
    friction: float = SimulationConfig.friction
    """Between pads and object, and object and table."""
    force: float = SimulationConfig.force
    """Newtons a finger presses with."""
    mass: float = SimulationConfig.mass
    """Of every object, kilograms."""
    noise: float = GenerationConfig.noise
    """Standard deviation added to normalised actions, of every method."""
    seed: int = 0
    """Of variants, places, noise."""
    workers: int = os.cpu_count() or 1
    """Processes; the results do not depend on it, but for their seconds."""
    json: bool = False
    """Print one JSON document and nothing else."""
    out: Path | None = None
    """Folder for rows.jsonl (a stopped run goes on from it), table and JSON."""

    def run(self) -> int:
        """Evaluate and print; returns the exit code."""
        for name, least in (("n", 1), ("workers", 1), ("seed", 0)):
            if getattr(self, name) < least:
                raise InputError(f"--{name}: expected at least {least}, got {getattr(self, name)}")
        gripper, start = find_gripper(self.gripper), time.perf_counter()
        physics = SimulationConfig(friction=self.friction, force=self.force, mass=self.mass)
        with progress_bar() as progress:
            progress("demonstrating", 0, 1)
            library, objects = self._library(gripper), self._objects()
            methods = generation_methods(GenerationConfig(noise=self.noise, physics=physics))
            asked = Field(library, tuple(objects), -(-self.n // len(objects)), self.seed, gripper, methods)
            rows = evaluate_generation(asked, workers=self.workers, out=self.out, progress=progress)
        seconds = time.perf_counter() - start
        text = io.StringIO()
        _print_rates(Console(file=text, width=TABLE_WIDTH), asked, physics, rows)
        result = _document(asked, rows)
        if self.out is not None:
            (self.out / "evaluation.json").write_text(json.dumps(result, indent=1, allow_nan=False))
            (self.out / "table.txt").write_text(text.getvalue())
        if self.json:
            print_json(result)
            return EXIT_OK
        print(text.getvalue(), end="")
        print(f"{len(rows)} attempts in {seconds:.1f} s on {self.workers} processes")
        return EXIT_OK

    def _library(self, gripper: Gripper) -> Library:
        if self.library is not None:
            return Library.open(self.library)
        if self.objects not in ("zoo", "ycb"):
            raise InputError("--objects: a folder needs --library, demonstrations with trajectories")
        return zoo_library(self.seed, gripper) if self.objects == "zoo" else ycb_library(self.seed, gripper)

    def _objects(self) -> list[PartObject]:
        if self.objects == "ycb" and self.library is None:
            return [zoo.ycb_object(name) for name in zoo.ycb_names()[1::2]]
        return find_objects(self.objects, self.seed, self.variants)


def _by(rows: Sequence[GenerationRow], key: str, seed: int) -> list[GenerationRate]:
    names = dict.fromkeys(getattr(row, key) for row in rows)
    return [rate(name, [row for row in rows if getattr(row, key) == name], seed) for name in names]


def _print_rates(console: Console, asked: Field, physics: SimulationConfig, rows: Sequence[GenerationRow]) -> None:
    """Print the paper's figures, the methods, and graft per object."""
    config = asked.methods[GRAFT]
    console.print(
        f"{len(asked.library)} demonstrations, {len(asked.objects)} objects, {asked.attempts} attempts each; gripper "
        f"{asked.gripper.name}, friction {physics.friction:g}, {physics.force:g} N a finger, {physics.mass:g} kg, "
        f"noise {config.noise:g}"
    )
    table = _table("method")
    for name, success in QUOTED.items():
        table.add_row(name, "", f"{success:.2f}", *[""] * (len(HEADS) + 3))
    _fill(console, table, _by(rows, "method", asked.seed))
    for method in asked.methods:
        if method != GRAFT:
            console.print(f"graft above {method}: {cell(above(rows, method, asked.seed), 2, '+')}")
    console.print(
        "\nSR success at the end of the hold; any: raised at any step, which is MimicGen's success; NS no source,"
    )
    console.print(
        "AG no grasp, NM no motion, GF grasp failure, SL slippage, UN unstable; s/kept: seconds of one process"
    )
    console.print("\ngraft per object")
    ours = [row for row in rows if row.method == GRAFT]
    _fill(console, _table("object"), _by(ours, "query", asked.seed))


def _table(first: str) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column(first, no_wrap=True)
    for column in ("attempts", "SR", "any", *HEADS.values(), "sources", "s/kept"):
        table.add_column(column, justify="right", no_wrap=True)
    return table


def _fill(console: Console, table: Table, rates: Sequence[GenerationRate]) -> None:
    for found in rates:
        kept = "-" if found.seconds_per_kept is None else f"{found.seconds_per_kept:.2f}"
        counts = [str(found.counts.get(outcome.value, 0)) for outcome in HEADS]
        table.add_row(
            shown(found.name), str(found.attempts), cell(found.success, 2), f"{found.any_step:.2f}", *counts,
            str(found.sources), kept,
        )  # fmt: skip
    console.print(table)


def _document(asked: Field, rows: Sequence[GenerationRow]) -> dict[str, Any]:
    """Return what was measured as a JSON document."""
    ours = [row for row in rows if row.method == GRAFT]
    return {
        "quoted": dict(QUOTED),
        "attempts": asked.attempts,
        "seed": asked.seed,
        "gripper": asked.gripper.name,
        "configs": {name: config.document() for name, config in asked.methods.items()},
        "methods": [asdict(found) for found in _by(rows, "method", asked.seed)],
        "above": {name: asdict(above(rows, name, asked.seed)) for name in asked.methods if name != GRAFT},
        "objects": [asdict(found) for found in _by(ours, "query", asked.seed)],
        "rows": [asdict(row) for row in rows],
    }

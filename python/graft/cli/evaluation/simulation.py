"""`graft evaluate simulation`: the paper's table 2, in MuJoCo."""

from __future__ import annotations

import io
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import tyro
from rich.console import Console
from rich.table import Table

from graft.cli import EXIT_OK
from graft.cli.evaluation.asked import Asked
from graft.cli.evaluation.progress import progress_bar
from graft.cli.evaluation.tables import TABLE_WIDTH, cell, print_asked
from graft.cli.options import print_json
from graft.errors import InputError
from graft.evaluate.failures import draw_failures
from graft.evaluate.methods import Graft
from graft.evaluate.protocols import Benchmark
from graft.evaluate.runner import described
from graft.evaluate.simulation import Arena, sensitivity, simulate, simulated_methods
from graft.evaluate.trials import OUTCOMES, QUOTED, STEADY, Rate, TrialRow, margins, rate, rates_by, succeeded, usable
from graft.grasp import find_gripper
from graft.sim import SimulationConfig

ONE_VARIANT = Asked(variants=1)
"""The paper has one object of each unseen category."""

PAPER_POSES = 12
"""Random poses in which the paper tries each object."""


@dataclass(frozen=True)
class Simulation:
    """Execute grasps at transferred contacts, beside other ways to choose the place."""

    settings: Annotated[Asked, tyro.conf.OmitArgPrefixes] = ONE_VARIANT
    poses: int = PAPER_POSES
    """Trials per target and method: the target is turned about the vertical and moved at random."""
    gripper: str = "panda_hand"
    """panda_hand, robotiq_2f85, or a TOML, MJCF or URDF file."""
    friction: float = SimulationConfig.friction
    """Between pads and object, and object and table."""
    force: float = SimulationConfig.force
    """Newtons a finger presses with."""
    mass: float = SimulationConfig.mass
    """Of every object, kilograms."""
    sensitivity: bool = False
    """Execute graft's grasps with other friction, force and mass, too."""
    only_graft: bool = False
    """Leave the baselines out."""

    def run(self) -> int:
        """Evaluate, print, draw; returns the exit code."""
        if self.poses < 1:
            raise InputError(f"--poses: expected at least 1, got {self.poses}")
        asked, start = self.settings, time.perf_counter()
        config = SimulationConfig(friction=self.friction, force=self.force, mass=self.mass)
        settings = sensitivity(config) if self.sensitivity else {}
        arena = Arena(self.poses, find_gripper(self.gripper), config, settings)
        methods = [m for m in simulated_methods() if not self.only_graft or m.name == Graft().name]
        with progress_bar() as progress:
            progress("loading and posing", 0, 1)
            benchmark = asked.benchmark()
            rows = simulate(benchmark, methods, arena, workers=asked.workers, out=asked.out, progress=progress)
            seconds = time.perf_counter() - start
            text = io.StringIO()
            console = Console(file=text, width=TABLE_WIDTH)
            _print_trials(console, benchmark, arena, rows)
            result = described(benchmark, methods) | _document(benchmark, arena, rows)
            if asked.out is not None:
                (asked.out / "evaluation.json").write_text(json.dumps(result, indent=1, allow_nan=False))
                (asked.out / "table.txt").write_text(text.getvalue())
                draw_failures(asked.out / "failures.html", benchmark, arena, rows, text.getvalue(), progress)
        if asked.json:
            print_json(result)
            return EXIT_OK
        print(text.getvalue(), end="")
        print(f"{len(rows)} trials in {seconds:.1f} s")
        if asked.out is not None:
            for path in sorted(asked.out.iterdir()):
                print(path)
        return EXIT_OK


def _print_trials(console: Console, benchmark: Benchmark, arena: Arena, rows: Sequence[TrialRow]) -> None:
    """Print the paper's table, per object, and what graft's figures depend on."""
    seed, config = benchmark.posing.seed, arena.config
    print_asked(console, benchmark)
    console.print(
        f"{arena.poses} poses, gripper {arena.gripper.name}, friction {config.friction:g}, "
        f"{config.force:g} N a finger, {config.mass:g} kg"
    )
    plain = [row for row in rows if not row.setting]
    ours = [row for row in plain if row.method == Graft().name]
    table = _table("method")
    for name, success in QUOTED.items():
        table.add_row(name, "", f"{success:.2f}", *[""] * (len(OUTCOMES) - 1 + 3))
    _print_rates(console, table, rates_by(plain, lambda row: row.method, seed))
    for name, good in (("SR", succeeded), ("usable", usable)):
        told = "  ".join(f"{m} {cell(e, 2, '+')}" for m, e in margins(plain, Graft().name, good, seed).items())
        if told:
            console.print(f"graft's {name} above: {told}")
    console.print(
        "\nSR success, AG no grasp found, GF grasp failure, SL slippage, UN unstable; usable: held by a graspable\n"
        f"part to the end; steady: success, turned in the hand by at most {STEADY:g} degrees; fitting: SR where the\n"
        "gripper can hold a graspable part at all"
    )
    console.print("\ngraft per object")
    _print_rates(console, _table("object"), rates_by(ours, lambda row: row.category, seed))
    varied = [row for row in rows if row.setting]
    if varied:
        console.print("\ngraft's grasps in other physics")
        found = [rate("as above", ours, seed), *rates_by(varied, lambda row: row.setting, seed)]
        _print_rates(console, _table("setting"), found)


def _table(first: str) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column(first, no_wrap=True)
    for column in ("trials", *OUTCOMES.values(), "usable", "steady", "fitting"):
        table.add_column(column, justify="right", no_wrap=True)
    return table


def _print_rates(console: Console, table: Table, rates: Sequence[Rate]) -> None:
    for found in rates:
        _, *others = (str(found.counts[outcome.value]) for outcome in OUTCOMES)
        fitting = "-" if found.fitting is None else cell(found.fitting, 2)
        table.add_row(
            found.name,
            str(found.trials),
            cell(found.success, 2),
            *others,
            cell(found.usable, 2),
            cell(found.steady, 2),
            fitting,
        )
    console.print(table)


def _document(benchmark: Benchmark, arena: Arena, rows: Sequence[TrialRow]) -> dict[str, Any]:
    """Return what was measured as a JSON document."""
    seed = benchmark.posing.seed
    plain = [row for row in rows if not row.setting]
    ours = [row for row in plain if row.method == Graft().name]
    return {
        "poses": arena.poses,
        "gripper": arena.gripper.name,
        "config": arena.config.document(),
        "quoted": dict(QUOTED),
        "methods": [asdict(found) for found in rates_by(plain, lambda row: row.method, seed)],
        "margins": {
            "success": {m: asdict(e) for m, e in margins(plain, Graft().name, succeeded, seed).items()},
            "usable": {m: asdict(e) for m, e in margins(plain, Graft().name, usable, seed).items()},
        },
        "objects": [asdict(found) for found in rates_by(ours, lambda row: row.category, seed)],
        "settings": [
            asdict(found) for found in rates_by([row for row in rows if row.setting], lambda row: row.setting, seed)
        ],
        "rows": [asdict(row) for row in rows],
    }

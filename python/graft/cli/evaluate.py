"""`graft evaluate affordance|ablation|diversity`: measure transferred contacts."""

from __future__ import annotations

import io
import json
import os
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar
from rich.table import Table

from graft.cli import EXIT_OK
from graft.cli.options import print_json
from graft.errors import InputError
from graft.evaluate.ablation import ablations
from graft.evaluate.affordance import methods, pictured, worst
from graft.evaluate.baselines import image_methods
from graft.evaluate.diversity import Diversity, diversity, retrieving_methods
from graft.evaluate.intervals import Estimate
from graft.evaluate.methods import Graft, Method
from graft.evaluate.protocols import Benchmark, Posing, from_objects, load_objects, paper
from graft.evaluate.report import (
    QUOTED,
    Summary,
    by_category,
    calibration_error,
    coverage_area,
    coverage_curve,
    document,
    effects,
    summarise,
)
from graft.evaluate.rows import Row
from graft.evaluate.runner import build_graphs, evaluate
from graft.evaluate.work import Progress
from graft.viz import save_scene, save_sheet

WORST = 24
"""Worst cases that are drawn on the sheet."""

WORST_ON_PAGE = 8
"""Worst cases on the page, which is heavier."""

TABLE_WIDTH = 160
"""Characters of a line of the tables, which are the same on a terminal and in the file."""

What = Literal["affordance", "ablation", "diversity"]


@dataclass(frozen=True)
class Asked:
    """What is evaluated, and how."""

    protocol: Literal["paper", "leave-category-out", "within-category", "one-source"] = "paper"
    """paper: the zoo's demonstrated categories answer for its unseen ones. The others need --objects."""
    objects: str | None = None
    """Folder with one folder per labelled object (object.json with graspable_parts), or ycb."""
    source: str | None = None
    """one-source: the object whose demonstrations answer; by default the first of each category in turn."""
    half: Literal["both", "tuning", "reporting"] = "both"
    """Of --objects: tune on one half of the targets, report the other."""
    variants: int = 12
    """paper: variants of each unseen category."""
    demonstrations: int = 1
    """paper: variants of each demonstrated category."""
    seed: int = 0
    """Of variants, rotations, scales, defects, chance."""
    turn: bool = True
    """Rotate and scale every object at random."""
    up: bool = True
    """Keep what is known of the up axis."""
    perturb: bool = False
    """Give the parts defects: merged, split, boundaries moved."""
    limit: int | None = None
    """At most so many targets."""
    k: int | None = None
    """Ranked contacts per target; 5, for diversity 10."""
    workers: int = os.cpu_count() or 1
    """Processes; the results do not depend on it."""
    categories: bool = False
    """Print a table per category, too."""
    json: bool = False
    """Print one JSON document and nothing else."""
    out: Path | None = None
    """Folder for rows.jsonl (a stopped run goes on from it), table, JSON and pictures of the worst cases."""

    def benchmark(self) -> Benchmark:
        """Return the objects, demonstrations and queries."""
        for name in ("variants", "demonstrations", "limit", "k", "workers"):
            value = getattr(self, name)
            if value is not None and value < 1:
                raise InputError(f"--{name}: expected at least 1, got {value}")
        if self.seed < 0:
            raise InputError(f"--seed: expected at least 0, got {self.seed}")
        posing = Posing(self.seed, self.turn, self.up, self.perturb)
        if self.protocol == "paper":
            if self.objects is not None:
                raise InputError("--objects: the paper's protocol runs on the zoo; choose another --protocol")
            return paper(posing, variants=self.variants, demonstrations=self.demonstrations, limit=self.limit)
        if self.objects is None:
            raise InputError(f"--protocol {self.protocol}: expected --objects, a folder or ycb")
        objects = load_objects(self.objects)
        return from_objects(self.protocol, objects, posing, source=self.source, half=self.half, limit=self.limit)


AskedFlags = Annotated[Asked, tyro.conf.OmitArgPrefixes]


@dataclass(frozen=True)
class Affordance:
    """graft beside the baselines: part accuracy, ASR, NSS, DTM."""

    settings: AskedFlags = Asked()

    def run(self) -> int:
        """Evaluate, print, draw; returns the exit code."""
        return _run(self.settings, "affordance", methods(), self.settings.k or 5)


@dataclass(frozen=True)
class Ablation:
    """graft beside itself with one piece taken out or changed."""

    settings: AskedFlags = Asked()

    def run(self) -> int:
        """Evaluate, print, draw; returns the exit code."""
        return _run(self.settings, "ablation", ablations(), self.settings.k or 5)


@dataclass(frozen=True)
class Varied:
    """How varied the sources of the best matches are, and how accuracy holds as more are taken."""

    settings: AskedFlags = Asked()

    def run(self) -> int:
        """Evaluate, print, draw; returns the exit code."""
        return _run(self.settings, "diversity", retrieving_methods(), self.settings.k or 10)


@dataclass(frozen=True)
class Evaluate:
    """Measure transferred contacts against the graspable parts of objects."""

    evaluation: tyro.conf.OmitSubcommandPrefixes[
        Annotated[Affordance, tyro.conf.subcommand("affordance")]
        | Annotated[Ablation, tyro.conf.subcommand("ablation")]
        | Annotated[Varied, tyro.conf.subcommand("diversity")]
    ]

    def run(self) -> int:
        """Run what was chosen; returns the exit code."""
        return self.evaluation.run()


def _run(asked: Asked, what: What, chosen: Sequence[Method], k: int) -> int:
    start = time.perf_counter()
    seed = asked.seed
    with _progress() as progress:
        progress("loading and posing", 0, 1)
        benchmark = asked.benchmark()
        rows = evaluate(benchmark, chosen, k=k, workers=asked.workers, out=asked.out, progress=progress)
        seconds = time.perf_counter() - start
        varied = diversity(rows, k, seed) if what == "diversity" else []
        reference = Graft().name if what == "ablation" else None
        result = document(benchmark, rows, k, quoted=what == "affordance", reference=reference, varied=varied)
        text = io.StringIO()
        console = Console(file=text, width=TABLE_WIDTH)
        _print_asked(console, benchmark)
        if what == "affordance":
            _print_affordance(console, rows, k, seed, asked.categories)
        elif what == "ablation":
            _print_ablation(console, rows, k, seed)
        else:
            _print_varied(console, varied)
        if asked.out is not None:
            progress("drawing", 0, 1)
            (asked.out / "evaluation.json").write_text(json.dumps(result, indent=1, allow_nan=False))
            (asked.out / "table.txt").write_text(text.getvalue())
            _draw(asked.out, asked.workers, benchmark, rows, progress)
    if asked.json:
        print_json(result)
        return EXIT_OK
    print(text.getvalue(), end="")
    print(f"{seconds:.1f} s")
    if asked.out is not None:
        for path in sorted(asked.out.iterdir()):
            print(path)
    return EXIT_OK


@contextmanager
def _progress() -> Iterator[Progress]:
    """Show a bar on stderr, when it is a terminal."""
    console = Console(file=sys.stderr)
    columns = (TextColumn("{task.description:<24}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Bar(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("starting", total=None)
        yield lambda what, done, total: bar.update(task, description=what, completed=done, total=total)


def _draw(out: Path, workers: int, benchmark: Benchmark, rows: Sequence[Row], progress: Progress) -> None:
    """Draw the worst of graft's answers."""
    method = Graft()
    bad = worst([row for row in rows if row.method == method.name], WORST)
    (graphs,) = build_graphs(benchmark, [method.graphs], workers=workers, progress=progress)
    transfers = pictured(benchmark, method.fit(benchmark, graphs), bad)
    save_sheet(out / "worst.png", transfers)
    save_scene(out / "worst.html", transfers[:WORST_ON_PAGE])


def _print_asked(console: Console, benchmark: Benchmark) -> None:
    targets = len({query.target for query in benchmark.queries})
    posing = benchmark.posing
    console.print(
        f"{benchmark.protocol}: {targets} targets, {len(benchmark.queries)} queries, "
        f"{len(benchmark.sources)} demonstrations; {'turned and scaled' if posing.turn else 'as they lie'}, "
        f"up {'kept' if posing.up else 'dropped'}, parts {'perturbed' if posing.perturb else 'as given'}, "
        f"seed {posing.seed}"
    )


def _print_affordance(console: Console, rows: Sequence[Row], k: int, seed: int, categories: bool) -> None:
    """Print the paper's table, on request once per category, and the coverage-accuracy curve."""
    _print_summaries(console, summarise(rows, k, seed), k, quoted=True)
    if categories:
        for category, summaries in by_category(rows, k, seed).items():
            console.print(f"\n[bold]{category}[/], {summaries[0].targets} targets")
            _print_summaries(console, summaries, k, quoted=False)
    if not image_methods():
        console.print("image retrieval is left out: it needs pip install 'graft-robotics[vision]'")
    ours = [row for row in rows if row.method == Graft().name]
    curve, (area, most) = coverage_curve(ours), coverage_area(ours)
    console.print("\ngraft's part accuracy when only the surest answers are given:")
    console.print("  ".join(f"{coverage:.0%} {accuracy:.2f}" for coverage, accuracy in curve))
    error = calibration_error(ours)
    told = "" if error is None else f"; mean squared difference of confidence and being right {error:.3f}"
    console.print(f"area under the curve {area:.3f}, at most {most:.3f}{told}")


def _print_ablation(console: Console, rows: Sequence[Row], k: int, seed: int) -> None:
    """Print graft's figures and what every variation adds to them, paired by query."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("variation", no_wrap=True)
    for column in ("part", f"part top-{k}", "NSS", "DTM"):
        table.add_column(column, justify="right", no_wrap=True)
    shown = (("part", 3), ("part_top", 3), ("nss", 3), ("dtm", 4))
    name = Graft().name
    (ours,) = summarise([row for row in rows if row.method == name], k, seed)
    table.add_row(name, *(_cell(ours.figures[key], digits) for key, digits in shown))
    for variation, figures in effects(rows, name, k, seed).items():
        table.add_row(variation, *(_cell(figures[key], digits, sign="+") for key, digits in shown))
    console.print(table)
    console.print("rows below the first: difference to the first, paired by query")


def _print_summaries(console: Console, summaries: Sequence[Summary], k: int, quoted: bool) -> None:
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("method", no_wrap=True)
    shown = ("part", "part_top", "asr", "nss", "dtm")
    for column in ("part", f"part top-{k}", "ASR", "NSS", "DTM"):
        table.add_column(column, justify="right", no_wrap=True)
    if quoted:
        for name, figures in QUOTED.items():
            table.add_row(name, *(f"{figures[key]:.2f}" if key in figures else "-" for key in shown))
    for summary in summaries:
        cells = [_cell(summary.figures[key], 4 if key == "dtm" else 3) for key in shown]
        table.add_row(summary.method, *cells)
    console.print(table)


def _print_varied(console: Console, varied: Sequence[Diversity]) -> None:
    table = Table(box=None, pad_edge=False, header_style="bold")
    depth = len(varied[0].accuracy)
    shown = sorted({1, min(5, depth), depth})
    columns = [f"categories in top {depth}", "entropy", *(f"part top-{rank}" for rank in shown)]
    table.add_column("method", no_wrap=True)
    for column in columns:
        table.add_column(column, justify="right", no_wrap=True)
    for found in varied:
        accuracies = (_cell(found.accuracy[rank - 1]) for rank in shown)
        table.add_row(found.method, _cell(found.categories, 2), _cell(found.entropy), *accuracies)
    console.print(table)


def _cell(estimate: Estimate, digits: int = 3, sign: str = "") -> str:
    """Return a mean and its interval."""
    low, high = (f"{end:{sign}.{digits}f}" for end in (estimate.low, estimate.high))
    return f"{estimate.value:{sign}.{digits}f} [dim]{low}..{high}[/]"

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
from graft.evaluate.diversity import Diversity, diversity, retrieving_methods
from graft.evaluate.intervals import Estimate
from graft.evaluate.methods import Graft, Method
from graft.evaluate.protocols import Benchmark, Posing, from_objects, load_objects, paper
from graft.evaluate.report import QUOTED, Summary, by_category, coverage_curve, document, summarise
from graft.evaluate.rows import Row
from graft.evaluate.runner import Progress, build_graphs, evaluate
from graft.viz import save_scene, save_sheet

WORST = 24
"""Worst cases that are drawn on the sheet."""

WORST_ON_PAGE = 8
"""Worst cases on the page, which is heavier."""


@dataclass(frozen=True)
class Asked:
    """What is evaluated, and how."""

    protocol: Literal["paper", "leave-category-out", "within-category", "one-source"] = "paper"
    """paper: the zoo's demonstrated categories answer for its unseen ones. The others need --objects."""
    objects: str | None = None
    """Folder with one folder per labelled object (object.json with graspable_parts), or ycb."""
    source: str | None = None
    """one-source: the object whose demonstrations answer; by default the first of each category in turn."""
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
        return from_objects(self.protocol, objects, posing, source=self.source, limit=self.limit)


AskedFlags = Annotated[Asked, tyro.conf.OmitArgPrefixes]


@dataclass(frozen=True)
class Affordance:
    """graft beside the baselines: part accuracy, ASR, NSS, DTM."""

    asked: AskedFlags = Asked()

    def run(self) -> int:
        """Evaluate, print, draw; returns the exit code."""
        return _run(self.asked, methods(), self.asked.k or 5, quoted=True)


@dataclass(frozen=True)
class Ablation:
    """graft beside itself with one piece taken out or changed."""

    asked: AskedFlags = Asked()

    def run(self) -> int:
        """Evaluate, print; returns the exit code."""
        return _run(self.asked, ablations(), self.asked.k or 5, quoted=False)


@dataclass(frozen=True)
class Varied:
    """How varied the sources of the best matches are, and how accuracy holds as more are taken."""

    asked: AskedFlags = Asked()

    def run(self) -> int:
        """Evaluate, print; returns the exit code."""
        return _run(self.asked, retrieving_methods(), self.asked.k or 10, quoted=False, varied=True)


@dataclass(frozen=True)
class Evaluate:
    """Measure transferred contacts against the graspable parts of objects."""

    what: tyro.conf.OmitSubcommandPrefixes[
        Annotated[Affordance, tyro.conf.subcommand("affordance")]
        | Annotated[Ablation, tyro.conf.subcommand("ablation")]
        | Annotated[Varied, tyro.conf.subcommand("diversity")]
    ]

    def run(self) -> int:
        """Run what was chosen; returns the exit code."""
        return self.what.run()


def _run(asked: Asked, chosen: Sequence[Method], k: int, *, quoted: bool, varied: bool = False) -> int:
    start = time.perf_counter()
    with _progress() as progress:
        progress("loading and posing", 0, 1)
        benchmark = asked.benchmark()
        rows = evaluate(benchmark, chosen, k=k, workers=asked.workers, out=asked.out, progress=progress)
        seconds = time.perf_counter() - start
        found = diversity(rows, k, asked.seed) if varied else []
        result = document(benchmark, rows, k, quoted=quoted, varied=found)
        text = io.StringIO()
        _print(Console(file=text, width=140), asked, benchmark, rows, k, found, quoted)
        if asked.out is not None:
            progress("drawing", 0, 1)
            (asked.out / "evaluation.json").write_text(json.dumps(result, indent=1, allow_nan=False))
            (asked.out / "table.txt").write_text(text.getvalue())
            _draw(asked, benchmark, rows, progress)
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


def _draw(asked: Asked, benchmark: Benchmark, rows: Sequence[Row], progress: Progress) -> None:
    """Draw the worst of graft's answers."""
    if asked.out is None:
        return
    method = Graft()
    bad = worst([row for row in rows if row.method == method.name], WORST)
    (graphs,) = build_graphs(benchmark, [method.graphs], workers=asked.workers, progress=progress)
    transfers = pictured(benchmark, method.fit(benchmark, graphs), bad)
    save_sheet(asked.out / "worst.png", transfers)
    save_scene(asked.out / "worst.html", transfers[:WORST_ON_PAGE])


def _print(
    console: Console,
    asked: Asked,
    benchmark: Benchmark,
    rows: Sequence[Row],
    k: int,
    varied: Sequence[Diversity],
    quoted: bool,
) -> None:
    """Print the tables."""
    targets = len({query.target for query in benchmark.queries})
    posing = benchmark.posing
    console.print(
        f"{benchmark.protocol}: {targets} targets, {len(benchmark.queries)} queries, "
        f"{len(benchmark.sources)} demonstrations; {'turned and scaled' if posing.turn else 'as they lie'}, "
        f"up {'kept' if posing.up else 'dropped'}, parts {'perturbed' if posing.perturb else 'as given'}, "
        f"seed {posing.seed}"
    )
    if varied:
        _print_varied(console, varied)
        return
    _print_summaries(console, summarise(rows, k, posing.seed), k, quoted)
    if asked.categories:
        for category, summaries in by_category(rows, k, posing.seed).items():
            console.print(f"\n[bold]{category}[/], {summaries[0].targets} targets")
            _print_summaries(console, summaries, k, quoted=False)
    curve = coverage_curve([row for row in rows if row.method == Graft().name])
    told = "  ".join(f"{coverage:.0%} {accuracy:.2f}" for coverage, accuracy in curve)
    console.print(f"\ngraft's part accuracy when only the surest answers are given: {told}")


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
    shown = [rank for rank in (1, 2, 3, 5, 10, 20) if rank <= depth]
    columns = [f"categories in top {depth}", "entropy", *(f"part top-{rank}" for rank in shown)]
    table.add_column("method")
    for column in columns:
        table.add_column(column, justify="right", no_wrap=True)
    for found in varied:
        accuracies = (_cell(found.accuracy[rank - 1]) for rank in shown)
        table.add_row(found.method, _cell(found.categories, 2), _cell(found.entropy), *accuracies)
    console.print(table)


def _cell(estimate: Estimate, digits: int = 3) -> str:
    """Return a mean and its interval."""
    return f"{estimate.value:.{digits}f} [dim]{estimate.low:.{digits}f}..{estimate.high:.{digits}f}[/]"

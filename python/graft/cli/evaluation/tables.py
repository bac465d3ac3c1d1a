"""Tables of the evaluations of contacts."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from graft.evaluate.baselines import image_methods
from graft.evaluate.diversity import Diversity
from graft.evaluate.intervals import Estimate
from graft.evaluate.methods import Graft
from graft.evaluate.protocols import Benchmark
from graft.evaluate.report import (
    QUOTED,
    Summary,
    by_category,
    calibration_error,
    coverage_area,
    coverage_curve,
    effects,
    summarise,
)
from graft.evaluate.rows import Row

TABLE_WIDTH = 160
"""Characters of a line of the tables, which are the same on a terminal and in the file."""


def print_asked(console: Console, benchmark: Benchmark) -> None:
    """Print what was asked, in one line."""
    targets = len({query.target for query in benchmark.queries})
    posing = benchmark.posing
    console.print(
        f"{benchmark.protocol}: {targets} targets, {len(benchmark.queries)} queries, "
        f"{len(benchmark.sources)} demonstrations; {'turned and scaled' if posing.turn else 'as they lie'}, "
        f"up {'kept' if posing.up else 'dropped'}, parts {posing.parts}{', perturbed' if posing.perturb else ''}, "
        f"seed {posing.seed}"
    )


def print_affordance(console: Console, rows: Sequence[Row], k: int, seed: int, categories: bool) -> None:
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


def print_ablation(console: Console, rows: Sequence[Row], k: int, seed: int) -> None:
    """Print graft's figures and what every variation adds to them, paired by query."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("variation", no_wrap=True)
    for column in ("part", f"part top-{k}", "NSS", "DTM"):
        table.add_column(column, justify="right", no_wrap=True)
    shown = (("part", 3), ("part_top", 3), ("nss", 3), ("dtm", 4))
    name = Graft().name
    (ours,) = summarise([row for row in rows if row.method == name], k, seed)
    table.add_row(name, *(cell(ours.figures[key], digits) for key, digits in shown))
    for variation, figures in effects(rows, name, k, seed).items():
        table.add_row(variation, *(cell(figures[key], digits, sign="+") for key, digits in shown))
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
        cells = [cell(summary.figures[key], 4 if key == "dtm" else 3) for key in shown]
        table.add_row(summary.method, *cells)
    console.print(table)


def print_varied(console: Console, varied: Sequence[Diversity]) -> None:
    """Print how varied the sources of the best matches are."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    depth = len(varied[0].accuracy)
    shown = sorted({1, min(5, depth), depth})
    columns = [f"categories in top {depth}", "entropy", *(f"part top-{rank}" for rank in shown)]
    table.add_column("method", no_wrap=True)
    for column in columns:
        table.add_column(column, justify="right", no_wrap=True)
    for found in varied:
        accuracies = (cell(found.accuracy[rank - 1]) for rank in shown)
        table.add_row(found.method, cell(found.categories, 2), cell(found.entropy), *accuracies)
    console.print(table)


def cell(estimate: Estimate, digits: int = 3, sign: str = "") -> str:
    """Return a mean and its interval."""
    low, high = (f"{end:{sign}.{digits}f}" for end in (estimate.low, estimate.high))
    return f"{estimate.value:{sign}.{digits}f} [dim]{low}..{high}[/]"

"""`graft demo`: the main job, end to end."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from graft.cli import EXIT_OK
from graft.cli.options import print_json, print_table, shown, stdout_console
from graft.demo import DemoRow, demo_document, run_demo


@dataclass(frozen=True)
class Demo:
    """Transfer contacts from demonstrated objects to objects nobody demonstrated.

    The library is made of the zoo's demonstrated categories and half of the YCB scans; the targets are all others.
    """

    out: Path = Path("out")
    """Folder for the picture, the page, the GLB, the JSON, the library and the targets."""
    seed: int = 0
    """Chooses the variants of the zoo's objects."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Run, print, say what was written; returns the exit code."""
        console = Console(file=sys.stderr)
        columns = (
            TextColumn("{task.description:<24}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
        )
        with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
            task = bar.add_task("starting", total=None)
            rows, written = run_demo(
                self.out,
                seed=self.seed,
                progress=lambda what, done, total: bar.update(task, description=what, completed=done, total=total),
            )
        if self.json:
            print_json(demo_document(rows, self.seed))
            return EXIT_OK
        _print_rows(rows)
        for what, path in written.items():
            print(f"{what:<8} {path}")
        return EXIT_OK


def _print_rows(rows: list[DemoRow]) -> None:
    """Print the table of targets and the share of contacts in the mask."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("target", "best source", "its part", "to part"):
        table.add_column(column)
    for column in ("cost", "confidence", "ms"):
        table.add_column(column, justify="right")
    table.add_column("in mask")
    for row in rows:
        result = row.transferred
        match = result.match
        table.add_row(
            shown(match.target.object.name),
            shown(match.demonstration.name),
            shown(match.source.object.part_names[result.source_part]),
            shown(match.target.object.part_names[result.target_part]),
            f"{match.cost:.4f}",
            f"{result.confidence:.2f}",
            f"{row.seconds * 1e3:.1f}",
            "[green]yes[/]" if row.in_mask else "[red]no[/]",
        )
    print_table(stdout_console(), table)
    inside = sum(row.in_mask for row in rows)
    others = [row for row in rows if not row.same_category]
    print(
        f"{inside} of {len(rows)} contacts ({inside / len(rows):.0%}) lie in the graspable mask; "
        f"{sum(row.in_mask for row in others)} of {len(others)} where the source is of another category"
    )

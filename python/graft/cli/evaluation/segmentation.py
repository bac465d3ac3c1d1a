"""`graft evaluate segmentation DIR`: automatic parts against those that people drew."""

from __future__ import annotations

import io
import json
import os
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import tyro
from rich.console import Console
from rich.table import Table

import graft
from graft.cli import EXIT_OK
from graft.cli.evaluation.progress import progress_bar
from graft.cli.evaluation.tables import TABLE_WIDTH, cell
from graft.cli.options import print_json
from graft.errors import InputError
from graft.evaluate.book import code_fingerprint
from graft.evaluate.cutters import cutters
from graft.evaluate.segmentation import (
    MEASURES,
    QUOTED,
    CutRow,
    CutSummary,
    cuts_by_category,
    evaluate_cuts,
    load_drawn,
    summarise_cuts,
)

HEADINGS = ("Rand error", "cut discrepancy", "Hamming", "GCE", "LCE")
"""Over the columns of `MEASURES`."""


@dataclass(frozen=True)
class Segmentation:
    """Automatic parts beside people's: Rand index, cut discrepancy, Hamming distance, consistency."""

    objects: tyro.conf.Positional[Path]
    """Folder with one folder per object: mesh.ply, human_segmentations.npz (labels, people x faces), object.json."""
    half: Literal["both", "tuning", "reporting"] = "both"
    """Tune on one half of the objects, report the other."""
    only: tuple[str, ...] = ()
    """Methods by name, as in the table; by default all that are installed."""
    seed: int = 0
    """Of methods that draw, and of the intervals."""
    limit: int | None = None
    """At most so many objects."""
    workers: int = os.cpu_count() or 1
    """Processes; the results do not depend on it, but for the times."""
    json: bool = False
    """Print one JSON document and nothing else."""
    out: Path | None = None
    """Folder for rows.jsonl (a stopped run goes on from it), table and JSON."""

    def run(self) -> int:
        """Evaluate and print; returns the exit code."""
        for name in ("limit", "workers"):
            value = getattr(self, name)
            if value is not None and value < 1:
                raise InputError(f"--{name}: expected at least 1, got {value}")
        if self.seed < 0:
            raise InputError(f"--seed: expected at least 0, got {self.seed}")
        methods = cutters()
        names = [method.name for method in methods]
        unknown = [name for name in self.only if name not in names]
        if unknown:
            raise InputError(f"--only: no method called {unknown[0]!r}; there are {', '.join(names)}")
        if not self.objects.is_dir():
            raise InputError("expected a folder with one folder per object", path=self.objects)
        methods = [method for method in methods if not self.only or method.name in self.only]
        start = time.perf_counter()
        with progress_bar() as progress:
            progress("loading", 0, 1)
            objects = load_drawn(self.objects, self.half, self.limit)
            rows = evaluate_cuts(
                objects, methods, seed=self.seed, workers=self.workers, out=self.out, progress=progress
            )
        text = io.StringIO()
        console = Console(file=text, width=TABLE_WIDTH, emoji=False, highlight=False)
        _print(console, rows, self.half, self.seed)
        result = _document(rows, self.half, self.seed)
        if self.out is not None:
            (self.out / "evaluation.json").write_text(json.dumps(result, indent=1, allow_nan=False))
            (self.out / "table.txt").write_text(text.getvalue())
        if self.json:
            print_json(result)
            return EXIT_OK
        print(text.getvalue(), end="")
        print(f"{time.perf_counter() - start:.1f} s")
        return EXIT_OK


def _print(console: Console, rows: Sequence[CutRow], half: str, seed: int) -> None:
    """Print the quoted figures, the table, and one per category."""
    objects = len({row.query for row in rows})
    which = "both halves" if half == "both" else f"the {half} half"
    console.print(f"segmentation: {objects} objects, {which}, seed {seed}; less is better")
    quoted = ", ".join(f"{name} {error:.2f}" for name, error in QUOTED.items())
    console.print(f"published Rand errors over the whole benchmark (19 categories): {quoted}\n")
    _print_table(console, summarise_cuts(rows, seed))
    for category, summaries in cuts_by_category(rows, seed).items():
        console.print(f"\n[bold]{category}[/], {summaries[0].objects} objects")
        _print_table(console, summaries)


def _print_table(console: Console, summaries: Sequence[CutSummary]) -> None:
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("method", no_wrap=True)
    for column in (*HEADINGS, "parts", "s (most)"):
        table.add_column(column, justify="right", no_wrap=True)
    for found in summaries:
        cells = [cell(found.figures[name]) if name in found.figures else "-" for name in MEASURES]
        spent = f"{found.seconds:.2f} ({found.slowest:.2f})" if found.slowest else "-"
        table.add_row(found.method, *cells, f"{found.parts:.1f}", spent)
    console.print(table)


def _document(rows: Sequence[CutRow], half: str, seed: int) -> dict[str, Any]:
    """Return everything as one JSON document."""
    return {
        "graft": graft.__version__,
        "code": code_fingerprint(),
        "half": half,
        "seed": seed,
        "quoted": dict(QUOTED),
        "methods": [asdict(found) for found in summarise_cuts(rows, seed)],
        "categories": {
            category: [asdict(found) for found in summaries]
            for category, summaries in cuts_by_category(rows, seed).items()
        },
        "rows": [asdict(row) for row in rows],
    }

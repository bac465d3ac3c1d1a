"""`graft evaluate affordance|ablation|diversity`: measure where transferred contacts land."""

from __future__ import annotations

import io
import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro
from rich.console import Console

from graft.cli import EXIT_OK
from graft.cli.evaluation.asked import Asked
from graft.cli.evaluation.progress import progress_bar
from graft.cli.evaluation.tables import TABLE_WIDTH, print_ablation, print_affordance, print_asked, print_varied
from graft.cli.options import print_json
from graft.errors import InputError
from graft.evaluate.ablation import ablations
from graft.evaluate.affordance import methods, pictured, worst
from graft.evaluate.diversity import diversity, retrieving_methods
from graft.evaluate.methods import Graft, Method
from graft.evaluate.protocols import Benchmark
from graft.evaluate.report import document
from graft.evaluate.rows import Row
from graft.evaluate.runner import build_graphs, evaluate
from graft.evaluate.work import Progress
from graft.viz import save_scene, save_sheet

WORST = 24
"""Worst cases that are drawn on the sheet."""

WORST_ON_PAGE = 8
"""Worst cases on the page, which is heavier."""

What = Literal["affordance", "ablation", "diversity"]


@dataclass(frozen=True)
class Contacts(Asked):
    """What is evaluated, and how."""

    k: int | None = None
    """Ranked contacts per target; 5, for diversity 10."""
    categories: bool = False
    """Print a table per category, too."""


ContactsFlags = Annotated[Contacts, tyro.conf.OmitArgPrefixes]


@dataclass(frozen=True)
class Affordance:
    """graft beside the baselines: part accuracy, ASR, NSS, DTM."""

    settings: ContactsFlags = Contacts()

    def run(self) -> int:
        """Evaluate, print, draw; returns the exit code."""
        return _run(self.settings, "affordance", methods(), self.settings.k or 5)


@dataclass(frozen=True)
class Ablation:
    """graft beside itself with one piece taken out or changed."""

    settings: ContactsFlags = Contacts()

    def run(self) -> int:
        """Evaluate, print, draw; returns the exit code."""
        return _run(self.settings, "ablation", ablations(), self.settings.k or 5)


@dataclass(frozen=True)
class Varied:
    """How varied the sources of the best matches are, and how accuracy holds as more are taken."""

    settings: ContactsFlags = Contacts()

    def run(self) -> int:
        """Evaluate, print, draw; returns the exit code."""
        return _run(self.settings, "diversity", retrieving_methods(), self.settings.k or 10)


def _run(asked: Contacts, what: What, chosen: Sequence[Method], k: int) -> int:
    if asked.k is not None and asked.k < 1:
        raise InputError(f"--k: expected at least 1, got {asked.k}")
    start = time.perf_counter()
    seed = asked.seed
    with progress_bar() as progress:
        progress("loading and posing", 0, 1)
        benchmark = asked.benchmark()
        rows = evaluate(benchmark, chosen, k=k, workers=asked.workers, out=asked.out, progress=progress)
        seconds = time.perf_counter() - start
        varied = diversity(rows, k, seed) if what == "diversity" else []
        reference = Graft().name if what == "ablation" else None
        result = document(benchmark, rows, k, quoted=what == "affordance", reference=reference, varied=varied)
        text = io.StringIO()
        console = Console(file=text, width=TABLE_WIDTH)
        print_asked(console, benchmark)
        if what == "affordance":
            print_affordance(console, rows, k, seed, asked.categories)
        elif what == "ablation":
            print_ablation(console, rows, k, seed)
        else:
            print_varied(console, varied)
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


def _draw(out: Path, workers: int, benchmark: Benchmark, rows: Sequence[Row], progress: Progress) -> None:
    """Draw the worst of graft's answers."""
    method = Graft()
    bad = worst([row for row in rows if row.method == method.name], WORST)
    (graphs,) = build_graphs(benchmark, [method.graphs], workers=workers, progress=progress)
    transfers = pictured(benchmark, method.fit(benchmark, graphs), bad)
    save_sheet(out / "worst.png", transfers)
    save_scene(out / "worst.html", transfers[:WORST_ON_PAGE])

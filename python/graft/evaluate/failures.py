"""A page of what went wrong: one card per trial of graft that did not succeed, with its picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from graft.evaluate.methods import Graft
from graft.evaluate.protocols import Benchmark
from graft.evaluate.simulation import Arena, Table, standing
from graft.evaluate.trials import TrialRow
from graft.evaluate.work import Progress
from graft.grasp import Grasp
from graft.sim import Outcome, simulate_grasp
from graft.sim.pictures import save_trial
from graft.viz import save_views
from graft.viz.cards import Card, save_cards

DRAWN = 60
"""Most failures that are drawn; the page says how many there are."""


def draw_failures(
    path: Path, benchmark: Benchmark, arena: Arena, rows: Sequence[TrialRow], text: str, progress: Progress
) -> None:
    """Write the page of graft's failures, drawn anew by running their trials again.

    Args:
        path: Ends in .html.
        benchmark: What was asked.
        arena: How trials were run.
        rows: What came of them.
        text: The tables, above the cards.
        progress: Told what is being done.
    """
    failed = [row for row in rows if row.method == Graft().name and not row.setting and row.outcome != Outcome.SUCCESS]
    chosen = [
        failed[i] for i in np.unique(np.linspace(0, len(failed) - 1, min(DRAWN, len(failed))).round().astype(int))
    ]
    subjects = {subject.key: subject for subject in benchmark.subjects}
    tables = {key: Table.lay(subjects[key], arena) for key in dict.fromkeys(row.query for row in chosen)}
    cards = []
    for count, row in enumerate(chosen):
        progress("drawing", count, len(chosen))
        cards.append(_card(tables[row.query], benchmark.posing.seed, arena, row))
    if len(failed) > len(chosen):
        text += f"\n{len(chosen)} of {len(failed)} failures are drawn, evenly spread\n"
    save_cards(path, f"graft: {len(failed)} failures", text, cards)


def _card(table: Table, seed: int, arena: Arena, row: TrialRow) -> Card:
    """Run a failed trial again and draw it; where there was no grasp, draw the object."""
    with TemporaryDirectory() as folder:
        picture = Path(folder) / "picture.png"
        if row.grasp is None or row.width is None:
            save_views(picture, table.prepared.object)
        else:
            grasp = Grasp(np.array(row.grasp), row.width, 0.0, np.zeros((2, 3)), row.distance or 0.0, arena.gripper)
            pose = standing(table, arena, seed, row.query)[row.pose]
            save_trial(picture, table.prepared, simulate_grasp(table.prepared, grasp, arena.config, pose=pose))
        data = picture.read_bytes()
    place = "" if row.part is None else f" at {row.part}, from {row.source}"
    numbers = "  ".join(f"{name} {value:.4g}" for name, value in row.measured.items() if isinstance(value, float))
    return Card(f"{row.query}, pose {row.pose}: {row.outcome}", f"{row.reason}{place}\n{numbers}", data)

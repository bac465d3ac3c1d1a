"""`graft replay FILE`: run episodes again and compare."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path

import tyro
from rich.table import Table

from graft.cli import EXIT_FAILED, EXIT_OK
from graft.cli.options import print_json, print_table, shown, stdout_console
from graft.datagen.replay import Replayed, replay
from graft.errors import InputError


@dataclass(frozen=True)
class Replay:
    """Run episodes again from their own file, and check states and outcome.

    Exits with 1 when one of them comes out differently.
    """

    source: tyro.conf.Positional[Path]
    """An .hdf5 file, or the folder of a LeRobot dataset, of episodes that graft generated."""
    episode: int | None = None
    """Only this one, from 0."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Run the episodes, print what came of them; returns the exit code."""
        if self.episode is not None and self.episode < 0:
            raise InputError(f"--episode: expected at least 0, got {self.episode}")
        found = list(replay(self.source, episode=self.episode))
        same = sum(one.same for one in found)
        if self.json:
            print_json({"file": str(self.source), "same": same, "episodes": [_document(one) for one in found]})
        else:
            _print(found)
            print(f"{same} of {len(found)} episodes came out the same")
        return EXIT_OK if same == len(found) else EXIT_FAILED


def _document(one: Replayed) -> dict[str, object]:
    return {**asdict(one), "same": one.same}


def _print(found: list[Replayed]) -> None:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("episode", "recorded", "now"):
        table.add_column(column)
    for column in ("steps", "difference"):
        table.add_column(column, justify="right")
    table.add_column("because")
    for one in found:
        other = ", ".join(f"{name} {made} then, {now} now" for name, (made, now) in one.versions.items())
        why = one.reason if not other else f"{one.reason}; {other}"
        difference = "0" if one.difference == 0 else f"{one.difference:.1e} at {one.step}"
        table.add_row(shown(one.name), one.recorded, one.outcome, str(one.steps), difference, shown(why))
    print_table(stdout_console(), table)

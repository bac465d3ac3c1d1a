"""`graft match SOURCE TARGET`: the transport plan between two objects."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import tyro
from rich.table import Table

from graft.cli import EXIT_OK
from graft.cli.options import (
    Loading,
    LoadingFlags,
    Matching,
    MatchingFlags,
    check_outputs,
    fits,
    print_json,
    print_table,
    shown,
    stdout_console,
    write_outputs,
)
from graft.contact import transfer_contact
from graft.documents import transfer_document
from graft.errors import InputError
from graft.io import load_demonstration
from graft.io.folder import DEMONSTRATION_FILE
from graft.library import Match, match
from graft.marking import mark_contact
from graft.objects import Demonstration


@dataclass(frozen=True)
class MatchCommand:
    """Match one object against another and print the transport plan."""

    source: tyro.conf.Positional[Path]
    """The demonstrated object: a demonstration's folder, or any object with --part."""
    target: tyro.conf.Positional[Path]
    """The other object."""
    part: str | None = None
    """Demonstrated part of the source by name or number, where the source is no demonstration."""
    json: bool = False
    """Print one JSON document and nothing else."""
    out: tuple[Path, ...] = ()
    """Files to write; the suffix tells what: .png (picture), .html (page), .glb."""
    loading: LoadingFlags = Loading()
    matching: MatchingFlags = Matching()

    def run(self) -> int:
        """Match, print, draw; returns the exit code."""
        check_outputs(self.out)
        demonstration = self._demonstration()
        target = self.loading.load(self.target)
        found = match(demonstration, target, solver=self.matching.solver(), descriptor=self.matching.described())
        transferred = transfer_contact(found)
        write_outputs(self.out, transferred)
        if self.json:
            print_json(transfer_document(transferred))
        else:
            _print_plan(found)
        return EXIT_OK

    def _demonstration(self) -> Demonstration:
        """Read the source, with its own contact or with one marked on --part."""
        if self.part is None:
            if self.source.exists() and not (self.source / DEMONSTRATION_FILE).is_file():
                raise InputError(f"expected a folder with a {DEMONSTRATION_FILE}, or --part", path=self.source)
            return load_demonstration(self.source)
        obj = self.loading.load(self.source)
        number = self.part not in obj.part_names and self.part.isascii() and self.part.isdecimal()
        return mark_contact(obj, int(self.part) if number else self.part)


def _print_plan(found: Match) -> None:
    """Print the plan as a table, rows the source's parts, the demonstrated one marked."""
    console = stdout_console()
    source, target, transport = found.source.object, found.target.object, found.transport
    state = "converged" if transport.converged else "NOT converged"
    console.print(
        f"[bold]{shown(source.name)}[/] to [bold]{shown(target.name)}[/]: cost {found.cost:.4f}, "
        f"{state} in {transport.n_iters} iterations"
    )
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("part")
    for name in target.part_names:
        table.add_column(shown(name), justify="right")
    table.add_column("mass", justify="right", style="dim")
    for i, name in enumerate(source.part_names):
        best = int(transport.plan[i].argmax())
        cells = [f"[bold]{v:.3f}[/]" if j == best else f"{v:.3f}" for j, v in enumerate(transport.plan[i])]
        marked = f"[bold green]{shown(name)} *[/]" if i == found.source_part else shown(name)
        table.add_row(marked, *cells, f"{transport.source_mass[i]:.3f}")
    table.add_row("[dim]mass[/]", *(f"[dim]{v:.3f}[/]" for v in transport.target_mass), "")
    if fits(console, table):
        print_table(console, table)
        console.print("[dim]* the demonstrated part; bold, where a part's mass goes[/]")
    else:
        print_table(console, _pairs(found))
        console.print("[dim]* the demonstrated part; the whole plan is in --json[/]")


def _pairs(found: Match) -> Table:
    """Return where most of each part's mass goes, for plans that are wider than the terminal."""
    source, target, transport = found.source.object, found.target.object, found.transport
    table = Table("part", "to part", box=None, pad_edge=False, header_style="bold")
    table.add_column("mass", justify="right")
    for i, name in enumerate(source.part_names):
        best = int(transport.plan[i].argmax())
        marked = f"[bold green]{shown(name)} *[/]" if i == found.source_part else shown(name)
        table.add_row(marked, shown(target.part_names[best]), f"{transport.plan[i, best]:.3f}")
    return table

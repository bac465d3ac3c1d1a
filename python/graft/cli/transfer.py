"""`graft transfer TARGET --library DIR`: a contact for an object nobody demonstrated."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro
from rich.table import Table

from graft.cli import EXIT_OK
from graft.cli.options import (
    Loading,
    LoadingFlags,
    Matching,
    MatchingFlags,
    check_outputs,
    print_json,
    print_table,
    shown,
    stdout_console,
    write_outputs,
)
from graft.contact import VOTERS, TransferredContact, agree, transfer_contact
from graft.documents import transfer_document
from graft.errors import InputError
from graft.library import Library


@dataclass(frozen=True)
class TransferCommand:
    """Transfer a contact from a library of demonstrations to an object."""

    target: tyro.conf.Positional[Path]
    """The object to be grasped."""
    library: Path
    """A folder of demonstrations (folders with a demonstration.json)."""
    k: Annotated[int, tyro.conf.arg(aliases=["-k"])] = 5
    """How many contacts to give. At least ten matches vote on the part; the contacts on the winner come first."""
    json: bool = False
    """Print one JSON document and nothing else."""
    out: tuple[Path, ...] = ()
    """Files to write; the suffix tells what: .png (picture), .html (page), .glb."""
    loading: LoadingFlags = Loading()
    matching: MatchingFlags = Matching()

    def run(self) -> int:
        """Retrieve, transfer, print, draw; returns the exit code."""
        if self.k < 1:
            raise InputError(f"-k: expected at least 1, got {self.k}")
        check_outputs(self.out)
        library = Library.open(self.library, solver=self.matching.solver(), descriptor=self.matching.described())
        target = self.loading.load(self.target)
        matches = library.retrieve(target, k=max(self.k, VOTERS))
        results = agree([transfer_contact(match) for match in matches])[: self.k]
        write_outputs(self.out, results)
        if self.json:
            print_json({"target": target.name, "matches": [transfer_document(r) for r in results]})
        else:
            _print_contacts(target.name, results)
        return EXIT_OK


def _print_contacts(name: str, results: list[TransferredContact]) -> None:
    """Print one row per match."""
    table = Table(box=None, pad_edge=False, header_style="bold", title_justify="left")
    table.title = f"contacts for {shown(name)}"
    for column in ("", "source", "part", "to part"):
        table.add_column(column)
    for column in ("cost", "confidence", "point", "normal"):
        table.add_column(column, justify="right")
    for result in results:
        source, target = result.match.source.object, result.match.target.object
        table.add_row(
            str(result.match.rank + 1),
            shown(result.match.demonstration.name),
            shown(source.part_names[result.source_part]),
            shown(target.part_names[result.target_part]),
            f"{result.match.cost:.4f}",
            f"{result.confidence:.2f}",
            " ".join(f"{x:.4g}" for x in result.contact.point),
            " ".join(f"{x:.2f}" for x in result.contact.normal),
        )
    print_table(stdout_console(), table)

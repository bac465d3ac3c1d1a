"""`graft library ls|show|explain`: what is in a library, and why it answers as it does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro
from rich.table import Table

from graft.cli import EXIT_OK
from graft.cli.library_build import chosen_executor
from graft.cli.options import (
    Loading,
    LoadingFlags,
    check_outputs,
    print_json,
    print_table,
    shown,
    stdout_console,
)
from graft.documents import contact_document, match_document
from graft.errors import InputError
from graft.library import Explanation, Filter, Library, Listed, listing
from graft.objects import Demonstration
from graft.viz.thumbnails import save_thumbnails

LibraryPath = tyro.conf.Positional[Path]
FilterFlags = Annotated[Filter, tyro.conf.OmitArgPrefixes]

THUMBNAILS = 200
"""Objects on a sheet, at most."""


@dataclass(frozen=True)
class List:
    """Print the objects."""

    library: LibraryPath
    """The library."""
    only: FilterFlags = Filter()
    limit: int | None = None
    """At most so many."""
    version: int | None = None
    """An earlier version."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Print; returns the exit code."""
        if self.limit is not None and self.limit < 1:
            raise InputError(f"--limit: expected at least 1, got {self.limit}")
        library = Library.open(self.library, version=self.version, descriptor=None)
        rows = list(listing(library.snapshot, self.only, self.limit))
        if self.json:
            print_json({"version": library.version, "of": len(library), "objects": [asdict(row) for row in rows]})
        else:
            _print_rows(rows)
            stdout_console().print(f"{len(rows)} of {len(library)} objects, version {library.version}")
        return EXIT_OK


def _print_rows(rows: Sequence[Listed]) -> None:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("name", "category", "parts", "gripper", "licence", "tags", "source"):
        table.add_column(column, justify="right" if column in ("parts", "gripper") else "left")
    for row in rows:
        table.add_row(
            shown(row.name),
            shown(row.category or "-"),
            str(row.parts),
            "-" if row.gripper_width is None else f"{100 * row.gripper_width:.3g} cm",
            shown(row.licence or "-"),
            shown(", ".join(row.tags) or "-"),
            shown(row.source or "-"),
        )
    print_table(stdout_console(), table)


@dataclass(frozen=True)
class ShowLibrary:
    """Print objects with their contacts; --out draws a sheet of thumbnails."""

    library: LibraryPath
    """The library."""
    names: tyro.conf.Positional[tuple[str, ...]] = ()
    """Objects; all that the filters accept by default."""
    only: FilterFlags = Filter()
    out: Path | None = None
    """A .png of thumbnails with the contacts, 200 at most."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Print and draw; returns the exit code."""
        check_outputs(() if self.out is None else (self.out,), (".png",))
        library = Library.open(self.library, descriptor=None)
        chosen = self._chosen(library)
        if self.out is not None:
            save_thumbnails(self.out, chosen[:THUMBNAILS])
        if self.json:
            documents = [
                {"name": d.name, "category": d.object.category, "parts": list(d.object.part_names),
                 "contact": contact_document(d.object, d.contact), "metadata": dict(d.metadata)}
                for d in chosen
            ]  # fmt: skip
            print_json({"version": library.version, "objects": documents})
            return EXIT_OK
        table = Table(box=None, pad_edge=False, header_style="bold")
        for column in ("name", "category", "parts", "taken at", "point"):
            table.add_column(column)
        for d in chosen:
            names = ", ".join(d.object.part_names)
            part = d.object.part_names[d.contact.part]
            point = " ".join(f"{x:.4g}" for x in d.contact.point)
            table.add_row(shown(d.name), shown(d.object.category or "-"), shown(names), shown(part), point)
        print_table(stdout_console(), table)
        return EXIT_OK

    def _chosen(self, library: Library) -> list[Demonstration]:
        accepted = list(listing(library.snapshot, self.only))
        missing = set(self.names) - {row.name for row in accepted}
        if missing:
            raise InputError(f"library: it has no demonstration called {min(missing)!r}")
        wanted = set(self.names) or {row.name for row in accepted}
        return library.get([row.name for row in accepted if row.name in wanted])


@dataclass(frozen=True)
class Explain:
    """Say why the best match for an object is the best: terms of its cost, matched parts, the runner-up."""

    library: LibraryPath
    """The library, or a folder of demonstrations."""
    target: tyro.conf.Positional[Path]
    """The object to be grasped."""
    only: FilterFlags = Filter()
    executor: Literal["local", "ray"] = "local"
    """Where a library on disk is searched: ray spreads its segments over a Ray cluster whose nodes see them."""
    address: str | None = None
    """Of the Ray cluster's head; by default one is started on this machine."""
    json: bool = False
    """Print one JSON document and nothing else."""
    loading: LoadingFlags = Loading()

    def run(self) -> int:
        """Retrieve and print; returns the exit code."""
        library = Library.open(self.library)
        library.executor = chosen_executor(self.executor, self.address)
        found = library.explain(self.loading.load(self.target), only=self.only)
        if self.json:
            runner_up = None if found.runner_up is None else match_document(found.runner_up)
            print_json({
                "match": match_document(found.match), "terms": found.terms, "pairs": [asdict(p) for p in found.pairs],
                "runner_up": runner_up, "lacks": found.lacks,
            })  # fmt: skip
        else:
            _print_explanation(found)
        return EXIT_OK


def _print_explanation(found: Explanation) -> None:
    console = stdout_console()
    name = shown(found.match.demonstration.name)
    console.print(f"[bold]{name}[/] matches {shown(found.match.target.object.name)} at cost {found.match.cost:.4f}")
    pairs = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("part", "goes to", "share"):
        pairs.add_column(column)
    for pair in found.pairs:
        mark = " (taken)" if pair.demonstrated else ""
        pairs.add_row(shown(pair.source + mark), shown(pair.target), f"{pair.share:.2f}")
    print_table(console, pairs)
    terms = Table(box=None, pad_edge=False, header_style="bold")
    terms.add_column("term")
    terms.add_column("cost", justify="right")
    if found.runner_up is not None:
        terms.add_column(f"{shown(found.runner_up.demonstration.name)} costs more by", justify="right")
    for term in found.lacks or found.terms:
        more = [f"{found.lacks[term]:+.4f}"] if found.lacks else []
        terms.add_row(term, f"{found.terms[term]:.4f}", *more)
    print_table(console, terms)

"""`graft library VERB LIBRARY`: demonstrations on disk."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro
from rich.table import Table

from graft.cli import EXIT_BAD_INPUT, EXIT_OK
from graft.cli.library_build import Build
from graft.cli.library_look import Explain, List, ShowLibrary
from graft.cli.options import print_json, print_table, shown, stdout_console
from graft.features import GeometricDescriptor
from graft.io import load_demonstration
from graft.library import (
    Library,
    checkout,
    compact,
    drop_damaged,
    duplicates,
    export_table,
    vacuum,
    verify,
    versions,
)

LibraryPath = tyro.conf.Positional[Path]


def _say(json: bool, document: dict[str, Any], sentence: str) -> int:
    if json:
        print_json(document)
    else:
        stdout_console().print(sentence)
    return EXIT_OK


@dataclass(frozen=True)
class Add:
    """Add folders that hold a demonstration.json, all in one version."""

    library: LibraryPath
    """The library; made when there is none."""
    demonstrations: tyro.conf.Positional[tuple[Path, ...]]
    """Folders of one demonstration each."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Read, commit, print; returns the exit code."""
        loaded = [load_demonstration(folder) for folder in self.demonstrations]
        make = Library.open if (self.library / "versions").is_dir() else Library.create
        library = make(self.library, descriptor=GeometricDescriptor())
        twice = duplicates(library.snapshot, loaded)
        library.extend(loaded)
        names = [demonstration.name for demonstration in loaded]
        document = {"version": library.version, "objects": len(library), "added": names, "duplicates": twice}
        notes = "".join(f"[yellow]note[/] {shown(a)} is the same as {shown(b)}\n" for a, b in twice.items())
        sentence = f"{notes}version {library.version}: {len(names)} added, {len(library)} objects"
        return _say(self.json, document, sentence)


@dataclass(frozen=True)
class Remove:
    """Take objects out by their names, all in one version; earlier versions keep them until vacuum."""

    library: LibraryPath
    """The library."""
    names: tyro.conf.Positional[tuple[str, ...]]
    """Names, as ls prints them."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Commit and print; returns the exit code."""
        library = Library.open(self.library)
        library.remove(self.names)
        document = {"version": library.version, "objects": len(library), "removed": list(self.names)}
        return _say(self.json, document, f"version {library.version}: {len(self.names)} removed, {len(library)} left")


@dataclass(frozen=True)
class Verify:
    """Compare every byte of every version with its checksum; exit code 3 when something is damaged."""

    library: LibraryPath
    """The library."""
    drop_damaged: bool = False
    """Commit a version without the segments that are damaged, so that the library can be used again."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Read everything and print; returns the exit code."""
        report = verify(self.library)
        document: dict[str, Any] = {**asdict(report), "ok": not report.problems}
        dropped = None
        if self.drop_damaged and report.problems:
            dropped = drop_damaged(self.library).manifest
            document["version"] = dropped.version
        if self.json:
            print_json(document)
        else:
            console = stdout_console()
            for problem in report.problems:
                console.print(f"[red]damaged[/] {shown(problem)}")
            for path in report.foreign:
                console.print(f"[yellow]named by no version[/] {shown(path)}")
            count = f"{len(report.problems)} problems" if report.problems else "every byte is as it was written"
            console.print(f"{report.files} files, {report.bytes / 1e6:.1f} MB, {report.objects} objects: {count}")
            if dropped is not None:
                console.print(f"version {dropped.version}: {dropped.operation}, {dropped.objects} left")
        return EXIT_BAD_INPUT if report.problems and dropped is None else EXIT_OK


@dataclass(frozen=True)
class Versions:
    """Print what was done, oldest first."""

    library: LibraryPath
    """The library."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Print; returns the exit code."""
        found = versions(self.library)
        keys = ("version", "parent", "created", "operation", "objects")
        rows = [{key: getattr(manifest, key) for key in keys} for manifest in found]
        if self.json:
            print_json({"versions": rows})
            return EXIT_OK
        table = Table(box=None, pad_edge=False, header_style="bold")
        for key in keys:
            table.add_column(key, justify="right" if key in ("version", "parent", "objects") else "left")
        for row in rows:
            table.add_row(*(shown(str(value)) for value in row.values()))
        print_table(stdout_console(), table)
        return EXIT_OK


@dataclass(frozen=True)
class Checkout:
    """Make an earlier version the newest one again; nothing is deleted."""

    library: LibraryPath
    """The library."""
    version: tyro.conf.Positional[int]
    """As versions prints it."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Commit and print; returns the exit code."""
        manifest = checkout(self.library, self.version).manifest
        document: dict[str, Any] = {"version": manifest.version, "objects": manifest.objects}
        return _say(self.json, document, f"version {manifest.version} is what version {self.version} was")


@dataclass(frozen=True)
class Compact:
    """Merge small segments and leave out what was removed; earlier versions stay until vacuum."""

    library: LibraryPath
    """The library."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Commit and print; returns the exit code."""
        manifest = compact(self.library).manifest
        document: dict[str, Any] = {
            "version": manifest.version, "objects": manifest.objects, "segments": len(manifest.segments)
        }  # fmt: skip
        sentence = f"version {manifest.version}: {manifest.objects} objects in {len(manifest.segments)} segments"
        return _say(self.json, document, sentence)


@dataclass(frozen=True)
class Vacuum:
    """Delete all but the newest versions, and the files that no version names any more."""

    library: LibraryPath
    """The library."""
    keep: int = 1
    """Versions that stay."""
    grace: float = 3600.0
    """Seconds: younger files that no version names stay, as a writer may be about to name them."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Delete and print; returns the exit code."""
        files, size = vacuum(self.library, keep=self.keep, grace=self.grace)
        return _say(self.json, {"files": files, "bytes": size}, f"{files} files deleted, {size / 1e6:.1f} MB")


@dataclass(frozen=True)
class Export:
    """Write the objects for other programs."""

    library: LibraryPath
    """The library."""
    out: tyro.conf.Positional[Path]
    """File or folder to write; there must be none."""
    form: Literal["parquet", "lance", "folders"] = "folders"
    """folders: object.glb and demonstration.json each. parquet: one file. lance: a data set, needs pylance."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Write and print; returns the exit code."""
        library = Library.open(self.library, descriptor=None)
        if self.form == "folders":
            library.save(self.out)
        else:
            export_table(library.snapshot, self.out, self.form)
        return _say(self.json, {"objects": len(library), "out": str(self.out)}, f"{len(library)} objects in {self.out}")


@dataclass(frozen=True)
class LibraryCommand:
    """Keep demonstrations on disk and look at them."""

    command: tyro.conf.OmitSubcommandPrefixes[
        Annotated[Build, tyro.conf.subcommand("build")]
        | Annotated[Add, tyro.conf.subcommand("add")]
        | Annotated[Remove, tyro.conf.subcommand("remove")]
        | Annotated[List, tyro.conf.subcommand("ls")]
        | Annotated[ShowLibrary, tyro.conf.subcommand("show")]
        | Annotated[Explain, tyro.conf.subcommand("explain")]
        | Annotated[Verify, tyro.conf.subcommand("verify")]
        | Annotated[Versions, tyro.conf.subcommand("versions")]
        | Annotated[Checkout, tyro.conf.subcommand("checkout")]
        | Annotated[Compact, tyro.conf.subcommand("compact")]
        | Annotated[Vacuum, tyro.conf.subcommand("vacuum")]
        | Annotated[Export, tyro.conf.subcommand("export")]
    ]

    def run(self) -> int:
        """Run what was chosen; returns the exit code."""
        return self.command.run()

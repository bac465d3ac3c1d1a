"""`graft library build DIR... --out LIBRARY`."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

import tyro
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from graft.cli import EXIT_FAILED, EXIT_OK
from graft.cli.options import print_json, shown, stdout_console
from graft.errors import InputError
from graft.features import GeometricDescriptor
from graft.library import BuildReport, LocalExecutor, RayExecutor, build
from graft.library.building import FAILURES, Progress

PRINTED = 5
"""Failures and duplicates that are printed; all failures are in the file."""


def chosen_executor(name: Literal["local", "ray"], address: str | None) -> RayExecutor | None:
    """Return the cluster that flags ask for, connected; None for this machine.

    Raises:
        InputError: An address without ray, or no cluster there.
    """
    if name == "local":
        if address is not None:
            raise InputError(f"--address {address}: expected with --executor ray")
        return None
    executor = RayExecutor(address)
    try:
        executor.connect()
    except ConnectionError as error:
        raise InputError(f"--address {address}: no Ray cluster there: {error}") from None
    return executor


@dataclass(frozen=True)
class Build:
    """Add every object under some folders; stopped, it goes on where it was when it is called again.

    Taken are folders with a demonstration.json, and folders of labelled objects (object.json with graspable_parts),
    whose contacts are the middles of their graspable parts. Exit code 1 when some gave nothing.
    """

    folders: tyro.conf.Positional[tuple[Path, ...]]
    """Searched through and through."""
    out: Path
    """The library; made when there is none."""
    workers: int = os.cpu_count() or 1
    """Processes of this machine."""
    executor: Literal["local", "ray"] = "local"
    """local: processes of this machine. ray: the cores of a Ray cluster whose nodes see the folders and the library."""
    address: str | None = None
    """Of the Ray cluster's head; by default one is started on this machine."""
    shard: str = "1/1"
    """i/n: only every n-th folder from the i-th on; for job arrays, whose jobs may run at the same time."""
    samples: bool = True
    """Of a new library: store surface samples, 49 kB a part; without them they are made when a match is read."""
    descriptor: Literal["geometric", "none"] = "geometric"
    """What parts are described by."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Build and print; returns the exit code."""
        found = re.fullmatch(r"(\d+)/(\d+)", self.shard)
        if found is None:
            raise InputError(f"--shard: expected i/n, got {self.shard!r}")
        if not self.folders:
            raise InputError("expected at least one folder of objects")
        with _progress() as progress:
            report = build(
                self.folders,
                self.out,
                descriptor=GeometricDescriptor() if self.descriptor == "geometric" else None,
                executor=chosen_executor(self.executor, self.address) or LocalExecutor(self.workers),
                shard=(int(found[1]), int(found[2])),
                samples=self.samples,
                progress=progress,
            )
        if self.json:
            document = {**asdict(report), "failures": [{"folder": f, "reason": r} for f, r in report.failures]}
            document["duplicates"] = [{"folder": f, "name": n} for f, n in report.duplicates]
            print_json(document)
        else:
            self._print(report)
        return EXIT_FAILED if report.failures else EXIT_OK

    def _print(self, report: BuildReport) -> None:
        console = stdout_console()
        for folder, reason in report.failures[:PRINTED]:
            console.print(f"[red]failed[/] {shown(reason if folder in reason else f'{folder}: {reason}')}")
        if len(report.failures) > PRINTED:
            console.print(f"[red]failed[/] {len(report.failures)} in all: {shown(str(self.out / FAILURES))}")
        for folder, name in report.duplicates[:PRINTED]:
            console.print(f"[yellow]left out[/] {shown(name)}, the library has it already: {shown(folder)}")
        console.print(
            f"version {report.version}: {report.added} objects added from {report.folders} folders, "
            f"{report.skipped} folders were in it, {len(report.duplicates)} duplicates, "
            f"{len(report.failures)} failed, {report.seconds:.1f} s"
        )


@contextmanager
def _progress() -> Iterator[Progress]:
    """Show how far it is and when it will be done, on stderr, when that is a terminal."""
    console = Console(file=sys.stderr)
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn(),
    )  # fmt: skip
    with Bar(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("reading", total=None)

        def progress(done: int, total: int, failed: int) -> None:
            what = "reading" if not failed else f"reading, {failed} failed"
            bar.update(task, description=what, completed=done, total=total)

        yield progress

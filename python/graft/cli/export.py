"""`graft export SRC DST`: episodes from one trainer's format to another's."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

import tyro
from rich.console import Console
from rich.progress import Progress, TextColumn, TimeElapsedColumn

from graft.cli import EXIT_OK
from graft.cli.options import print_json
from graft.datagen.export import export_episodes
from graft.errors import printable


@dataclass(frozen=True)
class Export:
    """Copy episodes between robomimic's HDF5 and LeRobot datasets.

    Run again, it goes on where it was interrupted; episodes that are there already are not written twice.
    """

    source: tyro.conf.Positional[Path]
    """What is read: an .hdf5 file (robomimic's, with MimicGen's datagen_info), or the folder of a LeRobot dataset that
    graft wrote."""
    target: tyro.conf.Positional[Path]
    """What is written, or added to: an .hdf5 file or a folder."""
    format: Literal["auto", "robomimic", "lerobot"] = "auto"
    """Format of the target; auto takes robomimic for .hdf5 and .h5, lerobot for a folder."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Export and say what was written; returns the exit code."""
        console = Console(stderr=True)
        columns = TextColumn("{task.completed} episodes"), TimeElapsedColumn()
        with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
            task = bar.add_task("export", total=None)
            done = export_episodes(
                self.source,
                self.target,
                None if self.format == "auto" else self.format,
                progress=lambda count: bar.update(task, completed=count),
            )
        if self.json:
            print_json({"source": str(self.source), "target": str(self.target), **asdict(done)})
        else:
            already = f", {done.present} were there already" if done.present else ""
            print(
                f"{printable(str(self.target))}: {done.written} episodes, {done.steps} steps ({done.format}){already}"
            )
        return EXIT_OK

"""Episodes from one format to another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from graft.datagen.episode import Episode
from graft.datagen.read import HDF5_SUFFIXES, Format, format_of, read_episodes
from graft.datagen.writers.lerobot import LeRobotWriter
from graft.datagen.writers.robomimic import RobomimicWriter
from graft.errors import InputError


@dataclass(frozen=True)
class Exported:
    """What an export did.

    Attributes:
        format: Of the target.
        written: Episodes that were written.
        present: Episodes that were there already.
        steps: Of the episodes that were written.
    """

    format: Format
    written: int
    present: int
    steps: int


def open_writer(path: str | Path, format: Format | None = None) -> RobomimicWriter | LeRobotWriter:
    """Open a file or dataset for writing; by its suffix unless the format is given.

    Raises:
        InputError: The suffix is not the format's, or what is there cannot be added to.
    """
    path = Path(path)
    chosen = format or format_of(path)
    if chosen == "lerobot":
        if path.suffix.lower() in HDF5_SUFFIXES:
            raise InputError("a LeRobot dataset is a folder, this is the name of an HDF5 file", path=path)
        return LeRobotWriter(path)
    if path.suffix.lower() not in HDF5_SUFFIXES:
        raise InputError(f"a robomimic file ends in {' or '.join(HDF5_SUFFIXES)}", path=path)
    return RobomimicWriter(path)


def export_episodes(
    source: str | Path,
    target: str | Path,
    format: Format | None = None,
    *,
    progress: Callable[[int], None] = lambda _: None,
) -> Exported:
    """Copy all episodes into another format, in the memory of one; again, it goes on where it was interrupted.

    Nothing is lost but that LeRobot's videos are compressed with loss.

    Args:
        source: What `read_episodes` reads.
        target: Written, or added to.
        format: Of the target; by its suffix by default.
        progress: Told the number of episodes done.

    Raises:
        InputError: The source cannot be read, or the target not written; what was written by then stays.
    """
    source, target = Path(source), Path(target)
    if source.resolve() == target.resolve():
        raise InputError("source and target are the same", path=target)
    episodes = read_episodes(source)
    first = next(episodes, None)  # a bad source is found before anything is made
    if first is None:
        raise InputError("there are no episodes", path=source)
    written = present = steps = 0
    with open_writer(target, format) as writer:
        episode: Episode | None = first
        while episode is not None:
            if writer.append(episode):
                written += 1
                steps += len(episode)
            else:
                present += 1
            progress(written + present)
            episode = next(episodes, None)
    return Exported(format or format_of(target), written, present, steps)

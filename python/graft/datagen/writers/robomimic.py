"""robomimic's HDF5, with MimicGen's `datagen_info`, so that a killed writer loses nothing that was finished.

HDF5 tears when its writer is killed: one flushed file holds everything or nothing. So every episode is first a file of
its own, written whole and renamed into `<file>.parts/`; each of them is a file that robomimic reads. `close` copies
them, and what the file held before, into a draft that replaces the file in one rename, and removes the parts. Whatever
is interrupted, the next writer finds the finished episodes in the file or in the parts, and reads names, not counts, so
that none is there twice.
"""

from __future__ import annotations

import json
import re
import shutil
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from graft.datagen.durable import locked, remove_drafts
from graft.datagen.episode import SUCCESS, Episode
from graft.datagen.hdf5 import load_h5py, opened, written
from graft.datagen.layout import SCHEMA, write_episode
from graft.errors import InputError

VALID_EVERY = 10
"""Every tenth episode is in mask/valid, the others in mask/train: robomimic's split by default is 10 %, too."""

_PART = re.compile(r"demo_(\d+)\.hdf5")
_DEMO = re.compile(r"demo_(\d+)")


def parts_folder(path: Path) -> Path:
    """Return where the episodes of an HDF5 file are until it is closed."""
    return path.with_name(path.name + ".parts")


def part_files(path: Path) -> list[Path]:
    """Return the files of episodes that are not in the HDF5 file yet, in the order in which they were written."""
    folder = parts_folder(path)
    found = [p for p in folder.iterdir() if _PART.fullmatch(p.name)] if folder.is_dir() else []
    return sorted(found, key=lambda p: int(p.stem.removeprefix("demo_")))


def demo_keys(data: Any) -> list[str]:
    """Return the keys of the episodes in the group `data`, in the order of their numbers."""
    return sorted((key for key in data if _DEMO.fullmatch(key)), key=lambda key: int(key.removeprefix("demo_")))


def write_part(path: Path, episode: Episode, *, key: str = "demo_0", cameras: bool = True) -> None:
    """Write a file of one episode, whole or absent."""
    with written(path) as file:
        data = file.create_group("data")
        write_episode(data.create_group(key), episode, cameras=cameras)
        _finish(file, len(episode), json.dumps(episode.env_args), {})


class RobomimicWriter:
    """Writes episodes into an HDF5 file; a context manager that closes it when its block ends well.

    Args:
        path: The file; one that graft wrote before gets more episodes.

    Raises:
        InputError: Another process is writing it, or somebody else's file is there.
    """

    def __init__(self, path: str | Path) -> None:
        load_h5py()
        self.path = Path(path)
        self._parts = parts_folder(self.path)
        self._names: set[str] = set()
        self._next = 0
        self._exit = ExitStack()
        try:
            self._exit.enter_context(locked(self._parts / "lock"))
            self._exit.callback(self._remove_empty)
            self._recover()
        except BaseException:
            self._exit.close()
            raise

    @property
    def names(self) -> frozenset[str]:
        """Names of the episodes that are there."""
        return frozenset(self._names)

    def append(self, episode: Episode) -> bool:
        """Write an episode; it is on disk when this returns.

        Returns:
            False if an episode of that name is there already; nothing is written then.

        Raises:
            InputError: The system refuses (disk full); the episodes before are safe, and this one can be tried again.
        """
        if episode.name in self._names:
            return False
        write_part(self._parts / f"demo_{self._next:06d}.hdf5", episode)
        self._next += 1
        self._names.add(episode.name)
        return True

    def close(self) -> None:
        """Gather all episodes in the file.

        Raises:
            InputError: The system refuses; the episodes stay in the parts, and the next writer gathers them.
        """
        try:
            parts = part_files(self.path)
            if parts:
                self._gather(parts)
            for part in parts:
                part.unlink()
        finally:
            self._exit.close()

    def __enter__(self) -> RobomimicWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        else:
            self._exit.close()

    def _remove_empty(self) -> None:
        """Leave no folder behind that holds nothing but the lock; called while it is held."""
        if [p.name for p in self._parts.iterdir()] == ["lock"]:
            shutil.rmtree(self._parts, ignore_errors=True)

    def _recover(self) -> None:
        remove_drafts(self._parts)
        for draft in self.path.parent.glob(f".{self.path.name}.*"):
            remove_own_draft(draft, self.path.name)
        if self.path.exists():
            with opened(self.path) as file:
                if "graft_schema" not in file.attrs:
                    raise InputError("graft did not write this file; nothing is added to it", path=self.path)
                self._names.update(_name(file["data"][key]) for key in demo_keys(file["data"]))
                self._next = len(self._names)
        for part in part_files(self.path):
            with opened(part) as file:
                (key,) = demo_keys(file["data"])
                name = _name(file["data"][key])
            if name in self._names:  # killed between the rename of the file and the removal of the parts
                part.unlink()
                continue
            self._names.add(name)
            self._next = max(self._next, int(part.stem.removeprefix("demo_")) + 1)

    def _gather(self, parts: list[Path]) -> None:
        env_args, total, masks = None, 0, _Masks()
        with written(self.path) as target:
            data = target.create_group("data")
            for source in [self.path, *parts] if self.path.exists() else parts:
                with opened(source) as file:
                    env_args = env_args or file["data"].attrs["env_args"]
                    for key in demo_keys(file["data"]):
                        new = f"demo_{masks.count}"
                        file["data"].copy(key, data, name=new)
                        total += int(data[new].attrs["num_samples"])
                        masks.add(new, str(data[new].attrs["outcome"]))
            assert env_args is not None
            _finish(target, total, env_args, masks.keys)


class _Masks:
    """Filter keys of robomimic: which episodes train, which validate, which succeeded."""

    def __init__(self) -> None:
        self.count = 0
        self.keys: dict[str, list[str]] = {"train": [], "valid": [], SUCCESS: []}

    def add(self, key: str, outcome: str) -> None:
        self.keys["valid" if self.count % VALID_EVERY == VALID_EVERY - 1 else "train"].append(key)
        if outcome == SUCCESS:
            self.keys[SUCCESS].append(key)
        self.count += 1


def remove_own_draft(draft: Path, name: str) -> None:
    """Remove a draft of the file `name` that a killed writer left."""
    if re.fullmatch(re.escape(f".{name}.") + "[0-9a-f]{8}", draft.name):
        draft.unlink(missing_ok=True)


def _name(group: Any) -> str:
    return str(group.attrs["name"])


def _finish(file: Any, total: int, env_args: str, masks: dict[str, list[str]]) -> None:
    file.attrs["graft_schema"] = SCHEMA
    file["data"].attrs["total"] = total
    file["data"].attrs["env_args"] = env_args
    for key, demos in masks.items():
        if demos:
            file.create_dataset(f"mask/{key}", data=np.array(demos, "S"))

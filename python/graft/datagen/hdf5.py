"""HDF5 files: opened with suspicion, written so that they are whole or absent."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from graft.checks import Floats, checked_array
from graft.datagen.durable import drafted
from graft.errors import InputError, MissingExtraError
from graft.io.guards import existing_file, malformed_is_input_error

MAX_DATASET_BYTES = 4 << 30
"""Largest array of an episode that is read: 4 GiB, 10,000 frames of 380 x 380; a header may claim any size."""


def load_h5py() -> Any:
    """Return the module h5py."""
    try:
        import h5py
    except ImportError:
        raise MissingExtraError("reading and writing HDF5", package="h5py", extra="data") from None
    return h5py


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """Open an HDF5 file for reading; whatever HDF5 makes of a broken one becomes one line.

    Raises:
        InputError: No such file, no HDF5, or a truncated one.
    """
    h5py = load_h5py()
    existing_file(path)
    try:
        with malformed_is_input_error(path, "HDF5 file"), h5py.File(path, "r") as file:
            yield file
    except (OSError, RuntimeError) as error:
        if isinstance(error, InputError):
            raise
        text = str(error).splitlines()[0] if str(error) else type(error).__name__
        what = "truncated HDF5 file" if "truncated" in text else "not an HDF5 file, or a broken one"
        raise InputError(f"{what}: {text}", path=path) from None


class _Patient:
    """A file for HDF5 that never tells it of a failure: HDF5 cannot let go of files that it cannot write to.

    The first failure is kept in `error`, and from then on everything is thrown away.
    """

    def __init__(self, raw: io.FileIO) -> None:
        self.raw = raw
        self.error: OSError | None = None

    def write(self, data: Any) -> int:
        """Write all of `data`, or keep the error."""
        view = memoryview(data).cast("B")
        done = 0
        while done < len(view) and self.error is None:
            try:
                done += self.raw.write(view[done:])
            except OSError as error:
                self.error = error
        return len(view)

    def truncate(self, size: int) -> int:
        """Set the length of the file, or keep the error."""
        try:
            self.raw.truncate(size)
        except OSError as error:
            self.error = self.error or error
        return size

    def __getattr__(self, name: str) -> Any:
        return getattr(self.raw, name)


@contextmanager
def written(path: Path) -> Iterator[Any]:
    """Give an empty HDF5 file to fill, which is at `path` when the block has ended well, whole.

    Raises:
        InputError: The system refuses (disk full); nothing is at `path` that was not there before.
    """
    h5py = load_h5py()
    with drafted(path) as draft, io.FileIO(draft, "x+") as raw:
        patient = _Patient(raw)
        try:
            with h5py.File(patient, "w") as file:
                yield file
        except (OSError, RuntimeError) as error:
            raise patient.error or error from error
        if patient.error is not None:
            raise patient.error


def numbers(group: Any, key: str, path: Path, shape: tuple[int | None, ...] | None) -> Floats:
    """Return a dataset as finite float64.

    Args:
        group: An h5py group.
        key: Of the dataset.
        path: Its file, for messages.
        shape: That is expected, None for any length; None for any shape.

    Raises:
        InputError: Not there, too large, no numbers, another shape, not finite; the message has file and key.
    """
    dataset = stored_array(group, key, path)
    name = f"{group.name}/{key}".replace("//", "/")
    if dataset.dtype.kind not in "biuf":
        raise InputError(f"{name}: expected numbers, got {dataset.dtype}", path=path)
    with malformed_is_input_error(path, name):
        array = np.asarray(dataset[()], np.float64)
        return checked_array(name, array, (None,) * array.ndim if shape is None else shape)  # type: ignore[no-any-return]


def numbers_in(group: Any, key: str, path: Path, shape: tuple[int, ...]) -> dict[str, Floats]:
    """Return the datasets of a group by name, each as `numbers` gives it; none where there is no such group."""
    if not has(group, key, path):
        return {}
    return {name: numbers(group, f"{key}/{name}", path, shape) for name in subgroup(group, key, path)}


def has(group: Any, key: str, path: Path) -> bool:
    """Whether there is something at `key`.

    Raises:
        InputError: A link on the way leads elsewhere; such links could read anything.
    """
    h5py = load_h5py()
    here = group
    for step in key.strip("/").split("/"):
        link = here.get(step, getlink=True) if isinstance(here, h5py.Group) else None
        if link is None:
            return False
        if not isinstance(link, h5py.HardLink):
            raise InputError(f"{here.name}/{step}: links to other places are not followed", path=path)
        here = here[step]
    return True


def subgroup(group: Any, key: str, path: Path) -> Any:
    """Return a group of a group; see `has`."""
    if not has(group, key, path) or not hasattr(group[key], "keys"):
        raise InputError(f"{group.name}/{key}: expected a group, there is none".replace("//", "/"), path=path)
    return group[key]


def stored_array(group: Any, key: str, path: Path) -> Any:
    """Return an h5py dataset that lies in the file itself and is not larger than `MAX_DATASET_BYTES`."""
    name = f"{group.name}/{key}".replace("//", "/")
    if not has(group, key, path) or not hasattr(group[key], "dtype"):
        raise InputError(f"{name}: expected an array, there is none", path=path)
    dataset = group[key]
    if dataset.external or dataset.is_virtual:
        raise InputError(f"{name}: arrays kept in other files are not read", path=path)
    if dataset.size is None or dataset.size * dataset.dtype.itemsize > MAX_DATASET_BYTES:
        raise InputError(f"{name}: larger than the {MAX_DATASET_BYTES} bytes that are read", path=path)
    return dataset

"""Folders in which files appear whole, one writer at a time, and what a killed writer left is found again."""

from __future__ import annotations

import errno
import os
import re
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from graft.errors import InputError
from graft.io.atomic import write_whole

_DRAFT = re.compile(r"\..+\.[0-9a-f]{8}")
"""What `write_whole` and `drafted` call a file that is not whole yet."""


def sync_folder(folder: Path) -> None:
    """Wait until the names in a folder are on disk, so that a rename outlives a power cut."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def put(path: Path, data: bytes) -> None:
    """Write a file, and folders on the way, so that it is whole or absent, also after a power cut."""
    make_folder(path.parent)
    write_whole(path, data)
    sync_folder(path.parent)


def make_folder(folder: Path) -> None:
    """Make a folder and those on the way to it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be made: {error.strerror or error}", path=folder) from None


def swap(path: Path, data: bytes) -> None:
    """Write a file so that it is whole or absent, without waiting for the disk; a power cut may undo or empty it.

    For what follows from other files.
    """
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        draft.write_bytes(data)
        draft.replace(path)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", path=path) from error
    finally:
        draft.unlink(missing_ok=True)


@contextmanager
def drafted(path: Path) -> Iterator[Path]:
    """Give a path to write to beside `path`; when the block ends well it is renamed to it, else removed.

    For libraries that write to paths (HDF5, mp4). What they raise when the system refuses becomes one line.
    """
    make_folder(path.parent)
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        yield draft
        with draft.open("rb") as file:
            os.fsync(file.fileno())
        draft.replace(path)
        sync_folder(path.parent)
    except InputError:
        raise
    except (OSError, RuntimeError) as error:  # RuntimeError: HDF5's
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be written: {reason}", path=path) from error
    finally:
        draft.unlink(missing_ok=True)


def remove_drafts(folder: Path) -> None:
    """Remove what killed writers did not finish, in a folder and below it."""
    for path in folder.rglob(".*"):
        if path.is_file() and _DRAFT.fullmatch(path.name):
            path.unlink(missing_ok=True)


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold a lock that ends with the process at the latest.

    Raises:
        InputError: Another process holds it.
    """
    import fcntl

    make_folder(path.parent)
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", path=path) from None
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno not in (errno.EAGAIN, errno.EACCES):
                raise InputError(f"cannot be locked: {error.strerror or error}", path=path) from None
            raise InputError("another process is writing here", path=path) from None
        yield
    finally:
        os.close(handle)

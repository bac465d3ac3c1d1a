"""Files of a library: written once, flushed to the disk, never changed; read whole through a memory map.

A file is complete on the disk before anything names it, and what names it holds its size and its xxh3 checksum.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import secrets
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import pyarrow as pa
import xxhash

from graft.errors import InputError

LINKLESS = {errno.EPERM, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK, errno.EACCES}
"""What systems without hard links answer to a request for one (FAT, some network and user-space file systems)."""

LOCK = ".lock"
"""Held while a version is placed where there are no hard links."""


@dataclass(frozen=True)
class FileEntry:
    """What a manifest knows of a file: its name in the folder of segments, its bytes, their xxh3-128 in hex."""

    name: str
    size: int
    xxh3: str


class HashingFile:
    """A binary file being written that keeps the checksum of its bytes; what pyarrow writes to."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._hash = xxhash.xxh3_128()
        self._marked = xxhash.xxh3_64()
        self._size = 0

    def write(self, data: bytes) -> int:
        """Write and count."""
        view = memoryview(data).cast("B")
        self._hash.update(view)
        self._marked.update(view)
        self._size += len(view)
        self._file.write(view)
        return len(view)

    def mark(self) -> int:
        """Return the xxh3-64 of what was written since the last mark."""
        digest = self._marked.intdigest()
        self._marked.reset()
        return digest

    def tell(self) -> int:
        """Return the bytes written so far."""
        return self._size

    def flush(self) -> None:
        """Hand the bytes to the system."""
        self._file.flush()

    @property
    def closed(self) -> bool:
        """Whether the file below is closed."""
        return self._file.closed

    def writable(self) -> bool:
        """Say yes; pyarrow asks."""
        return True

    def readable(self) -> bool:
        """Say no; pyarrow asks."""
        return False

    def seekable(self) -> bool:
        """Say no; pyarrow asks."""
        return False

    def close(self) -> None:
        """Flush only: whoever opened the file closes it, after fsync."""
        self.flush()

    def entry(self, name: str) -> FileEntry:
        """Return what a manifest should know of it."""
        return FileEntry(name, self._size, self._hash.hexdigest())


def write_new(path: Path, write: Callable[[HashingFile], None]) -> FileEntry:
    """Create a file, let `write` fill it, flush it to the disk, and return its entry.

    Raises:
        InputError: The system refuses (a full disk, no permission); no file is left then.
    """
    try:
        with path.open("xb") as file:
            sink = HashingFile(file)
            write(sink)
            file.flush()
            os.fsync(file.fileno())
        return sink.entry(path.name)
    except OSError as error:
        discard(path)
        raise InputError(f"cannot be written: {error.strerror or error}", path=path) from error
    except BaseException:
        discard(path)
        raise


def discard(path: Path) -> None:
    """Delete a file that nothing names, if the system lets us; `vacuum` does otherwise."""
    with contextlib.suppress(OSError):
        path.unlink()


def sync_folder(folder: Path) -> None:
    """Flush a folder's list of files to the disk.

    Raises:
        InputError: The system refuses.
    """
    try:
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", path=folder) from error


def place_new(path: Path, data: bytes) -> None:
    """Make a file appear at `path` whole and on the disk, unless there is one already.

    Written beside it and flushed, then given its name by a hard link, which fails where the name is taken.

    Raises:
        FileExistsError: The name is taken.
        InputError: The system refuses.
    """
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with draft.open("xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        try:
            os.link(draft, path)
        except OSError as error:
            if error.errno not in LINKLESS:
                raise
            _rename_new(draft, path)
        sync_folder(path.parent)
    except FileExistsError:
        raise
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", path=path) from error
    finally:
        discard(draft)


def _rename_new(draft: Path, path: Path) -> None:
    """Rename without replacing, under a lock that every writer of such a file system takes."""
    with (path.parent / LOCK).open("ab") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if path.exists():
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))
        draft.rename(path)


def check_size(folder: Path, entry: FileEntry) -> None:
    """Compare a file's size with its entry, without reading it.

    Raises:
        InputError: It is missing or of another size.
    """
    path = folder / entry.name
    try:
        size = os.stat(path).st_size
    except OSError as error:
        raise InputError(f"a segment's file is missing: {error.strerror}", path=path) from None
    if size != entry.size:
        raise InputError(f"damaged: expected {entry.size} bytes, got {size}", path=path)


def map_file(folder: Path, entry: FileEntry, *, check: bool) -> pa.Buffer:
    """Return a file's bytes, mapped into memory; no handle stays open.

    Args:
        folder: Where it lies.
        entry: What it should be.
        check: Read all of it and compare its checksum.

    Raises:
        InputError: It is missing, of another size, or its checksum is another.
    """
    check_size(folder, entry)
    path = folder / entry.name
    try:
        with pa.memory_map(str(path)) as file:
            buffer = file.read_buffer()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", path=path) from None
    if buffer.size != entry.size:
        raise InputError(f"damaged: expected {entry.size} bytes, got {buffer.size}", path=path)
    if check and xxhash.xxh3_128_hexdigest(memoryview(buffer)) != entry.xxh3:
        raise InputError("damaged: its bytes do not have the checksum that was written", path=path)
    return buffer

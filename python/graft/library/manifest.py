"""The manifest of one version of a library: which segments it has, of what size and checksum.

A version is a file `versions/00000007.json`: one line of JSON and, on the next, the xxh3-128 of that line. It is
written once; the newest one that is whole is the library.
"""

from __future__ import annotations

import json
import re
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import xxhash

from graft.errors import GraftError, InputError
from graft.library.files import FileEntry

FORMAT = "graft-library"
SCHEMA = 1
"""Version of what manifests and segments say. There is one so far: older ones would be read through a migration."""

VERSIONS, SEGMENTS = "versions", "segments"
"""Folders of a library."""

VERSION_NAME = re.compile(r"^(\d{8,})\.json$")

LARGEST_MANIFEST = 1 << 30
"""Bytes; 1e9 objects in segments of 1e5 make 10 MB."""


class LibraryChangedError(GraftError):
    """Another writer changed the library meanwhile, so that this change no longer fits: open it again and retry."""


class DamagedVersionError(InputError):
    """A version's file that is not what was written."""


@dataclass(frozen=True)
class SegmentEntry:
    """One segment: objects that were committed together.

    Attributes:
        id: Random; its files' names begin with it.
        objects: How many, removed ones included.
        parts: Of all of them.
        files: By table: bounds, parts, graphs, objects.
        n_removed: How many of the objects are removed.
        removed: The file of their rows; None when there are none.
    """

    id: str
    objects: int
    parts: int
    files: dict[str, FileEntry]
    n_removed: int = 0
    removed: FileEntry | None = None

    @property
    def all_files(self) -> tuple[FileEntry, ...]:
        """Every file that it needs."""
        return (*self.files.values(), *(() if self.removed is None else (self.removed,)))


@dataclass(frozen=True)
class Manifest:
    """One version of a library.

    Attributes:
        version: Number, rising from 1.
        parent: Version that it was made from; 0 for the first.
        created: Time, ISO 8601, UTC.
        operation: What made it ("add 12").
        descriptor: Name of the descriptor; None when parts have none.
        dim: Length of a descriptor; 0 when there is none.
        relations: Length of a part's relations; 0 while the library is empty.
        saliency: gamma of the stored source masses.
        samples: Whether surface samples are stored; else they are made again when a match is read.
        segments: In the order of the library.
    """

    version: int
    parent: int
    created: str
    operation: str
    descriptor: str | None
    dim: int
    relations: int
    saliency: float
    samples: bool
    segments: tuple[SegmentEntry, ...] = ()

    @property
    def objects(self) -> int:
        """Number of objects, without the removed ones."""
        return sum(s.objects - s.n_removed for s in self.segments)

    def encode(self) -> bytes:
        """Return the bytes of the version's file."""
        body = json.dumps({"format": FORMAT, "schema": SCHEMA, **asdict(self)}, separators=(",", ":")).encode()
        return body + b"\n" + xxhash.xxh3_128_hexdigest(body).encode() + b"\n"


def version_path(folder: Path, version: int) -> Path:
    """Return the file of a version."""
    return folder / VERSIONS / f"{version:08d}.json"


def version_numbers(folder: Path) -> list[int]:
    """Return the numbers of a library's versions, whole or not, rising.

    Raises:
        InputError: The folder cannot be listed.
    """
    try:
        names = [entry.name for entry in (folder / VERSIONS).iterdir()]
    except OSError as error:
        raise InputError(f"cannot be listed: {error.strerror}", path=folder / VERSIONS) from None
    return sorted(int(found[1]) for found in map(VERSION_NAME.match, names) if found)


def read_manifest(folder: Path, version: int) -> Manifest:
    """Read a version's file and check it.

    Raises:
        DamagedVersionError: It is not what was written.
        InputError: There is none, it cannot be read, or a newer graft wrote it.
    """
    path = version_path(folder, version)
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_MANIFEST)
    except FileNotFoundError:
        raise InputError("no such version", path=path) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", path=path) from None
    body, line, rest = data.partition(b"\n")
    if not line or rest != xxhash.xxh3_128_hexdigest(body).encode() + b"\n":
        raise DamagedVersionError("damaged: its bytes do not have the checksum that was written", path=path)
    words = json.loads(body)
    if not isinstance(words, dict) or words.pop("format", None) != FORMAT:
        raise DamagedVersionError(f"expected the manifest of a {FORMAT}, got another file", path=path)
    schema = words.pop("schema", None)
    if schema != SCHEMA:
        newer = ", a newer graft wrote it" if isinstance(schema, int) and schema > SCHEMA else ""
        raise InputError(f"schema: expected {SCHEMA}, got {schema!r}{newer}", path=path)
    try:
        manifest = Manifest(**{**words, "segments": tuple(_segment(s) for s in words["segments"])})
    except (TypeError, KeyError, AttributeError) as error:
        raise DamagedVersionError(f"expected the manifest of a {FORMAT}: {error}", path=path) from None
    if manifest.version != version:
        raise DamagedVersionError(f"expected version {version}, got {manifest.version}", path=path)
    return manifest


def _segment(words: dict[str, Any]) -> SegmentEntry:
    files = {table: FileEntry(**entry) for table, entry in words["files"].items()}
    removed = None if words["removed"] is None else FileEntry(**words["removed"])
    return SegmentEntry(**{**words, "files": files, "removed": removed})

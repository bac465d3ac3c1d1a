"""A library on disk: versions that name segments; changes are new segments and a new version.

    library/versions/00000003.json          what the library was after its third change
    library/segments/9f86d081.graphs.arrow  and bounds, parts, objects: columns, never changed

A change writes its segments, flushes them, and then places the next version's file, which only one writer can. One
that comes second applies its change to what the other left. Nothing but `vacuum` ever deletes.
"""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from graft.errors import InputError, InputWarning
from graft.graph import SALIENCY
from graft.library.files import check_size, discard, place_new, sync_folder
from graft.library.manifest import (
    SEGMENTS,
    VERSIONS,
    DamagedVersionError,
    LibraryChangedError,
    Manifest,
    SegmentEntry,
    read_manifest,
    version_numbers,
    version_path,
)
from graft.library.segment import Segment
from graft.library.tables import GRAPHS, REMOVED, write_table
from graft.objects import Ints

ATTEMPTS = 1000
"""Each failed one means that another writer's change was committed."""


def is_store(path: str | Path) -> bool:
    """Tell whether a folder is a library rather than a folder of demonstrations."""
    return (Path(path) / VERSIONS).is_dir() and (Path(path) / SEGMENTS).is_dir()


@dataclass(frozen=True, eq=False)
class Snapshot:
    """One version of a library, open.

    Attributes:
        path: The library's folder.
        manifest: What the version says.
        damaged: Versions after it whose files are damaged.
        before: Segments of another version, of which those that are in this one, too, stay mapped.
    """

    path: Path
    manifest: Manifest
    damaged: tuple[int, ...] = ()
    before: tuple[Segment, ...] = field(default=(), repr=False)

    @cached_property
    def segments(self) -> tuple[Segment, ...]:
        """Its segments, mapped as they are needed."""
        folder, manifest = self.path / SEGMENTS, self.manifest
        mapped = {segment.entry.id: segment for segment in self.before}
        same = [mapped.get(entry.id) for entry in manifest.segments]
        return tuple(
            old if old and old.entry == entry else Segment(folder, entry, manifest.descriptor, manifest.saliency)
            for entry, old in zip(manifest.segments, same, strict=True)
        )

    @cached_property
    def starts(self) -> Ints:
        """(segments + 1,) position of every segment's first object, removed ones counted."""
        return np.concatenate(([0], np.cumsum([s.objects for s in self.manifest.segments], dtype=np.int64)))

    def find(self, values: Sequence[object], column: str = "name") -> dict[Any, tuple[int, int]]:
        """Return (segment, row) of those of the names (ids, sources) that are in the library."""
        wanted = pa.array(values, GRAPHS.field(column).type)
        found: dict[Any, tuple[int, int]] = {}
        for number, segment in enumerate(self.segments):
            own = segment.graphs[column]
            rows = np.flatnonzero(pc.is_in(own, value_set=wanted).to_numpy(zero_copy_only=False))
            if segment.live is not None:
                rows = np.intersect1d(rows, segment.live)
            found |= {own[int(row)].as_py(): (number, int(row)) for row in rows}
        return found


def create_store(path: Path, *, descriptor: str | None, dim: int, samples: bool) -> Snapshot:
    """Make an empty library.

    Raises:
        InputError: There is something at `path` already, or the system refuses.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        if any(path.iterdir()):
            raise InputError("expected no such folder or an empty one, it holds files", path=path)
        for name in (SEGMENTS, VERSIONS):
            (path / name).mkdir()
        sync_folder(path)
        sync_folder(path.parent)
    except OSError as error:
        raise InputError(f"cannot be made: {error.strerror or error}", path=path) from None
    first = Manifest(1, 0, _now(), "create", descriptor, dim, 0, SALIENCY, samples)
    _place(path, first)
    return Snapshot(path, first)


def open_store(path: Path, version: int | None = None) -> Snapshot:
    """Open a version of a library, or its newest one that is whole.

    Warns:
        InputWarning: The newest is damaged and an older one was taken; the message names the file.

    Raises:
        InputError: No version is whole, a newer graft wrote it, or a segment's file is missing or cut off.
    """
    if not is_store(path):
        raise InputError("expected a library (folders versions and segments), got something else", path=path)
    numbers = version_numbers(path)
    damaged: list[int] = []
    for number in [version] if version is not None else reversed(numbers):
        try:
            manifest = read_manifest(path, number)
            for entry in (file for segment in manifest.segments for file in segment.all_files):
                check_size(path / SEGMENTS, entry)
        except InputError as error:
            if version is not None or "newer graft" in str(error):
                raise
            damaged.append(number)
            warnings.warn(f"{error}; the version before it is taken", InputWarning, stacklevel=3)
            continue
        return Snapshot(path, manifest, tuple(damaged))
    raise InputError("no version of the library is whole", path=path / VERSIONS)


def commit(path: Path, change: Callable[[Snapshot], Manifest], base: Snapshot | None = None) -> Snapshot:
    """Apply a change to the newest version and place the next one.

    Args:
        path: The library.
        change: Makes the next manifest from the newest version; called again when another writer was faster.
        base: Version to start from; the newest by default.

    Raises:
        InputError: The newest version is damaged, the change is not possible, or the system refuses.
        LibraryChangedError: Other writers were always faster.
    """
    for _ in range(ATTEMPTS):
        newest = version_numbers(path)[-1:]
        current = base if base is not None and newest == [base.manifest.version] else open_whole(path)
        if base is not None and current is not base:
            base = current = replace(current, before=base.segments)
        following = replace(
            change(current),
            version=max([current.manifest.version, *newest]) + 1,
            parent=current.manifest.version,
            created=_now(),
        )
        known = {entry.id for entry in current.manifest.segments}
        for segment in following.segments:
            for entry in segment.all_files if segment.id not in known else ():
                check_size(path / SEGMENTS, entry)
        try:
            _place(path, following)
        except FileExistsError:
            continue
        return Snapshot(path, following, before=current.segments)
    raise LibraryChangedError(f"{path}: other writers changed the library {ATTEMPTS} times meanwhile, try again")


def append(path: Path, entries: Sequence[SegmentEntry], relations: int, base: Snapshot | None = None) -> Snapshot:
    """Commit segments whose files are written.

    Raises:
        InputError: A name is taken, or relations are of another length.
    """
    new = Snapshot(path, replace(_manifest(path, base), segments=tuple(entries)))
    names = [segment.names.take(pa.array(rows_of(segment))) for segment in new.segments]
    wanted: list[str] = pa.chunked_array(names).to_pylist()

    def change(current: Snapshot) -> Manifest:
        taken = current.find(wanted)
        if taken:
            raise InputError(f"library: it has a demonstration called {min(taken)!r} already")
        manifest = current.manifest
        if manifest.relations not in (0, relations):
            raise InputError(f"relations: expected {manifest.relations} a part, as in the library, got {relations}")
        return replace(
            manifest,
            segments=(*manifest.segments, *entries),
            relations=relations,
            operation=f"add {sum(e.objects - e.n_removed for e in entries)}",
        )

    try:
        sync_folder(path / SEGMENTS)
        return commit(path, change, base)
    except InputError:
        _discard(path, entries)
        raise


def _discard(path: Path, entries: Sequence[SegmentEntry]) -> None:
    """Delete segments that no version came to name; where that is not certain they are left to `vacuum`."""
    try:
        named = {entry.id for n in version_numbers(path) for entry in read_manifest(path, n).segments}
    except InputError:
        return
    for file in (file for entry in entries if entry.id not in named for file in entry.all_files):
        discard(path / SEGMENTS / file.name)


def remove(path: Path, names: Iterable[str], base: Snapshot | None = None) -> Snapshot:
    """Commit a version without the objects of these names; their segments stay until `compact` and `vacuum`.

    Raises:
        InputError: A name is not in the library.
    """
    wanted = list(dict.fromkeys(names))

    def change(current: Snapshot) -> Manifest:
        found = current.find(wanted)
        missing = [name for name in wanted if name not in found]
        if missing:
            raise InputError(f"library: it has no demonstration called {missing[0]!r}")
        gone: dict[int, list[int]] = {}
        for number, row in found.values():
            gone.setdefault(number, []).append(row)
        segments = list(current.manifest.segments)
        for number, rows in gone.items():
            segments[number] = without(current.segments[number], rows)
        sync_folder(path / SEGMENTS)
        return replace(current.manifest, segments=tuple(segments), operation=f"remove {len(wanted)}")

    return commit(path, change, base)


def without(segment: Segment, rows: Sequence[int]) -> SegmentEntry:
    """Write that rows of a segment are removed, beside those that are already; return its new entry."""
    left = np.setdiff1d(rows_of(segment), rows)
    gone = np.setdiff1d(np.arange(len(segment)), left)
    batch = pa.RecordBatch.from_arrays([pa.array(gone, pa.int64())], schema=REMOVED)
    name = f"{segment.entry.id}.removed-{len(gone)}-{np.random.default_rng().bytes(4).hex()}.arrow"
    file = write_table(segment.folder / name, REMOVED, [batch])
    return replace(segment.entry, n_removed=len(gone), removed=file)


def checkout(path: str | Path, version: int) -> Snapshot:
    """Commit a version that is what an earlier one was.

    Raises:
        InputError: There is no such version or it is damaged.
        LibraryChangedError: Another writer changed the library meanwhile.
    """
    path = Path(path)
    earlier = open_store(path, version).manifest
    return place_next(path, replace(earlier, operation=f"checkout {version}"), version)


def place_next(path: Path, manifest: Manifest, parent: int) -> Snapshot:
    """Commit a manifest as the version after the last one, whole or not.

    Raises:
        LibraryChangedError: Another writer placed that version meanwhile.
    """
    following = replace(manifest, version=version_numbers(path)[-1] + 1, parent=parent, created=_now())
    try:
        _place(path, following)
    except FileExistsError:
        raise LibraryChangedError(f"{path}: another writer changed the library meanwhile, try again") from None
    return Snapshot(path, following)


def versions(path: str | Path) -> list[Manifest]:
    """Return the versions of a library that are whole, oldest first."""
    whole = []
    for number in version_numbers(Path(path)):
        with contextlib.suppress(DamagedVersionError):
            whole.append(read_manifest(Path(path), number))
    return whole


def rows_of(segment: Segment) -> Ints:
    """Return the rows that are not removed."""
    return np.arange(len(segment)) if segment.live is None else segment.live


def _manifest(path: Path, base: Snapshot | None) -> Manifest:
    return (open_whole(path) if base is None else base).manifest


def open_whole(path: Path) -> Snapshot:
    """Open the newest version for a change, which a damaged one must not be lost by."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        snapshot = open_store(path)
    if snapshot.damaged:
        raise InputError(
            f"version {snapshot.damaged[0]} is damaged and nothing is changed: go on from version "
            f"{snapshot.manifest.version} with checkout, or without what is damaged with verify --drop-damaged",
            path=path,
        )
    return snapshot


def _place(path: Path, manifest: Manifest) -> None:
    place_new(version_path(path, manifest.version), manifest.encode())


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")

"""Fewer and larger segments, without what was removed; and the deletion of what no kept version names."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa

from graft.errors import InputError
from graft.library.files import discard, sync_folder
from graft.library.manifest import (
    SEGMENTS,
    VERSIONS,
    LibraryChangedError,
    Manifest,
    SegmentEntry,
    read_manifest,
    version_numbers,
    version_path,
)
from graft.library.segment import Segment
from graft.library.store import Snapshot, commit, open_whole, rows_of
from graft.library.tables import PartColumns, write_segment
from graft.objects import Ints

OBJECTS_TOGETHER = 1 << 16
"""Objects in a compacted segment, at most: its columns take some 400 MB of memory while they are written."""

GRACE = 3600.0
"""Seconds for which files that no version names are left alone: they may be those of a change under way."""


def compact(path: str | Path, *, objects: int = OBJECTS_TOGETHER) -> Snapshot:
    """Merge neighbouring segments and leave out removed objects; the order stays.

    The old segments stay for the old versions, until `vacuum`.

    Args:
        path: The library.
        objects: In a segment, at most; larger ones that exist are not cut.

    Raises:
        InputError: A segment is damaged, or the disk is full.
        LibraryChangedError: Another writer removed or merged what was being merged.
    """
    path = Path(path)
    start = open_whole(path)
    groups = [group for group in _groups(start.segments, objects) if len(group) > 1 or group[0].entry.n_removed]
    if not groups:
        return start
    merged = [(group, None if not _live(group) else _merge(path / SEGMENTS, group)) for group in groups]
    sync_folder(path / SEGMENTS)

    def change(current: Snapshot) -> Manifest:
        segments = list(current.manifest.segments)
        for group, entry in merged:
            old = [segment.entry for segment in group]
            place = next((i for i in range(len(segments)) if segments[i : i + len(old)] == old), None)
            if place is None:
                raise LibraryChangedError(f"{path}: another writer changed the library meanwhile, try again")
            segments[place : place + len(old)] = [] if entry is None else [entry]
        return replace(current.manifest, segments=tuple(segments), operation="compact")

    try:
        return commit(path, change, start)
    except LibraryChangedError:
        for _, entry in merged:
            for file in () if entry is None else entry.all_files:
                discard(path / SEGMENTS / file.name)
        raise


def vacuum(path: str | Path, *, keep: int = 1, grace: float = GRACE) -> tuple[int, int]:
    """Delete all but the newest versions, and the files that no version is left to name.

    Args:
        path: The library.
        keep: Versions that stay.
        grace: Seconds; younger files that no version names stay.

    Returns:
        How many files were deleted, and their bytes.

    Raises:
        InputError: The newest version is damaged, or the system refuses.
    """
    path = Path(path)
    if keep < 1:
        raise InputError(f"keep: expected at least 1, got {keep}")
    newest = open_whole(path).manifest.version
    numbers = [number for number in version_numbers(path) if number <= newest]
    kept = [read_manifest(path, number) for number in numbers[-keep:]]
    named = {file.name for manifest in kept for segment in manifest.segments for file in segment.all_files}
    young = time.time() - grace
    loose = [f for f in (path / SEGMENTS).iterdir() if f.name not in named]
    drafts = [f for f in (path / VERSIONS).iterdir() if f.name.startswith(".") and f.name != ".lock"]
    versions = [version_path(path, number) for number in numbers[:-keep]]
    count = size = 0
    # Versions first: one whose segments are gone would be damaged.
    old = _named_by(path, numbers[:-keep]) - named
    for files in (versions, [f for f in (*loose, *drafts) if f.name in old or f.lstat().st_mtime <= young]):
        for file in files:
            if file.is_file():
                size += file.lstat().st_size
                file.unlink(missing_ok=True)
                count += 1
        sync_folder(path / VERSIONS)
    return count, size


def _named_by(path: Path, numbers: Sequence[int]) -> set[str]:
    """Return the files of versions that are deleted; what a damaged one named is not known."""
    names: set[str] = set()
    for number in numbers:
        try:
            manifest = read_manifest(path, number)
        except InputError:
            continue
        names |= {file.name for segment in manifest.segments for file in segment.all_files}
    return names


def _groups(segments: Sequence[Segment], objects: int) -> list[list[Segment]]:
    """Return neighbours whose live objects fit together."""
    groups: list[list[Segment]] = []
    count = 0
    for segment in segments:
        own = segment.entry.objects - segment.entry.n_removed
        if groups and count + own <= objects:
            groups[-1].append(segment)
            count += own
        else:
            groups.append([segment])
            count = own
    return groups


def _live(group: Sequence[Segment]) -> int:
    return sum(segment.entry.objects - segment.entry.n_removed for segment in group)


def _merge(folder: Path, group: Sequence[Segment]) -> SegmentEntry:
    """Write the live rows of segments as one."""
    kept = [(segment, rows_of(segment)) for segment in group]
    kept = [(segment, rows) for segment, rows in kept if len(rows)]
    parts = [_part_rows(segment, rows) for segment, rows in kept]
    columns = [(segment.parts, own) for (segment, _), own in zip(kept, parts, strict=True)]
    described = [c.descriptors[own] for c, own in columns if c.descriptors is not None]
    together = PartColumns(
        np.concatenate([c.extents[own] for c, own in columns]),
        np.concatenate([c.relations[own] for c, own in columns]),
        np.concatenate(described) if described else None,
        np.concatenate([c.masses[own] for c, own in columns]),
        np.concatenate([c.hops[own] for c, own in columns]),
    )
    graphs = pa.concat_batches([segment.graphs.take(pa.array(rows)) for segment, rows in kept])
    objects = (segment.object_batch(row) for segment, rows in kept for row in rows.tolist())
    return write_segment(folder, together, graphs, objects)


def _part_rows(segment: Segment, rows: Ints) -> Ints:
    """Return the parts of objects."""
    mask = np.zeros(segment.entry.parts, np.bool_)
    for first, end in zip(segment.offsets[rows], segment.offsets[rows + 1], strict=True):
        mask[first:end] = True
    return np.flatnonzero(mask)

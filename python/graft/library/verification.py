"""Every byte of a library against its checksum."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from graft.errors import InputError
from graft.library.files import LOCK, FileEntry
from graft.library.manifest import SEGMENTS, VERSION_NAME, VERSIONS, Manifest, read_manifest, version_numbers
from graft.library.segment import Segment
from graft.library.store import Snapshot, is_store, place_next, versions
from graft.library.tables import open_table


@dataclass(frozen=True)
class Report:
    """What was found.

    Attributes:
        versions: Versions that are whole.
        objects: In the newest of them.
        files: Files read, versions included.
        bytes: Their size.
        problems: Damaged or missing files, one line each; nothing is wrong when there are none.
        foreign: Files that no version names: of writers that were stopped, of changes that lost against another
            writer's, or put there by somebody.
    """

    versions: tuple[int, ...]
    objects: int
    files: int
    bytes: int
    problems: tuple[str, ...]
    foreign: tuple[str, ...]


def verify(path: str | Path) -> Report:
    """Read every file of every version and compare it with its checksum.

    Raises:
        InputError: There is no library.
    """
    path = Path(path)
    if not is_store(path):
        raise InputError("expected a library (folders versions and segments), got something else", path=path)
    whole: list[Manifest] = []
    problems: list[str] = []
    size = 0
    for number in version_numbers(path):
        try:
            whole.append(read_manifest(path, number))
            size += len(whole[-1].encode())
        except InputError as error:
            problems.append(str(error))
    if not whole:
        problems.append(f"{path / VERSIONS}: no version of the library is whole")
    known: dict[str, FileEntry] = {}
    for manifest in whole:
        for entry in manifest.segments:
            segment = Segment(path / SEGMENTS, entry, manifest.descriptor, manifest.saliency)
            for message in _check(segment, known):
                problems.append(message)
    size += sum(entry.size for entry in known.values())
    return Report(
        tuple(manifest.version for manifest in whole),
        whole[-1].objects if whole else 0,
        len(whole) + len(known),
        size,
        tuple(problems),
        tuple(sorted(_foreign(path, known))),
    )


def drop_damaged(path: str | Path) -> Snapshot:
    """Commit a version with every whole segment of the newest version whose manifest is whole.

    Nothing is deleted: what was dropped is still in the older versions, for the parts of it that can be read.

    Raises:
        InputError: No manifest is whole.
    """
    path = Path(path)
    manifests = versions(path)
    if not manifests:
        raise InputError("no version of the library is whole", path=path / VERSIONS)
    newest = manifests[-1]
    segments = [Segment(path / SEGMENTS, e, newest.descriptor, newest.saliency) for e in newest.segments]
    whole = [segment.entry for segment in segments if not list(_check(segment, {}))]
    if len(whole) == len(segments) and version_numbers(path)[-1] == newest.version:
        return Snapshot(path, newest)
    lost = newest.objects - sum(entry.objects - entry.n_removed for entry in whole)
    words = f"drop {lost} object{'s' * (lost != 1)} of damaged segments"
    return place_next(path, replace(newest, segments=tuple(whole), operation=words), newest.version)


def _check(segment: Segment, known: dict[str, FileEntry]) -> Iterator[str]:
    """Check the files of a segment that were not checked for another version."""
    for file in segment.entry.all_files:
        path = segment.folder / file.name
        if file.name in known:
            if known[file.name] != file:
                yield f"{path}: two versions disagree about its checksum"
            continue
        known[file.name] = file
        try:
            reader = open_table(segment.folder, file, check=True)
            rows = sum(reader.get_batch(i).num_rows for i in range(reader.num_record_batches))
            graphs = file in (segment.entry.files["graphs"], segment.entry.files["objects"])
            if graphs and rows != segment.entry.objects:
                yield f"{path}: expected {segment.entry.objects} rows, got {rows}"
        except InputError as error:
            yield str(error)


def _foreign(path: Path, known: dict[str, FileEntry]) -> Iterator[str]:
    for file in (path / VERSIONS).iterdir():
        if not VERSION_NAME.match(file.name) and file.name != LOCK:
            yield str(file)
    for file in (path / SEGMENTS).iterdir():
        if file.name not in known:
            yield str(file)

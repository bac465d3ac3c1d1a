"""A library from folders of objects: read, described and written by many workers; a stopped one is gone on with.

A worker takes some folders, writes a segment of what it could read and returns its entry; the segments are committed
in the order of the folders, every few seconds. A worker that is stopped leaves files that no version names.
"""

from __future__ import annotations

import json
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from graft.errors import InputError, printable
from graft.features import Descriptor
from graft.graph import build_graph
from graft.io.atomic import write_whole
from graft.library.encode import Row, graphs_batch, make_row, object_batches, part_columns
from graft.library.executors import Executor, LocalExecutor, Lost
from graft.library.files import sync_folder
from graft.library.library import Library
from graft.library.manifest import SEGMENTS, Manifest, SegmentEntry
from graft.library.segment import Segment
from graft.library.sources import find_sources, read_source
from graft.library.store import Snapshot, commit, is_store, without
from graft.library.tables import write_segment

TOGETHER = 256
"""Folders that a worker takes at a time, at most; at 30k faces their objects take 250 MB."""

SHARES = 8
"""Tasks for each worker, at least, so that none waits long for the last one."""

COMMIT_SECONDS = 5.0
"""Between two versions; what a killed build loses."""

FAILURES = "failures.jsonl"


@dataclass(frozen=True)
class Task:
    """Folders for one worker, and how their objects are written."""

    folders: tuple[Path, ...]
    segments: Path
    descriptor: Descriptor | None
    saliency: float
    samples: bool


@dataclass(frozen=True)
class Done:
    """What a worker made of some folders: a segment of what it could read, and what failed, with reasons."""

    folders: int
    entry: SegmentEntry | None
    relations: int
    failures: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class BuildReport:
    """What a build did.

    Attributes:
        folders: Folders found.
        skipped: Folders whose objects were in the library already.
        added: Objects added.
        duplicates: Objects left out because the same geometry and contact is there: their folder and name.
        failures: Folders that gave nothing, or an object less: folder and reason.
        seconds: Taken.
        version: Of the library now.
    """

    folders: int
    skipped: int
    added: int
    duplicates: tuple[tuple[str, str], ...]
    failures: tuple[tuple[str, str], ...]
    seconds: float
    version: int


Progress = Callable[[int, int, int], None]
"""Called with folders done, folders in all, failures."""


def build(
    folders: Iterable[str | Path],
    out: str | Path,
    *,
    descriptor: Descriptor | None,
    executor: Executor | None = None,
    shard: tuple[int, int] = (1, 1),
    samples: bool = True,
    progress: Progress | None = None,
) -> BuildReport:
    """Add every object under some folders to a library, which is made when there is none.

    Folders whose objects are in it are passed over, so that a stopped build goes on where it was. Failures are
    written into `failures.jsonl` in the library, with a shard's number when there are several.

    Args:
        folders: Searched for demonstrations and labelled objects (`find_sources`).
        out: The library.
        descriptor: Describes parts.
        executor: Where the work is done; one process a core by default.
        shard: (i, n): only every n-th folder from the i-th on; n builds together do all, at the same time or not.
        samples: Of a new library: whether surface samples are stored.
        progress: Is told how far it is.

    Raises:
        InputError: A folder or the library cannot be used.
        LibraryChangedError: Other writers were always faster.
    """
    start = time.monotonic()
    number, of = shard
    if not 1 <= number <= of:
        raise InputError(f"shard: expected i/n with 1 <= i <= n, got {number}/{of}")
    sources = find_sources(folders)[number - 1 :: of]
    library = _library(Path(out), descriptor, samples)
    path, manifest = library.snapshot.path, library.snapshot.manifest
    known = library.snapshot.find([str(source) for source in sources], "source")
    left = [source for source in sources if str(source) not in known]
    executor = LocalExecutor() if executor is None else executor
    size = max(1, min(TOGETHER, len(left) // (SHARES * executor.workers)))
    tasks = [
        Task(tuple(left[i : i + size]), path / SEGMENTS, library.descriptor, manifest.saliency, manifest.samples)
        for i in range(0, len(left), size)
    ]
    record = _Record(path, FAILURES if of == 1 else f"failures-{number}-of-{of}.jsonl")
    done = len(sources) - len(left)
    try:
        for answer in _answers(executor, tasks):
            record.take(answer)
            done += answer.folders
            if progress is not None:
                progress(done, len(sources), len(record.failures))
    finally:
        record.commit()
    return BuildReport(
        len(sources),
        len(sources) - len(left),
        record.added,
        tuple(record.duplicates),
        tuple(record.failures),
        time.monotonic() - start,
        Library.open(path, descriptor=None).snapshot.manifest.version,
    )


def _library(path: Path, descriptor: Descriptor | None, samples: bool) -> Library:
    if is_store(path):
        library = Library.open(path, descriptor=descriptor)
        wanted = library.snapshot.manifest.descriptor
        if descriptor is None and wanted is not None:
            raise InputError(f"descriptors: the library has {wanted}, got none", path=path)
        return library
    return Library.create(path, descriptor=descriptor, samples=samples)


def _answers(executor: Executor, tasks: Sequence[Task]) -> Iterator[Done]:
    """Yield an answer for every task; one that killed its worker is tried folder by folder."""
    for task, answer in zip(tasks, executor.map(work, tasks), strict=True):
        if not isinstance(answer, Lost):
            yield answer
        elif len(task.folders) == 1:
            yield Done(1, None, 0, ((str(task.folders[0]), answer.reason),))
        else:
            yield from _answers(executor, [replace(task, folders=(folder,)) for folder in task.folders])


def work(task: Task) -> Done:
    """Read, describe and write the objects of some folders; runs in a worker."""
    rows: list[Row] = []
    failures = []
    for folder in task.folders:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                several = read_source(folder)
                # Demonstrations of one folder are contacts on one object.
                graph = build_graph(several[0].object, descriptor=task.descriptor)
                rows += [make_row(shown, graph, samples=task.samples, source=str(folder)) for shown in several]
        except InputError as error:
            failures.append((str(folder), str(error)))
        except Exception as error:  # whatever else a file does must not stop the others
            failures.append((str(folder), f"{type(error).__name__}: {printable(str(error))}"))
    if not rows:
        return Done(len(task.folders), None, 0, tuple(failures))
    columns = part_columns(rows, task.saliency)
    entry = write_segment(task.segments, columns, graphs_batch(rows), object_batches(rows))
    return Done(len(task.folders), entry, columns.relations.shape[1], tuple(failures))


class _Record:
    """Commits segments as they come and keeps count."""

    def __init__(self, path: Path, failures: str) -> None:
        self.path = path
        self.file = path / failures
        self.added = 0
        self.duplicates: list[tuple[str, str]] = []
        self.failures: list[tuple[str, str]] = []
        self._waiting: list[SegmentEntry] = []
        self._relations = 0
        self._last = time.monotonic()

    def take(self, done: Done) -> None:
        """Take a worker's answer."""
        self.failures += done.failures
        if done.entry is not None:
            self._waiting.append(done.entry)
            self._relations = done.relations
        if time.monotonic() - self._last > COMMIT_SECONDS:
            self.commit()

    def commit(self) -> None:
        """Commit what came since the last time, without duplicates, and write the failures."""
        if self._waiting:
            waiting, self._waiting = self._waiting, []
            sync_folder(self.path / SEGMENTS)
            twice: list[tuple[str, str]] = []
            clashes: list[tuple[str, str]] = []

            def change(current: Snapshot) -> Manifest:
                twice.clear()
                clashes.clear()
                entries = _unique(current, waiting, twice, clashes)
                added = sum(entry.objects - entry.n_removed for entry in entries)
                manifest = current.manifest
                if manifest.relations not in (0, self._relations):
                    raise InputError(f"relations: expected {manifest.relations} a part, got {self._relations}")
                segments = (*manifest.segments, *entries)
                return replace(manifest, segments=segments, relations=self._relations, operation=f"add {added}")

            before = commit(self.path, change)
            self.added += sum(e.objects - e.n_removed for e in before.manifest.segments if e.id in _ids(waiting))
            self.duplicates += twice
            self.failures += clashes
        lines = [json.dumps({"folder": folder, "reason": reason}) + "\n" for folder, reason in self.failures]
        if lines or self.file.exists():
            write_whole(self.file, "".join(lines).encode())
        self._last = time.monotonic()


def _ids(entries: Sequence[SegmentEntry]) -> set[str]:
    return {entry.id for entry in entries}


def _unique(
    current: Snapshot,
    entries: Sequence[SegmentEntry],
    twice: list[tuple[str, str]],
    clashes: list[tuple[str, str]],
) -> list[SegmentEntry]:
    """Return the entries without the objects whose content or name is in the library already."""
    manifest = current.manifest
    segments = [Segment(current.path / SEGMENTS, e, manifest.descriptor, manifest.saliency) for e in entries]
    columns = [[s.graphs[key].to_pylist() for key in ("id", "name", "source")] for s in segments]
    ids = set(current.find([i for own in columns for i in own[0]], "id"))
    names = set(current.find([n for own in columns for n in own[1]]))
    kept = []
    for segment, (own_ids, own_names, own_sources) in zip(segments, columns, strict=True):
        gone = []
        for row, (id_, name, source) in enumerate(zip(own_ids, own_names, own_sources, strict=True)):
            if id_ in ids:
                twice.append((source, name))
            elif name in names:
                clashes.append((source, f"the library has a demonstration called {name!r} already"))
            else:
                ids.add(id_)
                names.add(name)
                continue
            gone.append(row)
        if len(gone) < len(segment):
            kept.append(without(segment, gone) if gone else segment.entry)
    return kept

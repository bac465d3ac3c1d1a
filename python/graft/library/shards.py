"""A query answered by many workers, each of which maps some segments of the library."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from graft.errors import GraftError
from graft.library.executors import Executor, Lost
from graft.library.filters import Filter
from graft.library.search import Found, Query, best, merged
from graft.library.shelves import DiskShelf
from graft.library.store import Snapshot, open_store
from graft.transport import UFGW

OPEN = 4
"""Versions that a worker keeps mapped, with their checksums compared, from one query to the next."""


@dataclass(frozen=True)
class SearchTask:
    """A query to the segments from `first` to before `end` of a version."""

    path: Path
    version: int
    first: int
    end: int
    query: Query
    k: int
    bar: float
    solver: UFGW
    only: Filter | None


def search_shard(task: SearchTask) -> Found:
    """Answer from some segments; runs in a worker."""
    shelf = _shelf(task.path, task.version)
    chosen = range(task.first, task.end)
    return best(shelf.blocks(task.solver, task.only, None, chosen), task.query, task.k, bar=task.bar)


@lru_cache(OPEN)
def _shelf(path: Path, version: int) -> DiskShelf:
    return DiskShelf(open_store(path, version))


def search(
    executor: Executor, snapshot: Snapshot, query: Query, k: int, *, bar: float, solver: UFGW, only: Filter | None
) -> Found:
    """Return the best k of a version: what searching it here would give, to the last bit.

    Raises:
        InputError: As `best`, or a segment is damaged.
        GraftError: Workers died again and again.
    """
    version = snapshot.manifest.version
    tasks = [
        SearchTask(snapshot.path.resolve(), version, first, end, query, k, bar, solver, only)
        for first, end in shards(snapshot, executor.workers)
    ]
    answers = list(executor.map(search_shard, tasks))
    for task, answer in zip(tasks, answers, strict=True):
        if isinstance(answer, Lost):
            raise GraftError(f"search: segments {task.first} to {task.end - 1} of {task.path}: {answer.reason}")
    return merged([answer for answer in answers if not isinstance(answer, Lost)], k)


def shards(snapshot: Snapshot, count: int) -> list[tuple[int, int]]:
    """Return at most `count` ranges of segments that have about as many objects each."""
    ends = snapshot.starts[1:]
    if not len(ends):
        return []
    wanted = ends[-1] * np.arange(1, count + 1) / count
    cuts = [0, *np.unique(np.minimum(np.searchsorted(ends, wanted) + 1, len(ends))).tolist()]
    return list(itertools.pairwise(cuts))

"""What is in a library on disk, from its columns alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import pyarrow as pa

from graft.library.filters import Filter
from graft.library.shelves import DiskShelf
from graft.library.store import Snapshot

COLUMNS = ("id", "name", "category", "licence", "tags", "gripper_width", "source")


@dataclass(frozen=True)
class Listed:
    """One object.

    Attributes:
        id: Hash of its content, hex.
        name: Unique in the library.
        category: Or None.
        licence: Or None.
        tags: Of its metadata.
        gripper_width: Metres, or None.
        source: The folder it was built from, or "".
        parts: How many it has.
        part: Index of the demonstrated one.
    """

    id: str
    name: str
    category: str | None
    licence: str | None
    tags: tuple[str, ...]
    gripper_width: float | None
    source: str
    parts: int
    part: int


def listing(snapshot: Snapshot, only: Filter | None = None, limit: int | None = None) -> Iterator[Listed]:
    """Yield the objects of a version that a filter accepts, in order, at most `limit`.

    Raises:
        InputError: A segment is damaged.
    """
    left = len(DiskShelf(snapshot)) if limit is None else limit
    for segment, rows in DiskShelf(snapshot).rows(only):
        some = rows[:left]
        left -= len(some)
        table = segment.graphs.take(pa.array(some))
        columns = [table[name].to_pylist() for name in COLUMNS]
        sizes = (segment.offsets[some + 1] - segment.offsets[some]).tolist()
        for (id_, name, category, licence, tags, width, source), size, part in zip(
            zip(*columns, strict=True), sizes, table["part"].to_pylist(), strict=True
        ):
            yield Listed(id_.hex(), name, category, licence, tuple(tags), width, source, size, part)
        if not left:
            return

"""Where a library's objects are: in memory, or in a version on disk. Both answer the same questions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from graft.errors import InputError
from graft.graph import PartGraph
from graft.library.filters import Filter
from graft.library.search import Block
from graft.library.segment import Segment
from graft.library.store import Snapshot, rows_of
from graft.objects import Demonstration, Ints
from graft.transport import UFGW, PackedGraphs


class Shelf(Protocol):
    """Objects by position; positions rise in the order of the library and may leave numbers out."""

    def __len__(self) -> int: ...

    def positions(self, only: Filter | None) -> Ints:
        """Return the positions of the objects that a filter accepts."""
        ...

    def blocks(self, solver: UFGW, only: Filter | None, among: Ints | None) -> Iterator[Block]:
        """Return what is ranked: everything, what a filter accepts, or given positions."""
        ...

    def read(self, position: int) -> tuple[Demonstration, PartGraph]:
        """Return an object and its part graph."""
        ...

    def find(self, names: Sequence[str]) -> dict[str, int]:
        """Return the positions of those of the names that are there."""
        ...

    def demonstrations(self) -> Iterator[Demonstration]:
        """Return all objects in order."""
        ...


@dataclass(eq=False)
class MemoryShelf:
    """Objects in memory."""

    shown: list[Demonstration] = field(default_factory=list)
    graphs: list[PartGraph] = field(default_factory=list)
    names: set[str] = field(default_factory=set)
    _packed: tuple[UFGW, PackedGraphs] | None = None

    def __len__(self) -> int:
        return len(self.shown)

    def append(self, shown: Sequence[Demonstration], graphs: Sequence[PartGraph]) -> None:
        """Add objects and their graphs: all, or none when a name is taken."""
        names: set[str] = set()
        for demonstration in shown:
            if demonstration.name in self.names or demonstration.name in names:
                raise InputError(f"library: it has a demonstration called {demonstration.name!r} already")
            names.add(demonstration.name)
        self.shown += shown
        self.graphs += graphs
        self.names |= names
        self._packed = None

    def remove(self, names: Sequence[str]) -> None:
        """Take objects out: all, or none when one is not there."""
        missing = [name for name in names if name not in self.names]
        if missing:
            raise InputError(f"library: it has no demonstration called {missing[0]!r}")
        kept = [i for i, d in enumerate(self.shown) if d.name not in set(names)]
        self.shown, self.graphs = [self.shown[i] for i in kept], [self.graphs[i] for i in kept]
        self.names -= set(names)
        self._packed = None

    def positions(self, only: Filter | None) -> Ints:
        """Return the positions that a filter accepts."""
        return np.array([i for i, d in enumerate(self.shown) if only is None or only.accepts(d)], np.int64)

    def blocks(self, solver: UFGW, only: Filter | None, among: Ints | None) -> Iterator[Block]:
        """Pack the graphs, once, and return them."""
        if self._packed is None or self._packed[0] != solver:
            parts = [demonstration.contact.part for demonstration in self.shown]
            self._packed = (solver, PackedGraphs.pack(self.graphs, parts, solver))
        chosen = self.positions(only) if among is None and only is not None else among
        yield Block(self._packed[1], 0, chosen)

    def read(self, position: int) -> tuple[Demonstration, PartGraph]:
        """Return an object and its graph."""
        return self.shown[position], self.graphs[position]

    def find(self, names: Sequence[str]) -> dict[str, int]:
        """Return the positions of names."""
        wanted = set(names)
        return {d.name: i for i, d in enumerate(self.shown) if d.name in wanted}

    def demonstrations(self) -> Iterator[Demonstration]:
        """Return all objects."""
        return iter(self.shown)


@dataclass(eq=False)
class DiskShelf:
    """Objects of a version on disk; a change replaces the version."""

    snapshot: Snapshot

    def __len__(self) -> int:
        return self.snapshot.manifest.objects

    def rows(self, only: Filter | None, numbers: range | None = None) -> Iterator[tuple[Segment, Ints]]:
        """Return the rows of every segment, or of some, that a filter accepts."""
        segments = self.snapshot.segments
        for segment in segments if numbers is None else segments[numbers.start : numbers.stop]:
            rows = rows_of(segment)
            yield segment, rows if only is None else np.intersect1d(rows, only.rows(segment.graphs), assume_unique=True)

    def positions(self, only: Filter | None) -> Ints:
        """Return the positions that a filter accepts."""
        chosen = [rows + first for first, (_, rows) in zip(self.snapshot.starts, self.rows(only), strict=False)]
        return np.concatenate(chosen) if chosen else np.empty(0, np.int64)

    def blocks(
        self, solver: UFGW, only: Filter | None, among: Ints | None, numbers: range | None = None
    ) -> Iterator[Block]:
        """Return the segments, or some, as they are mapped."""
        for number, (segment, rows) in enumerate(self.rows(only, numbers), 0 if numbers is None else numbers.start):
            first, end = self.snapshot.starts[number : number + 2]
            chosen: Ints | None = rows
            if among is not None:
                chosen = among[np.searchsorted(among, first) : np.searchsorted(among, end)] - first
            elif len(rows) == len(segment):
                chosen = None
            if chosen is None or len(chosen):
                yield Block(segment.packed(solver), int(first), chosen)

    def read(self, position: int) -> tuple[Demonstration, PartGraph]:
        """Read an object and its graph."""
        number = int(np.searchsorted(self.snapshot.starts, position, side="right")) - 1
        return self.snapshot.segments[number].read(position - int(self.snapshot.starts[number]))

    def find(self, names: Sequence[str]) -> dict[str, int]:
        """Return the positions of names."""
        places = self.snapshot.find(names)
        return {name: int(self.snapshot.starts[number]) + row for name, (number, row) in places.items()}

    def demonstrations(self) -> Iterator[Demonstration]:
        """Read all objects, one by one."""
        for segment in self.snapshot.segments:
            for row in range(len(segment)) if segment.live is None else segment.live.tolist():
                yield segment.demonstration(row)

"""Demonstrated objects in memory, and the retrieval of those whose contact suits a target.

Every demonstration is matched against the target by unbalanced fused Gromov-Wasserstein transport in one batch;
the matches come back in the order of their cost. Ties keep the order of the library.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from graft.errors import InputError
from graft.features import Descriptor, GeometricDescriptor
from graft.graph import PartGraph, build_graph
from graft.io import ObjectLike, as_object, load_demonstrations, save_demonstration
from graft.objects import Demonstration
from graft.transport import UFGW, PackedGraphs, Transport

PRUNED = 256
"""Libraries of at least so many demonstrations are ranked by bounds first; below that solving all of them takes a
millisecond."""


@dataclass(frozen=True, eq=False)
class Match:
    """One demonstration matched against a target.

    Attributes:
        demonstration: The source object and the contact shown on it.
        source: Its part graph, n parts.
        target: The target's part graph, m parts.
        transport: The plan (n, m) and everything the solver knows about it.
        cost: What matches are ranked by, lower is better (`Transport.cost`).
        rank: 0 for the best match of its retrieval.
    """

    demonstration: Demonstration
    source: PartGraph
    target: PartGraph
    transport: Transport
    cost: float
    rank: int = 0

    @property
    def source_part(self) -> int:
        """Index of the demonstrated part of the source."""
        return self.demonstration.contact.part


class Library:
    """Demonstrations ready to be matched: their part graphs are built once, when they are added.

    Args:
        solver: Parameters of the matching; the defaults are DESIGN's.
        descriptor: Describes parts, of sources and targets alike; None matches by boxes and structure alone.
    """

    def __init__(self, *, solver: UFGW | None = None, descriptor: Descriptor | None = GeometricDescriptor()) -> None:
        self.solver = UFGW() if solver is None else solver
        self.descriptor = descriptor
        self._demonstrations: list[Demonstration] = []
        self._graphs: list[PartGraph] = []
        self._names: set[str] = set()
        self._packed: PackedGraphs | None = None

    @classmethod
    def open(
        cls,
        folder: str | Path,
        *,
        solver: UFGW | None = None,
        descriptor: Descriptor | None = GeometricDescriptor(),
    ) -> Library:
        """Read every demonstration under `folder`, in the order of their folders' names.

        Raises:
            InputError: No demonstration there, or one of them cannot be read; the message names it.
        """
        library = cls(solver=solver, descriptor=descriptor)
        library.extend(load_demonstrations(folder))
        if not len(library):
            raise InputError("no demonstration found: expected folders with a demonstration.json", path=folder)
        return library

    def save(self, folder: str | Path) -> None:
        """Write every demonstration as a folder of its own (object.glb, demonstration.json) under `folder`.

        Raises:
            InputError: A name cannot be that of a folder (nothing is written then), or the system refuses.
        """
        for name in self._names:
            if name in ("", ".", "..") or not name.isprintable() or set(name) & set("/\\"):
                raise InputError(f"demonstration {name!r}: expected a name that can be a folder's", path=folder)
        for demonstration in self._demonstrations:
            save_demonstration(Path(folder) / demonstration.name, demonstration)

    def add(self, demonstration: Demonstration) -> None:
        """Add one demonstration.

        Raises:
            InputError: The library has one of that name already.
        """
        if demonstration.name in self._names:
            raise InputError(f"library: it has a demonstration called {demonstration.name!r} already")
        self._graphs.append(build_graph(demonstration.object, descriptor=self.descriptor))
        self._demonstrations.append(demonstration)
        self._names.add(demonstration.name)
        self._packed = None

    def extend(self, demonstrations: Iterable[Demonstration]) -> None:
        """Add several demonstrations, in order."""
        for demonstration in demonstrations:
            self.add(demonstration)

    def __len__(self) -> int:
        return len(self._demonstrations)

    def __iter__(self) -> Iterator[Demonstration]:
        return iter(self._demonstrations)

    def retrieve(
        self,
        target: ObjectLike | PartGraph,
        k: int = 5,
        *,
        where: Callable[[Demonstration], bool] | None = None,
    ) -> list[Match]:
        """Return the k best matches for `target`, best first.

        Args:
            target: An object, anything `graft.as_object` takes, or its part graph (built with this
                library's descriptor).
            k: How many; fewer come back when the library has fewer.
            where: Only demonstrations for which it is true are matched.

        Raises:
            InputError: k is not positive, or the library is empty.
        """
        if k < 1:
            raise InputError(f"k: expected at least 1, got {k}")
        if not self._demonstrations:
            raise InputError("library: it is empty, add a demonstration first")
        graph = target if isinstance(target, PartGraph) else self.graph(target)
        chosen = [i for i, d in enumerate(self._demonstrations) if where is None or where(d)]
        if not chosen:
            return []
        if len(chosen) >= PRUNED and len(chosen) == len(self) and self.solver.cost == "sharp":
            # Bounds rule most of a large library out; what is left is solved again below, for its plans.
            if self._packed is None:
                parts = [demonstration.contact.part for demonstration in self._demonstrations]
                self._packed = PackedGraphs.pack(self._graphs, parts, self.solver)
            chosen = sorted(self._packed.rank(graph, k).indices.tolist())
        transports = self.solver.batch(
            [self._graphs[i] for i in chosen], [self._demonstrations[i].contact.part for i in chosen], graph
        )
        # A stable sort keeps the library's order among equal costs.
        order = np.argsort([t.cost for t in transports], kind="stable")[:k]
        return [
            Match(
                demonstration=self._demonstrations[chosen[i]],
                source=self._graphs[chosen[i]],
                target=graph,
                transport=transports[i],
                cost=transports[i].cost,
                rank=rank,
            )
            for rank, i in enumerate(order)
        ]

    def graph(self, target: ObjectLike) -> PartGraph:
        """Build a target's part graph with this library's descriptor."""
        return build_graph(as_object(target), descriptor=self.descriptor)


def match(
    demonstration: Demonstration,
    target: ObjectLike | PartGraph,
    *,
    solver: UFGW | None = None,
    descriptor: Descriptor | None = GeometricDescriptor(),
) -> Match:
    """Match one demonstration against a target."""
    library = Library(solver=solver, descriptor=descriptor)
    library.add(demonstration)
    return library.retrieve(target, k=1)[0]

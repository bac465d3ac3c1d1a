"""Demonstrated objects in memory or on disk, and the retrieval of those whose contact suits a target.

Demonstrations are matched against the target by unbalanced fused Gromov-Wasserstein transport; the matches come back
in the order of their cost. Ties keep the order of the library.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from graft.errors import InputError
from graft.features import Descriptor, GeometricDescriptor
from graft.graph import PartGraph, build_graph
from graft.io import ObjectLike, as_object, load_demonstrations, save_demonstration
from graft.library.adding import add_graphs
from graft.library.executors import Executor
from graft.library.explain import Explanation, explanation
from graft.library.filters import Filter
from graft.library.matching import Match, best_matches
from graft.library.search import Query, best
from graft.library.shards import search
from graft.library.shelves import DiskShelf, MemoryShelf, Shelf
from graft.library.store import Snapshot, create_store, is_store, open_store, remove
from graft.objects import Demonstration, Ints
from graft.transport import UFGW

PRUNED = 256
"""Libraries in memory of at least so many demonstrations are ranked by bounds first; below that solving all of them
takes a millisecond."""


class Library:
    """Demonstrations ready to be matched: their part graphs are built once, when they are added.

    `Library()` lives in memory; `Library.create` and `Library.open` give one on disk, whose changes are committed
    before the call that makes them returns.

    Args:
        solver: Parameters of the matching; the defaults are DESIGN's.
        descriptor: Describes parts, of sources and targets alike; None matches by boxes and structure alone.
    """

    def __init__(self, *, solver: UFGW | None = None, descriptor: Descriptor | None = GeometricDescriptor()) -> None:
        self.solver = UFGW() if solver is None else solver
        self.descriptor = descriptor
        self.executor: Executor | None = None
        self._shelf: MemoryShelf | DiskShelf = MemoryShelf()

    @classmethod
    def create(
        cls,
        path: str | Path,
        *,
        solver: UFGW | None = None,
        descriptor: Descriptor | None = GeometricDescriptor(),
        samples: bool = True,
    ) -> Library:
        """Make an empty library on disk.

        Args:
            path: A folder, new or empty.
            solver: Parameters of the matching.
            descriptor: Describes parts; the library keeps its name and takes no other.
            samples: Store surface samples, 49 kB a part; without them reading a match makes them again, which takes
                some 15 ms.

        Raises:
            InputError: The folder holds files, or the system refuses.
        """
        library = cls(solver=solver, descriptor=descriptor)
        name, dim = (None, 0) if descriptor is None else (descriptor.name, descriptor.dim)
        library._shelf = DiskShelf(create_store(Path(path), descriptor=name, dim=dim, samples=samples))
        return library

    @classmethod
    def open(
        cls,
        path: str | Path,
        *,
        version: int | None = None,
        solver: UFGW | None = None,
        descriptor: Descriptor | None = GeometricDescriptor(),
        executor: Executor | None = None,
    ) -> Library:
        """Open a library on disk, or read the demonstrations in a folder, in the order of their folders' names.

        Args:
            path: A library, or a folder of folders with a demonstration.json, which are read into memory.
            version: Of a library on disk; the newest by default.
            solver: Parameters of the matching.
            descriptor: Describes targets and what is added; None matches by boxes and structure alone.
            executor: Where a library on disk is searched, a shard of its segments per worker, with the same answers;
                in this process by default. Its workers must see the path.

        Warns:
            InputWarning: The newest version is damaged, an older one was taken.

        Raises:
            InputError: No demonstration there, or one of them cannot be read; no version of the library is whole; or
                its parts are described by another descriptor. The message names the culprit.
        """
        library = cls(solver=solver, descriptor=descriptor)
        if is_store(path):
            library._shelf = DiskShelf(open_store(Path(path), version))
            library.executor = executor
            library._check_descriptor(library._shelf.snapshot)
            return library
        if version is not None:
            raise InputError("version: only libraries on disk have versions, this is a folder", path=path)
        library.extend(load_demonstrations(path))
        if not len(library):
            raise InputError("no demonstration found: expected folders with a demonstration.json", path=path)
        return library

    def _check_descriptor(self, snapshot: Snapshot) -> None:
        """Compare descriptors; a library without any asks for none of its targets."""
        manifest = snapshot.manifest
        if manifest.descriptor is None:
            self.descriptor = None
        elif self.descriptor is not None:
            theirs = f"{manifest.descriptor} ({manifest.dim}-d)"
            ours = f"{self.descriptor.name} ({self.descriptor.dim}-d)"
            if theirs != ours:
                raise InputError(f"descriptors: the library has {theirs}, got {ours}", path=snapshot.path)

    @property
    def path(self) -> Path | None:
        """Where it is on disk; None in memory."""
        return self._shelf.snapshot.path if isinstance(self._shelf, DiskShelf) else None

    @property
    def version(self) -> int | None:
        """The version that answers; None in memory."""
        return self._shelf.snapshot.manifest.version if isinstance(self._shelf, DiskShelf) else None

    @property
    def snapshot(self) -> Snapshot:
        """The version on disk that answers.

        Raises:
            InputError: The library is in memory.
        """
        if isinstance(self._shelf, DiskShelf):
            return self._shelf.snapshot
        raise InputError("library: it is in memory; Library.create makes one on disk")

    def save(self, folder: str | Path) -> None:
        """Write every demonstration as a folder of its own (object.glb, demonstration.json) under `folder`.

        Raises:
            InputError: A name cannot be that of a folder (nothing is written then), or the system refuses.
        """
        for demonstration in self:
            name = demonstration.name
            if name in ("", ".", "..") or not name.isprintable() or set(name) & set("/\\"):
                raise InputError(f"demonstration {name!r}: expected a name that can be a folder's", path=folder)
        for demonstration in self:
            save_demonstration(Path(folder) / demonstration.name, demonstration)

    def add(self, demonstration: Demonstration) -> None:
        """Add one demonstration.

        Raises:
            InputError: The library has one of that name already.
        """
        self.extend([demonstration])

    def extend(self, demonstrations: Iterable[Demonstration]) -> None:
        """Add several demonstrations, in order: all of them, in one version, or none.

        Raises:
            InputError: A name is taken, or the disk is full.
        """
        shown = list(demonstrations)
        self.extend_graphs(shown, [build_graph(d.object, descriptor=self._describing()) for d in shown])

    def extend_graphs(self, demonstrations: Sequence[Demonstration], graphs: Sequence[PartGraph]) -> None:
        """Add demonstrations whose part graphs, with this library's descriptor, are built already.

        Raises:
            InputError: As `extend`, or a graph's descriptors are of another kind.
        """
        shelf = self._shelf
        if isinstance(shelf, MemoryShelf):
            shelf.append(demonstrations, graphs)
            return
        if not demonstrations:
            return
        shelf.snapshot = add_graphs(shelf.snapshot, demonstrations, graphs)

    def remove(self, names: Iterable[str]) -> None:
        """Take demonstrations out, by their names: all of them, in one version, or none.

        Raises:
            InputError: The library has none of such a name.
        """
        if isinstance(self._shelf, MemoryShelf):
            self._shelf.remove(list(names))
        else:
            self._shelf.snapshot = remove(self._shelf.snapshot.path, names, self._shelf.snapshot)

    def _describing(self) -> Descriptor | None:
        if isinstance(self._shelf, DiskShelf) and self.descriptor is None:
            wanted = self._shelf.snapshot.manifest.descriptor
            if wanted is not None:
                raise InputError(f"descriptors: the library has {wanted}, it was opened without any")
        return self.descriptor

    def __len__(self) -> int:
        return len(self._shelf)

    def __iter__(self) -> Iterator[Demonstration]:
        return self._shelf.demonstrations()

    def get(self, names: Sequence[str]) -> list[Demonstration]:
        """Return the demonstrations of these names, in the order of the names.

        Raises:
            InputError: The library has none of such a name, or its bytes are damaged.
        """
        places = self._shelf.find(names)
        missing = [name for name in names if name not in places]
        if missing:
            raise InputError(f"library: it has no demonstration called {missing[0]!r}")
        return [self._shelf.read(places[name])[0] for name in names]

    def retrieve(
        self,
        target: ObjectLike | PartGraph,
        k: int = 5,
        *,
        where: Callable[[Demonstration], bool] | None = None,
        only: Filter | None = None,
        max_cost: float = np.inf,
    ) -> list[Match]:
        """Return the k best matches for `target`, best first.

        Args:
            target: An object, anything `graft.as_object` takes, or its part graph (built with this
                library's descriptor).
            k: How many; fewer come back when the library has fewer.
            where: Only demonstrations for which it is true are matched; on disk this reads every one.
            only: Only demonstrations that fulfil it are matched; on disk this reads columns.
            max_cost: Matches that cost more are left out.

        Raises:
            InputError: k is not positive, the library is empty, or a file of it is damaged.
        """
        if k < 1:
            raise InputError(f"k: expected at least 1, got {k}")
        if not len(self):
            raise InputError("library: it is empty, add a demonstration first")
        graph = target if isinstance(target, PartGraph) else self.graph(target)
        shelf, among = self._shelf, None
        if where is not None:
            chosen = shelf.positions(only)
            among = np.array([i for i in chosen.tolist() if where(shelf.read(i)[0])], np.int64)
        positions = self._candidates(graph, k, only, among, max_cost)
        return [m for m in best_matches(shelf, self.solver, graph, positions, k) if m.cost <= max_cost]

    def _candidates(
        self, graph: PartGraph, k: int, only: Filter | None, among: Ints | None, max_cost: float
    ) -> list[int]:
        """Return the positions of the best k, or of everything that has to be solved, rising."""
        shelf: Shelf = self._shelf
        small = isinstance(shelf, MemoryShelf) and len(shelf) < PRUNED
        if small or self.solver.cost != "sharp":
            chosen = shelf.positions(only) if among is None else among
            return [int(i) for i in chosen]
        # Bounds rule most of a large library out; what is left is solved again, for its plans.
        query = Query.of(graph)
        if self.executor is not None and isinstance(shelf, DiskShelf) and among is None:
            snapshot = shelf.snapshot
            found = search(self.executor, snapshot, query, k, bar=max_cost, solver=self.solver, only=only)
        else:
            found = best(shelf.blocks(self.solver, only, among), query, k, bar=max_cost)
        return sorted(position for _, position in found)

    def retrieve_batch(
        self,
        targets: Sequence[ObjectLike | PartGraph],
        k: int = 5,
        *,
        only: Filter | None = None,
        max_cost: float = np.inf,
    ) -> list[list[Match]]:
        """Return the k best matches of each target, in order, as `retrieve` does."""
        return [self.retrieve(target, k, only=only, max_cost=max_cost) for target in targets]

    def explain(self, target: ObjectLike | PartGraph, *, only: Filter | None = None) -> Explanation:
        """Say why the best match for `target` is the best: terms of its cost, matched parts, the runner-up's lacks.

        Raises:
            InputError: The library is empty, or nothing in it fulfils `only`.
        """
        matches = self.retrieve(target, 2, only=only)
        if not matches:
            raise InputError("library: it has no demonstration that fulfils the conditions")
        return explanation(matches)

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

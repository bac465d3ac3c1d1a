"""Ranking a packed library: build time, bytes a graph, query latency with and without pruning, share pruned.

    python benches/retrieval.py [--graphs 1000000] [--dims 64 384] [--save benches/results/DATE-retrieval.txt]

Synthetic graphs of 2 to 20 parts, median 4, in families: a graph's descriptors and boxes are those of one of 1000
random prototypes with noise, as objects of a category resemble each other. Targets are further members.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import numpy as np

from graft.objects import Floats
from graft.transport import UFGW, PackedGraphs

FAMILIES = 1000
TARGETS = 20
UNPRUNED = 100_000
"""Solving all graphs is timed on a library of at most so many."""
RELATIONS = 1
"""Relations carry no information here, but are there."""
K = 10


def make_sizes(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return part counts: 2 plus a geometric number, median 4, at most 20."""
    return np.minimum(2 + rng.geometric(0.3, count) - 1, 20)


def make_library(graphs: int, dim: int, solver: UFGW, seed: int = 0) -> PackedGraphs:
    """Return a random library."""
    rng = np.random.default_rng(seed)
    sizes = make_sizes(rng, graphs)
    offsets = np.concatenate(([0], np.cumsum(sizes)))
    total = int(offsets[-1])
    family = rng.integers(FAMILIES, size=graphs)
    slot = np.arange(total) - np.repeat(offsets[:-1], sizes)
    extents, descriptors = members(rng, np.repeat(family, sizes), slot, dim)
    masses = rng.random(total) + 0.05
    masses /= np.repeat(np.add.reduceat(masses, offsets[:-1]), sizes)
    structures = [lengths(rng, size, np.flatnonzero(sizes == size)) for size in range(2, 21)]
    flat = np.empty(int((sizes**2).sum()))
    starts = np.concatenate(([0], np.cumsum(sizes**2)[:-1]))
    for size, (which, table) in enumerate(structures, start=2):
        flat[(starts[which][:, None] + np.arange(size**2)).ravel()] = table.ravel()
    parts = (rng.random(graphs) * sizes).astype(np.int64)
    relations = np.ones((total, RELATIONS)) / np.sqrt(RELATIONS)
    return PackedGraphs(offsets.astype(np.int64), parts, extents, relations, descriptors, flat, masses, solver)


def members(rng: np.random.Generator, family: np.ndarray, slot: np.ndarray, dim: int) -> tuple[Floats, Floats]:
    """Return half extents and descriptors of parts in the given slots of the given families."""
    prototypes = np.random.default_rng(1)
    boxes = prototypes.random((FAMILIES, 20, 3)) / 2
    looks = prototypes.normal(size=(FAMILIES, 20, dim))
    extents = np.abs(boxes[family, slot] + 0.05 * rng.normal(size=(len(slot), 3)))
    descriptors = looks[family, slot]
    descriptors += 0.5 * rng.standard_normal(size=(len(slot), dim))
    return extents, descriptors


def lengths(rng: np.random.Generator, size: int, which: np.ndarray) -> tuple[np.ndarray, Floats]:
    """Return edge lengths (len(which), size, size) of random points."""
    points = rng.random((len(which), size, 3))
    x = np.linalg.norm(points[:, :, None] - points[:, None], axis=-1)
    return which, x / (1 + x)


def measure(graphs: int, dim: int) -> str:
    """Return one line of the table."""
    solver = UFGW()
    start = time.perf_counter()
    library = make_library(graphs, dim, solver)
    made = time.perf_counter() - start
    parts = len(library.masses)
    hot = sum(x.nbytes for x in library.hot)
    start = time.perf_counter()
    again = PackedGraphs(
        library.offsets, library.parts, library.extents, library.relations, library.descriptors,
        library.structures, library.masses, solver,
    )  # fmt: skip
    build = time.perf_counter() - start
    del again
    rng = np.random.default_rng(2)
    times, solved, whole = [], [], float("nan")
    for query in range(TARGETS):
        m = int(make_sizes(rng, 1)[0])
        family = np.full(m, rng.integers(FAMILIES))
        extents, descriptors = members(rng, family, np.arange(m), dim)
        structure = lengths(rng, m, np.arange(1))[1][0]
        prior = rng.random(m) + 0.05
        target = (extents, np.ones((m, RELATIONS)) / np.sqrt(RELATIONS), descriptors, structure, prior / prior.sum())
        start = time.perf_counter()
        found = library.rank_arrays(*target, K)
        times.append(time.perf_counter() - start)
        solved.append(found.solved / graphs)
        if query == 0 and graphs <= UNPRUNED:
            start = time.perf_counter()
            every = library.rank_arrays(*target, K, prune=False)
            whole = time.perf_counter() - start
            if not np.array_equal(every.indices, found.indices):
                raise SystemExit("pruning changed the answer")
    p50, p95 = np.percentile(times, [50, 95])
    return (
        f"{graphs:9d} {dim:5d} {made:9.1f} {build:9.2f} {hot / parts:9.0f} {hot / graphs:9.0f} "
        f"{1e3 * p50:9.1f} {1e3 * p95:9.1f} {1e3 * whole:10.1f} {100 * (1 - np.median(solved)):9.3f}"
    )


def main() -> None:
    """Measure, print, save."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--graphs", type=int, nargs="+", default=[10_000, 100_000])
    parser.add_argument("--dims", type=int, nargs="+", default=[64])
    parser.add_argument("--save", type=Path)
    arguments = parser.parse_args()
    lines = [
        f"top {K} of {TARGETS} targets, exact; {os.cpu_count()} cores; hot = bytes that bounds read",
        f"{'graphs':>9} {'dim':>5} {'made s':>9} {'pack s':>9} {'hot/part':>9} {'hot/graph':>9} "
        f"{'p50 ms':>9} {'p95 ms':>9} {'all ms':>10} {'pruned %':>9}",
    ]
    print("\n".join(lines), flush=True)
    for dim in arguments.dims:
        for graphs in arguments.graphs:
            lines.append(measure(graphs, dim))
            print(lines[-1], flush=True)
    if arguments.save:
        arguments.save.parent.mkdir(parents=True, exist_ok=True)
        arguments.save.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()

"""What 10^7 to 10^9 objects would take: a simulation from measured figures.

    python benches/scale.py [--query-ms 105 180] [--ray] [--save benches/results/DATE-scale.txt]

Measured here: opening a version per segment, the bytes of its manifest, the bytes of a query and of its answer, and
(--ray) a task's way to a worker of a local cluster and back. Taken from `benches/library.py`: the median and the 95th
percentile of an exact query to 10^6 objects in memory on one machine, and bytes a part. A query's time on a shard is
drawn from the log-normal law of these two, in proportion to the shard; the slowest shard decides.
"""

from __future__ import annotations

import argparse
import pickle
import tempfile
import time
from pathlib import Path

import numpy as np

from graft.library import Library, RayExecutor
from graft.library.encode import graphs_batch, make_row, object_batches, part_columns
from graft.library.manifest import SEGMENTS
from graft.library.search import Found
from graft.library.store import append, open_store
from graft.library.tables import write_segment
from synthetic import SEGMENT, Prototypes, Random, random_query, real_rows

PARTS = 4.33
"""Parts an object, as in the synthetic libraries."""
BOUNDS, SOLVED = 408, 902
"""Bytes a part at 64-d that every query reads, and that are read where a graph is solved (benches/library.py)."""
COLD = 920_000
"""Bytes of an object of 30k faces with its samples: 15k vertices of 24, 30k faces of 12, 4.33 parts of 49k."""
MEMORY = 64e9
"""Bytes of memory of a machine that hold bounds."""
Z95 = 1.6449
"""Standard deviations to the 95th percentile of a normal law."""
DRAWS = 4000
MEASURED_SEGMENTS = 1000
TASKS = 200


def opening(dim: int) -> tuple[float, float]:
    """Return seconds and manifest bytes a segment, of a version of many segments."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "library"
        library = Library.create(path, descriptor=Random(dim), samples=False)
        shown, graphs = real_rows(dim, MEASURED_SEGMENTS, "g")
        entries = []
        for one, graph in zip(shown, graphs, strict=True):
            rows = [make_row(one, graph, samples=False)]
            columns = part_columns(rows, library.snapshot.manifest.saliency)
            entries.append(write_segment(path / SEGMENTS, columns, graphs_batch(rows), object_batches(rows)))
        size = len(append(path, entries, columns.relations.shape[1]).manifest.encode())
        times = []
        for _ in range(25):
            start = time.perf_counter()
            open_store(path)
            times.append(time.perf_counter() - start)
        return min(times) / len(entries), size / len(entries)


def nothing(task: object) -> Found:
    """Answer like a shard that has ten objects."""
    return [(0.5, i) for i in range(10)]


def round_trip(payload: object) -> float:
    """Return milliseconds of a task to a worker of a local Ray cluster and back, as others leave us the cores."""
    executor = RayExecutor()
    list(executor.map(nothing, [payload] * 20))
    times = []
    for _ in range(TASKS):
        start = time.perf_counter()
        list(executor.map(nothing, [payload]))
        times.append(1e3 * (time.perf_counter() - start))
    return float(np.percentile(times, 10))


def latency(rng: np.random.Generator, objects: float, machines: int, p50: float, p95: float) -> tuple[float, float]:
    """Return the median and the 95th percentile of the slowest of the machines, ms."""
    spread = np.log(p95 / p50) / Z95
    share = objects / machines / 1e6
    slowest = np.exp(np.log(p50 * share) + spread * rng.standard_normal((DRAWS, machines))).max(axis=1)
    low, high = np.percentile(slowest, [50, 95])
    return float(low), float(high)


def main() -> None:
    """Measure, simulate, print, save."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--query-ms", type=float, nargs=2, default=[105.1, 179.9], help="p50 and p95 at 10^6 objects")
    parser.add_argument("--build-seconds", type=float, default=0.077, help="of one core, an object of 30k faces")
    parser.add_argument("--ray", action="store_true", help="measure a task's way on a local cluster")
    parser.add_argument("--save", type=Path)
    arguments = parser.parse_args()
    p50, p95 = arguments.query_ms
    rng = np.random.default_rng(0)
    query = random_query(Prototypes(64), rng)
    asked, answered = len(pickle.dumps(query)), len(pickle.dumps(nothing(None)))
    per_segment, manifest = opening(64)
    lines = [
        f"opening: {1e6 * per_segment:.0f} us and {manifest:.0f} manifest bytes a segment, of {MEASURED_SEGMENTS}",
        f"a query is {asked} bytes, an answer {answered}; at 10^6 objects p50 {p50:.0f} ms, p95 {p95:.0f} ms",
    ]
    if arguments.ray:
        lines.append(f"a task to a Ray worker and back: {round_trip(query):.1f} ms")
    lines += [
        f"a machine holds {MEMORY / 1e9:.0f} GB; segments of {SEGMENT}; objects of 30k faces, {COLD / 1e6:.2f} MB",
        f"{'objects':>8} {'bounds GB':>10} {'solved GB':>10} {'cold TB':>8} {'segments':>9} {'open ms':>8} "
        f"{'machines':>9} {'p50 ms':>8} {'p95 ms':>8} {'net kB':>7} {'core-h to build':>16}",
    ]
    for objects in (1e6, 1e7, 1e8, 1e9):
        bounds, solved, segments = objects * PARTS * BOUNDS, objects * PARTS * SOLVED, objects / SEGMENT
        fewest = max(1, int(np.ceil(bounds / MEMORY)))
        for machines in sorted({fewest, 10 * fewest}):
            low, high = latency(rng, objects, machines, p50, p95)
            lines.append(
                f"{objects:8.0e} {bounds / 1e9:10.1f} {solved / 1e9:10.0f} {objects * COLD / 1e12:8.1f} "
                f"{segments:9.0f} {1e3 * per_segment * segments:8.1f} {machines:9d} {low:8.0f} {high:8.0f} "
                f"{machines * (asked + answered) / 1e3:7.0f} {objects * arguments.build_seconds / 3600:16.0f}"
            )
    print("\n".join(lines))
    if arguments.save:
        arguments.save.parent.mkdir(parents=True, exist_ok=True)
        arguments.save.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()

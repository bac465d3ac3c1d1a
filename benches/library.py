"""Libraries on disk: making, opening, appending, querying; against brute force, LanceDB and FAISS.

    python benches/library.py [--graphs 10000 100000 1000000] [--objects DIR] [--save benches/results/DATE-library.txt]

Queries are exact top 10 over a synthetic library (`synthetic.py`). Memory is what the first query takes
beside mapped files. Cold: the library's files are dropped from the
page cache and it is opened anew; its checksums are compared on the way. The vector stores hold the descriptors of a
graph's parts pooled by mass and return 100 candidates, which are re-ranked by UFGW: LanceDB by looking at all, FAISS
from 100,000 graphs on by probing 20 of sqrt(n) lists.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from graft.features import GeometricDescriptor
from graft.library import Library, LocalExecutor, build
from graft.library.search import Query, best
from graft.library.shelves import DiskShelf
from synthetic import Prototypes, Random, make, random_query, real_rows

K = 10
CANDIDATES = 100
PROBES = 20
INDEXED = 100_000
"""Graphs from which on FAISS is given inverted lists."""
UNPRUNED = 100_000
"""Solving all graphs is timed on a library of at most so many."""
COLUMNS = ("bounds", "parts", "graphs", "objects")


def milliseconds(work: Callable[[], object]) -> float:
    """Return how long a call takes."""
    start = time.perf_counter()
    work()
    return 1e3 * (time.perf_counter() - start)


def anonymous() -> float:
    """Return the process's memory beside mapped files, MB."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("RssAnon")) / 1024


class Peak:
    """The most memory beside mapped files that was seen while something ran, MB."""

    def __init__(self) -> None:
        self.most = 0.0
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._watch)

    def _watch(self) -> None:
        while not self._done.wait(0.002):
            self.most = max(self.most, anonymous())

    def __enter__(self) -> Peak:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._done.set()
        self._thread.join()


def drop_cache(path: Path) -> None:
    """Put a library's files out of the page cache."""
    for file in (path / "segments").iterdir():
        handle = os.open(file, os.O_RDONLY)
        os.fsync(handle)
        os.posix_fadvise(handle, 0, 0, os.POSIX_FADV_DONTNEED)
        os.close(handle)


def search(library: Library, query: Query, **flags: object) -> list[tuple[float, int]]:
    """Return the exact best."""
    return best(library._shelf.blocks(library.solver, None, None), query, K, **flags)


def describe(path: Path, library: Library) -> str:
    """Return the bytes of a library."""
    entries = library.snapshot.manifest.segments
    parts, objects = sum(e.parts for e in entries), len(library)
    size = {table: sum(e.files[table].size for e in entries) for table in COLUMNS}
    hot = size["bounds"] / parts
    solved = (size["parts"] + size["graphs"]) / parts
    return (
        f"bytes: {hot:.0f} a part read by every query (bounds), {solved:.0f} a part read where a graph is solved, "
        f"{size['objects'] / objects:.0f} an object cold; {sum(size.values()) / 1e9:.2f} GB in all, "
        f"{parts / objects:.2f} parts an object, {len(entries)} segments"
    )


def pooled(library: Library) -> np.ndarray:
    """Return every graph's descriptors pooled by mass, unit vectors (graphs, dim)."""
    rows = []
    for segment in library.snapshot.segments:
        weighted = segment.parts.descriptors * segment.parts.masses[:, None]
        rows.append(np.add.reduceat(weighted, segment.offsets[:-1]).astype(np.float32))
    together = np.concatenate(rows)
    return together / np.linalg.norm(together, axis=1, keepdims=True)


def pooled_query(query: Query) -> np.ndarray:
    """Return a target's pooled descriptors."""
    vector = (query.descriptors * query.prior[:, None]).sum(axis=0).astype(np.float32)
    return vector / np.linalg.norm(vector)


def faiss_search(vectors: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Return a search over the vectors by FAISS."""
    import faiss

    flat = faiss.IndexFlatIP(vectors.shape[1])
    index = flat
    if len(vectors) >= INDEXED:
        lists = int(np.sqrt(len(vectors)))
        index = faiss.IndexIVFFlat(flat, vectors.shape[1], lists, faiss.METRIC_INNER_PRODUCT)
        index.train(vectors[:: max(1, len(vectors) // (40 * lists))])
        index.nprobe = PROBES
    index.add(vectors)
    return lambda vector: index.search(vector[None], CANDIDATES)[1][0]


def lance_search(vectors: np.ndarray, folder: Path) -> Callable[[np.ndarray], np.ndarray]:
    """Return a search over the vectors by LanceDB."""
    import lancedb
    import pyarrow as pa

    column = pa.FixedSizeListArray.from_arrays(pa.array(vectors.ravel()), vectors.shape[1])
    data = pa.table({"place": np.arange(len(vectors)), "vector": column})
    table = lancedb.connect(folder).create_table("graphs", data)

    def run(vector: np.ndarray) -> np.ndarray:
        asked = table.search(vector).distance_type("dot").limit(CANDIDATES).select(["place", "_distance"])
        return asked.to_arrow()["place"].to_numpy()

    return run


def approximate(library: Library, queries: list[Query], exact: list, find: Callable[[np.ndarray], np.ndarray]) -> str:
    """Return time and recall of a vector search with re-ranking."""
    times, hits, top = [], 0, 0
    for query, truth in zip(queries, exact, strict=True):
        start = time.perf_counter()
        among = np.sort(find(pooled_query(query)).astype(np.int64))
        found = best(library._shelf.blocks(library.solver, None, among), query, K)
        times.append(1e3 * (time.perf_counter() - start))
        hits += len({i for _, i in found} & {i for _, i in truth})
        top += found[0][1] == truth[0][1]
    p50, p95 = np.percentile(times, [50, 95])
    recall, first = hits / K / len(queries), top / len(queries)
    return f"p50 {p50:8.1f} ms  p95 {p95:8.1f} ms  recall@10 {recall:.3f}  best found {first:.2f}"


def measure(graphs: int, dim: int, asked: int, scratch: Path) -> list[str]:
    """Return the lines about one size."""
    path = scratch / f"library-{graphs}"
    start = time.perf_counter()
    prototypes: Prototypes = make(path, graphs, dim)
    lines = [f"\n{graphs} graphs, {dim}-d: written in {time.perf_counter() - start:.1f} s"]
    rng = np.random.default_rng(3)
    queries = [random_query(prototypes, rng) for _ in range(asked)]
    descriptor = Random(dim)
    opened = [milliseconds(lambda: Library.open(path, descriptor=descriptor)) for _ in range(9)]
    drop_cache(path)
    base = anonymous()
    library = Library.open(path, descriptor=descriptor)
    with Peak() as peak:
        first = milliseconds(lambda: search(library, queries[0]))
    checked = milliseconds(lambda: search(Library.open(path, descriptor=descriptor), queries[0]))
    exact, times = [], []
    for query in queries:
        start = time.perf_counter()
        exact.append(search(library, query))
        times.append(1e3 * (time.perf_counter() - start))
    shelf = library._shelf
    assert isinstance(shelf, DiskShelf)
    read = [milliseconds(lambda found=found: [shelf.read(i) for _, i in found]) for found in exact]
    p50, p95 = np.percentile(times, [50, 95])
    lines += [
        describe(path, library),
        f"open {np.median(opened):.1f} ms; first query, cold {first:.0f} ms, in the page cache {checked:.0f} ms "
        f"(all checksums compared)",
        f"exact, warm:             p50 {p50:8.1f} ms  p95 {p95:8.1f} ms  memory +{peak.most - base:.0f} MB at most",
        f"reading the 10 matches:  p50 {np.median(read):8.1f} ms  (their samples are made again)",
    ]
    if graphs <= UNPRUNED:
        whole = [milliseconds(lambda query=query: search(library, query, prune=False)) for query in queries[:3]]
        if any(search(library, q, prune=False) != truth for q, truth in zip(queries[:3], exact, strict=False)):
            raise SystemExit("pruning changed the answer")
        lines.append(f"brute force:             p50 {np.median(whole):8.1f} ms  (the same answers)")
    vectors = pooled(library)
    for name, start_search in (
        ("FAISS", lambda: faiss_search(vectors)),
        ("LanceDB", lambda: lance_search(vectors, scratch / f"lance-{graphs}")),
    ):
        start = time.perf_counter()
        find = start_search()
        made = time.perf_counter() - start
        lines.append(f"{name + ' + re-ranking:':<25}{approximate(library, queries, exact, find)}  index {made:.1f} s")
    one = real_rows(dim, 1, "one")
    thousand = real_rows(dim, 1000, "many")
    lines.append(
        f"append and commit: 1 graph {milliseconds(lambda: library.extend_graphs(*one)):.0f} ms, "
        f"1000 graphs {milliseconds(lambda: library.extend_graphs(*thousand)):.0f} ms"
    )
    shutil.rmtree(path)
    return lines


def measure_build(objects: Path, scratch: Path, workers: int) -> str:
    """Return the line about building from real objects."""
    report = build([objects], scratch / "built", descriptor=GeometricDescriptor(), executor=LocalExecutor(workers))
    faces = [d.object.n_faces for d in Library.open(scratch / "built")]
    return (
        f"build: {report.folders} folders, {report.added} objects, {np.mean(faces):.0f} faces on average, "
        f"{workers} workers: {report.seconds:.1f} s, {report.folders / report.seconds:.1f} folders a second"
    )


def main() -> None:
    """Measure, print, save."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--graphs", type=int, nargs="+", default=[10_000, 100_000])
    parser.add_argument("--dim", type=int, default=64)
    parser.add_argument("--queries", type=int, default=20)
    parser.add_argument("--objects", type=Path, help="folder of labelled objects or demonstrations to build from")
    parser.add_argument("--scratch", type=Path, help="where libraries are written, 7 kB a graph")
    parser.add_argument("--save", type=Path)
    arguments = parser.parse_args()
    lines = [f"top {K}, {arguments.queries} queries; {os.cpu_count()} cores, {os.getloadavg()[0]:.0f} processes ran"]
    print(lines[0], flush=True)
    with tempfile.TemporaryDirectory(dir=arguments.scratch) as folder:
        scratch = Path(folder)
        if arguments.objects:
            lines.append(measure_build(arguments.objects, scratch, os.cpu_count() or 1))
            print(lines[-1], flush=True)
        for graphs in arguments.graphs:
            some = measure(graphs, arguments.dim, arguments.queries, scratch)
            print("\n".join(some), flush=True)
            lines += some
    if arguments.save:
        arguments.save.parent.mkdir(parents=True, exist_ok=True)
        arguments.save.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()

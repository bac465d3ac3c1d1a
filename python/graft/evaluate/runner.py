"""Ask every method every query, and keep what was answered."""

from __future__ import annotations

import json
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import graft
from graft.errors import InputError
from graft.evaluate.book import ROWS, Book, code_fingerprint, digest
from graft.evaluate.methods import Graphs, Method, Predictor
from graft.evaluate.metrics import GraspableMask
from graft.evaluate.protocols import Benchmark, stream
from graft.evaluate.rows import Answer, Row
from graft.evaluate.work import Progress, answered
from graft.graph import PartGraph

DIGITS = 9
"""Significant digits of what the metrics say in a row."""


@dataclass(frozen=True, eq=False)
class _Job:
    """What a worker needs; sent to it once."""

    benchmark: Benchmark
    methods: tuple[Method, ...]
    predictors: tuple[Predictor, ...]
    k: int
    masks: dict[int, GraspableMask] = field(default_factory=dict)

    def _mask(self, target: int) -> GraspableMask:
        """Return the blurred mask of a target, made once for all queries that ask about it."""
        if target not in self.masks:
            subject = self.benchmark.subjects[target]
            self.masks[target] = GraspableMask.of(subject.truth, subject.diagonal)
        return self.masks[target]

    def rows(self, number: int) -> list[Row]:
        """Answer query `number` by every method."""
        query = self.benchmark.queries[number]
        subject = self.benchmark.subjects[query.target]
        mask = self._mask(query.target)
        rows = []
        for method, predictor in zip(self.methods, self.predictors, strict=True):
            rng = stream(self.benchmark.posing.seed, method.name, query.key)
            answers = predictor.predict(query, self.k, rng)
            measures = mask.measure(np.array([answer.point for answer in answers]).reshape(-1, 3))
            rows.append(
                Row(
                    method=method.name,
                    query=query.key,
                    target=subject.key,
                    category=self.benchmark.category(query.target),
                    exchangeable=method.exchangeable,
                    answers=tuple(
                        Answer(
                            source=self._source(answer.source),
                            source_category=self._source_category(answer.source),
                            part=subject.object.parts[answer.part].name,
                            right=answer.part in subject.object.graspable,
                            inside=bool(measures.inside[i]),
                            nss=_rounded(measures.nss[i]),
                            distance=_rounded(measures.distance[i]),
                            confidence=None if answer.confidence is None else _rounded(answer.confidence),
                            point=(
                                _rounded(answer.point[0]),
                                _rounded(answer.point[1]),
                                _rounded(answer.point[2]),
                            ),
                        )
                        for i, answer in enumerate(answers)
                    ),
                )
            )
        return rows

    def _source(self, source: int | None) -> str | None:
        return None if source is None else self.benchmark.sources[source].demonstration.name

    def _source_category(self, source: int | None) -> str | None:
        return None if source is None else self.benchmark.category(self.benchmark.sources[source].subject)


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def evaluate(
    benchmark: Benchmark,
    methods: Sequence[Method],
    *,
    k: int = 5,
    workers: int = 1,
    out: Path | None = None,
    progress: Progress = lambda *_: None,
) -> list[Row]:
    """Ask every method every query.

    Args:
        benchmark: Objects, demonstrations, queries.
        methods: With unique names.
        k: How many ranked contacts each gives.
        workers: Processes. With more than one, a script that calls this needs the usual
            `if __name__ == "__main__":` of multiprocessing.
        out: Folder of `rows.jsonl`; rows found there are not computed again. None keeps nothing.
        progress: Told what is being done.

    Returns:
        Rows in the order of queries, and of methods within a query.

    Raises:
        InputError: Two methods of one name, a number that is not positive, a file of rows made with other
            settings, or a target without a mask.
    """
    names = [method.name for method in methods]
    if len(set(names)) < len(names):
        raise InputError(f"methods: expected unique names, got {', '.join(names)}")
    for name, value in (("k", k), ("workers", workers)):
        if value < 1:
            raise InputError(f"{name}: expected at least 1, got {value}")
    keys = [query.key for query in benchmark.queries]
    book = None if out is None else Book.open(out / ROWS, described(benchmark, methods) | {"k": k}, Row.read)
    return answered(
        keys,
        lambda: _Job(benchmark, tuple(methods), fit(benchmark, methods, workers=workers, progress=progress), k),
        book,
        workers=workers,
        what="transferring",
        progress=progress,
    )


def build_graphs(
    benchmark: Benchmark,
    settings: Sequence[Graphs],
    *,
    workers: int = 1,
    progress: Progress = lambda *_: None,
) -> list[tuple[PartGraph, ...]]:
    """Build the part graphs of all objects of a benchmark, for each of some settings."""
    everything = [(setting, subject.object) for setting in settings for subject in benchmark.subjects]
    built = []
    # Threads suffice: building a graph is the core's work, done without the interpreter's lock.
    with ThreadPoolExecutor(workers) as pool:
        for graph in pool.map(lambda pair: pair[0].build(pair[1]), everything):
            built.append(graph)
            progress("part graphs", len(built), len(everything))
    size = len(benchmark.subjects)
    return [tuple(built[i * size : (i + 1) * size]) for i in range(len(settings))]


def fit(
    benchmark: Benchmark, methods: Sequence[Method], *, workers: int = 1, progress: Progress = lambda *_: None
) -> tuple[Predictor, ...]:
    """Build the part graphs that the methods read, each once, and fit the methods."""
    settings = list(dict.fromkeys(method.graphs for method in methods))
    graphs = dict(zip(settings, build_graphs(benchmark, settings, workers=workers, progress=progress), strict=True))
    return tuple(method.fit(benchmark, graphs[method.graphs]) for method in methods)


def described(benchmark: Benchmark, methods: Sequence[Method]) -> dict[str, Any]:
    """Return what the rows of any evaluation depend on."""
    return {
        "graft": graft.__version__,
        "code": code_fingerprint(),
        "protocol": benchmark.protocol,
        "posing": asdict(benchmark.posing),
        "methods": [method.name for method in methods],
        "parameters": digest(repr(list(methods)).encode()),
        "queries": digest(json.dumps([[q.key, q.target, q.sources] for q in benchmark.queries]).encode()),
        "objects": digest(*(b"%s%s" % (s.key.encode(), s.truth.bounds.tobytes()) for s in benchmark.subjects)),
    }

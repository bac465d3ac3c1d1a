"""Rows in, figures out: means with intervals, per category, the coverage-accuracy curve, one document."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

import graft
from graft.evaluate.book import code_fingerprint
from graft.evaluate.diversity import Diversity
from graft.evaluate.intervals import Estimate, bootstrap_mean
from graft.evaluate.protocols import Benchmark
from graft.evaluate.rows import Answer, Row
from graft.objects import Floats

QUOTED: Mapping[str, Mapping[str, float]] = {"GRAFT, paper (quoted)": {"asr": 0.85, "nss": 0.82, "dtm": 0.02}}
"""Figures that others published, on their own objects; not measured here."""

MEASURES: Mapping[str, Callable[[Answer], float]] = {
    "part": lambda answer: float(answer.right),
    "asr": lambda answer: float(answer.inside),
    "nss": lambda answer: answer.nss,
    "dtm": lambda answer: answer.distance,
}
"""Name -> what is averaged."""

Table = dict[str, Estimate]
"""`part`, `asr`, `nss`, `dtm` of the best-ranked contact; with `_top` behind it, the mean of the top k."""

COVERAGES = tuple(np.round(np.linspace(0.1, 1.0, 10), 1).tolist())
"""Shares of the queries at which accuracy is told."""


@dataclass(frozen=True)
class Summary:
    """A method's figures over some targets.

    Attributes:
        method: Its name.
        targets: How many.
        figures: By name.
    """

    method: str
    targets: int
    figures: Table


def summarise(rows: Sequence[Row], k: int = 5, seed: int = 0) -> list[Summary]:
    """Return the figures of every method, in the order in which they come.

    Args:
        rows: Of any methods and targets.
        k: How many of the answers the top-k figures average over.
        seed: Of the bootstrap.
    """
    summaries = []
    for name in dict.fromkeys(row.method for row in rows):
        mine = [row for row in rows if row.method == name and row.answers]
        figures = {}
        for depth, suffix in ((1, ""), (k, "_top")):
            for measure, value in MEASURES.items():
                means = [_mean(row, value, depth) for row in mine]
                figures[measure + suffix] = bootstrap_mean(means, [row.target for row in mine], seed=seed)
        summaries.append(Summary(name, len({row.target for row in mine}), figures))
    return summaries


def effects(rows: Sequence[Row], reference: str, k: int = 5, seed: int = 0) -> dict[str, Table]:
    """Return what every method's figures are beyond those of the method `reference`, query by query.

    The differences are paired: each is of two answers to the same query, so that hard targets, which are hard for
    both, do not widen the intervals.
    """
    ours = {row.query: row for row in rows if row.method == reference and row.answers}
    found: dict[str, Table] = {}
    for name in dict.fromkeys(row.method for row in rows if row.method != reference):
        mine = [row for row in rows if row.method == name and row.answers and row.query in ours]
        targets = [row.target for row in mine]
        found[name] = {
            measure + suffix: bootstrap_mean(
                [_mean(row, value, depth) - _mean(ours[row.query], value, depth) for row in mine], targets, seed=seed
            )
            for depth, suffix in ((1, ""), (k, "_top"))
            for measure, value in MEASURES.items()
        }
    return found


def _mean(row: Row, value: Callable[[Answer], float], depth: int) -> float:
    """Return the mean over the answers that a figure of the top `depth` averages."""
    return float(np.mean([value(answer) for answer in _counted(row, depth)]))


def _counted(row: Row, depth: int) -> Sequence[Answer]:
    """Return the answers that a figure of the top `depth` averages: draws without a rank all count."""
    return row.answers if row.exchangeable else row.answers[:depth]


def by_category(rows: Sequence[Row], k: int = 5, seed: int = 0) -> dict[str, list[Summary]]:
    """Return the summaries of each category of targets, in alphabetical order."""
    return {
        category: summarise([row for row in rows if row.category == category], k, seed)
        for category in sorted({row.category for row in rows})
    }


def coverage_curve(rows: Sequence[Row]) -> list[tuple[float, float]]:
    """Return (coverage, part accuracy) when only the surest answers are given.

    Answers of equal confidence keep the order of the rows. A confidence that is worth something makes the
    curve fall.

    Args:
        rows: Of one method; answers without a confidence count as the least sure.
    """
    right = _surest_first(rows)
    counts = [max(1, round(coverage * len(right))) for coverage in COVERAGES]
    return [(coverage, float(right[:count].mean())) for coverage, count in zip(COVERAGES, counts, strict=True)]


def coverage_area(rows: Sequence[Row]) -> tuple[float, float]:
    """Return the area under the coverage-accuracy curve, and the largest that the same answers allow.

    The area is the mean accuracy over all numbers of answers given, surest first; it is largest when every right
    answer comes before every wrong one.

    Args:
        rows: Of one method, as for `coverage_curve`.
    """
    right = _surest_first(rows)
    area, most = (float((np.cumsum(r) / np.arange(1, len(r) + 1)).mean()) for r in (right, np.sort(right)[::-1]))
    return area, most


def calibration_error(rows: Sequence[Row]) -> float | None:
    """Return the mean squared difference of confidence and being right (Brier 1950); None where none is in [0, 1]."""
    firsts = [row.answers[0] for row in rows if row.answers]
    sure = np.array([np.nan if answer.confidence is None else answer.confidence for answer in firsts])
    if not ((sure >= 0) & (sure <= 1)).all():
        return None
    return float(np.square(sure - [answer.right for answer in firsts]).mean())


def _surest_first(rows: Sequence[Row]) -> Floats:
    """Return 1 for every right answer and 0 for every wrong one, the surest first."""
    firsts = [row.answers[0] for row in rows if row.answers]
    sure = [-np.inf if answer.confidence is None else answer.confidence for answer in firsts]
    return np.array([firsts[i].right for i in np.argsort(-np.array(sure), kind="stable")], np.float64)


def document(
    benchmark: Benchmark,
    rows: Sequence[Row],
    k: int,
    *,
    quoted: bool = True,
    reference: str | None = None,
    varied: Sequence[Diversity] = (),
) -> dict[str, Any]:
    """Return everything as one JSON document: what was asked, the figures, the rows.

    Args:
        benchmark: What was asked.
        rows: What was answered.
        k: How many answers the top-k figures average over.
        quoted: Put the figures that others published beside ours.
        reference: Method that the others' effects are told against; None leaves them out.
        varied: Diversity, where it was measured.
    """
    seed = benchmark.posing.seed
    return {
        "graft": graft.__version__,
        "code": code_fingerprint(),
        "protocol": benchmark.protocol,
        "posing": asdict(benchmark.posing),
        "k": k,
        "targets": len({query.target for query in benchmark.queries}),
        "queries": len(benchmark.queries),
        "sources": len(benchmark.sources),
        "defects": {s.key: s.defect for s in benchmark.subjects if s.defect is not None},
        "quoted": {name: dict(figures) for name, figures in QUOTED.items()} if quoted else {},
        "methods": [asdict(summary) for summary in summarise(rows, k, seed)],
        "categories": {
            category: [asdict(summary) for summary in summaries]
            for category, summaries in by_category(rows, k, seed).items()
        },
        "effects": {}
        if reference is None
        else {
            name: {key: asdict(figure) for key, figure in table.items()}
            for name, table in effects(rows, reference, k, seed).items()
        },
        "coverage": {
            name: coverage_curve([row for row in rows if row.method == name])
            for name in dict.fromkeys(row.method for row in rows if not row.exchangeable)
        },
        "coverage_area": {
            name: coverage_area([row for row in rows if row.method == name])
            for name in dict.fromkeys(row.method for row in rows if not row.exchangeable)
        },
        "diversity": [asdict(found) for found in varied],
        "rows": [asdict(row) for row in rows],
    }

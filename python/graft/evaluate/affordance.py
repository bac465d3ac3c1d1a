"""The paper's table 1: graft, the baselines, and the worst of graft's answers."""

from __future__ import annotations

from collections.abc import Sequence

from graft.contact import TransferredContact
from graft.evaluate.baselines import (
    FunctionalMap,
    NearestDescriptor,
    NearestMoments,
    RandomPart,
    RandomPoint,
    WholeObject,
    image_methods,
)
from graft.evaluate.methods import Graft, GraftPredictor, Method
from graft.evaluate.protocols import Benchmark
from graft.evaluate.rows import Row


def methods() -> list[Method]:
    """Return graft and every baseline that can be run here, in the order of the table."""
    return [
        Graft(),
        NearestMoments(),
        NearestDescriptor(),
        WholeObject(),
        FunctionalMap(),
        *image_methods(),
        RandomPart(),
        RandomPoint(),
    ]


def worst(rows: Sequence[Row], count: int) -> list[Row]:
    """Return the rows whose best-ranked contact is worst: outside and far, then inside with the least NSS.

    Ties keep the order of the rows.
    """
    answered = [row for row in rows if row.answers]
    return sorted(answered, key=lambda row: (-row.answers[0].distance, row.answers[0].nss))[:count]


def pictured(benchmark: Benchmark, predictor: GraftPredictor, rows: Sequence[Row]) -> list[TransferredContact]:
    """Return the best-ranked transfers of rows of graft, to be drawn."""
    queries = {query.key: query for query in benchmark.queries}
    return [predictor.transfers(queries[row.query], 1)[0] for row in rows]

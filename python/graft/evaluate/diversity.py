"""The paper's other claim: the best matches come from many categories, and stay right as more are taken."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from graft.evaluate.affordance import methods
from graft.evaluate.baselines import RandomPart, RandomPoint
from graft.evaluate.intervals import Estimate, bootstrap_mean
from graft.evaluate.methods import Method
from graft.evaluate.rows import Row


@dataclass(frozen=True)
class Diversity:
    """How varied a method's top k are.

    Attributes:
        method: Its name.
        categories: Mean number of distinct source categories among the top k.
        entropy: Mean normalised entropy of these categories.
        accuracy: Part accuracy of the top 1, 2, ... k: mean over the contacts up to each rank.
    """

    method: str
    categories: Estimate
    entropy: Estimate
    accuracy: tuple[Estimate, ...]


def retrieving_methods() -> list[Method]:
    """Return the methods that rank sources."""
    return [method for method in methods() if not isinstance(method, RandomPart | RandomPoint)]


def normalised_entropy(labels: Sequence[Hashable]) -> float:
    """Return the entropy of labels over log of their number: 0 when all are one, 1 when all differ."""
    if len(labels) < 2:
        return 0.0
    shares = np.array(list(Counter(labels).values())) / len(labels)
    return float(-(shares * np.log(shares)).sum() / np.log(len(labels)))


def diversity(rows: Sequence[Row], k: int, seed: int = 0) -> list[Diversity]:
    """Return the diversity of every method's k best answers.

    Args:
        rows: Of methods whose answers have a rank and a source.
        k: How many of the answers count.
        seed: Of the bootstrap.
    """
    found = []
    for name in dict.fromkeys(row.method for row in rows):
        mine = [row for row in rows if row.method == name and row.answers]
        targets = [row.target for row in mine]
        kinds = [[answer.source_category for answer in row.answers[:k]] for row in mine]
        found.append(
            Diversity(
                method=name,
                categories=bootstrap_mean([float(len(set(labels))) for labels in kinds], targets, seed=seed),
                entropy=bootstrap_mean([normalised_entropy(labels) for labels in kinds], targets, seed=seed),
                accuracy=tuple(
                    bootstrap_mean(
                        [float(np.mean([answer.right for answer in row.answers[:depth]])) for row in mine],
                        targets,
                        seed=seed,
                    )
                    for depth in range(1, k + 1)
                ),
            )
        )
    return found

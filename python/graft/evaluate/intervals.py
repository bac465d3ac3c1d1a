"""Bootstrap intervals over targets."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from graft.errors import InputError

LEVEL = 0.95
"""Coverage of the intervals."""

DRAWS = 2000
"""Bootstrap resamples; the ends of an interval then vary by about a twentieth of its width."""


@dataclass(frozen=True)
class Estimate:
    """A mean and its bootstrap interval.

    Attributes:
        value: Mean over all values.
        low: Lower end of the interval.
        high: Upper end.
    """

    value: float
    low: float
    high: float


def bootstrap_mean(
    values: Sequence[float], targets: Sequence[Hashable], *, seed: int = 0, draws: int = DRAWS
) -> Estimate:
    """Return the mean of `values` and its percentile interval, resampling whole targets.

    Values of one target (its contacts, or its transfers from several sources) stand or fall together: they
    are drawn together, so that measuring a target more often does not make the interval narrower.

    Args:
        values: One per prediction.
        targets: What each was predicted on.
        seed: Of the resampling.
        draws: Number of resamples.

    Raises:
        InputError: No values, or as many targets as there are not values.
    """
    if len(values) == 0 or len(values) != len(targets):
        raise InputError(f"values: expected as many as targets ({len(targets)}) and at least one, got {len(values)}")
    numbers = {target: i for i, target in enumerate(dict.fromkeys(targets))}
    group = np.array([numbers[target] for target in targets])
    sums = np.bincount(group, weights=np.asarray(values, np.float64))
    counts = np.bincount(group)
    picks = np.random.default_rng(seed).integers(len(sums), size=(draws, len(sums)))
    means = sums[picks].sum(axis=1) / counts[picks].sum(axis=1)
    low, high = np.quantile(means, ((1.0 - LEVEL) / 2.0, (1.0 + LEVEL) / 2.0))
    return Estimate(float(sums.sum() / counts.sum()), float(low), float(high))

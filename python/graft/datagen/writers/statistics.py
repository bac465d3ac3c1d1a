"""Statistics of features as LeRobot keeps them, of an episode and added up, in memory that does not grow."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from graft.checks import Floats
from graft.datagen.episode import Image

QUANTILES = (0.01, 0.10, 0.50, 0.90, 0.99)
"""Those of LeRobot."""

LEVELS = 256
"""Of a channel of an image."""

Statistics = dict[str, Floats]
"""min, max, mean, std, count and quantiles (q01 ...), each of the shape of one step, count (1,)."""


def quantile_key(q: float) -> str:
    """Return LeRobot's name of a quantile."""
    return f"q{round(q * 100):02d}"


STATISTICS = ("min", "max", "mean", "std", "count", *map(quantile_key, QUANTILES))


def of_rows(rows: Floats) -> Statistics:
    """Return the statistics of (T, d) rows."""
    result = {
        "min": rows.min(axis=0),
        "max": rows.max(axis=0),
        "mean": rows.mean(axis=0),
        "std": rows.std(axis=0),
        "count": np.array([len(rows)], np.float64),
    }
    values = np.quantile(rows, QUANTILES, axis=0)
    return result | {quantile_key(q): value for q, value in zip(QUANTILES, values, strict=True)}


class ImageStatistics:
    """Counts of the levels of each channel, from which all statistics follow exactly."""

    def __init__(self) -> None:
        self.levels = np.zeros((3, LEVELS), np.int64)
        self.frames = 0

    def watched(self, frames: Iterable[Image]) -> Iterator[Image]:
        """Give the frames on, counting them."""
        for frame in frames:
            for channel in range(3):
                self.levels[channel] += np.bincount(frame[:, :, channel].ravel(), minlength=LEVELS)
            self.frames += 1
            yield frame

    def result(self) -> Statistics:
        """Return the statistics of the channels, (3, 1, 1), of values in [0, 1]."""
        values = np.arange(LEVELS) / (LEVELS - 1)
        pixels = self.levels.sum(axis=1)
        mean = self.levels @ values / pixels
        variance = (self.levels * np.square(values - mean[:, None])).sum(axis=1) / pixels
        seen = self.levels > 0
        below = np.cumsum(self.levels, axis=1)
        result = {
            "min": values[seen.argmax(axis=1)],
            "max": values[LEVELS - 1 - seen[:, ::-1].argmax(axis=1)],
            "mean": mean,
            "std": np.sqrt(variance),
        }
        for q in QUANTILES:
            result[quantile_key(q)] = values[(below >= q * pixels[:, None]).argmax(axis=1)]
        shaped: Statistics = {key: value.reshape(3, 1, 1) for key, value in result.items()}
        return shaped | {"count": np.array([self.frames], np.float64)}


class Total:
    """Statistics of all episodes: exact but for the quantiles, which are means over the episodes, as LeRobot's."""

    def __init__(self) -> None:
        self._sums: dict[str, Statistics] = {}

    def add(self, episode: Mapping[str, Statistics]) -> None:
        """Add the statistics of an episode, feature by feature (Chan, Golub, LeVeque 1979 for the variance)."""
        for feature, new in episode.items():
            old = self._sums.get(feature)
            self._sums[feature] = dict(new) if old is None else _joined(old, new)

    def document(self) -> dict[str, dict[str, Any]]:
        """Return meta/stats.json."""
        return {
            feature: {
                key: value.astype(np.int64).tolist() if key == "count" else value.tolist()
                for key, value in statistics.items()
            }
            for feature, statistics in self._sums.items()
        }


def _joined(old: Statistics, new: Statistics) -> Statistics:
    count = old["count"] + new["count"]
    share = (new["count"] / count).reshape((1,) * old["mean"].ndim)
    step = new["mean"] - old["mean"]
    variance = (
        (1 - share) * np.square(old["std"]) + share * np.square(new["std"]) + share * (1 - share) * np.square(step)
    )
    result = {
        "min": np.minimum(old["min"], new["min"]),
        "max": np.maximum(old["max"], new["max"]),
        "mean": old["mean"] + share * step,
        "std": np.sqrt(variance),
        "count": count,
    }
    for q in QUANTILES:
        key = quantile_key(q)
        result[key] = (1 - share) * old[key] + share * new[key]
    return result

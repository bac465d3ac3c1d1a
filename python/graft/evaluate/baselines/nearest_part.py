"""The target part that looks most like the demonstrated one; no graph, no transport.

Sources are retrieved by the same distance, and the contact is put in the middle of the part: the surface
sample with the least mean distance to the part's other samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.random import Generator
from scipy.spatial.distance import cdist

from graft.errors import InputError
from graft.evaluate.baselines.moments import hull_volume, shape_moments, standardised
from graft.evaluate.methods import Graphs, Prediction
from graft.evaluate.protocols import Benchmark, Query, Source
from graft.graph import PartGraph
from graft.objects import Floats

MIDDLE_SAMPLES = 256
"""Surface samples of a part among which its middle is sought."""


@dataclass(frozen=True)
class NearestMoments:
    """Nearest in six hull and inertia moments, standardised over the parts of all objects.

    Of some twenty sets of six that were tried on real objects this one, which knows a part's size, was best.

    Attributes:
        name: In tables.
        graphs: Whose surface samples are described.
        exchangeable: No.
    """

    name: str = "nearest part (six moments)"
    graphs: Graphs = field(default_factory=Graphs)
    exchangeable: bool = False

    def fit(self, benchmark: Benchmark, graphs: Sequence[PartGraph]) -> _Nearest:
        """Describe every part."""
        sizes = [len(graph.points) for graph in graphs]
        rows = standardised(np.array([_moments(graph, i) for graph in graphs for i in range(len(graph.points))]))
        features = np.split(rows, np.cumsum(sizes)[:-1])
        return _Nearest(benchmark.sources, tuple(graphs), tuple(features), "euclidean")


def _moments(graph: PartGraph, part: int) -> Floats:
    """Return four moments of a part's shape, how full its hull's box is, and its size in the object's."""
    points = graph.points[part]
    fullness = hull_volume(points)[0] / graph.volumes[part]
    size = np.sqrt(graph.areas[part]) / graph.diagonal
    return np.append(shape_moments(points), [fullness, size])


@dataclass(frozen=True)
class NearestDescriptor:
    """Nearest in graft's own part descriptor by cosine, as the cost matrix compares it.

    Attributes:
        name: In tables.
        graphs: Whose descriptors are compared.
        exchangeable: No.
    """

    name: str = "nearest part (descriptor)"
    graphs: Graphs = field(default_factory=Graphs)
    exchangeable: bool = False

    def fit(self, benchmark: Benchmark, graphs: Sequence[PartGraph]) -> _Nearest:
        """Take the descriptors of the graphs."""
        features = [graph.descriptors for graph in graphs if graph.descriptors is not None]
        if len(features) < len(graphs):
            raise InputError(f"{self.name}: expected part graphs with descriptors, got some without")
        return _Nearest(benchmark.sources, tuple(graphs), tuple(features), "cosine")


@dataclass(frozen=True, eq=False)
class _Nearest:
    """Features of every part, and how they are compared."""

    sources: tuple[Source, ...]
    graphs: tuple[PartGraph, ...]
    features: tuple[Floats, ...]
    metric: Literal["euclidean", "cosine"]
    middles: dict[tuple[int, int], Floats] = field(default_factory=dict)

    def predict(self, query: Query, k: int, rng: Generator) -> list[Prediction]:
        """Return the middles of the parts nearest to the demonstrated ones, nearest first."""
        chosen = [self.sources[i] for i in query.sources]
        shown = np.array([self.features[s.subject][s.demonstration.contact.part] for s in chosen])
        distances = np.nan_to_num(cdist(shown, self.features[query.target], self.metric), nan=2.0)
        parts = distances.argmin(axis=1)
        least = distances.min(axis=1)
        return [
            Prediction(
                point=self._middle(query.target, int(parts[row])),
                part=int(parts[row]),
                source=query.sources[row],
                confidence=-float(least[row]),
            )
            for row in np.argsort(least, kind="stable")[:k]
        ]

    def _middle(self, subject: int, part: int) -> Floats:
        if (subject, part) not in self.middles:
            points = self.graphs[subject].points[part]
            few = points[:: max(1, len(points) // MIDDLE_SAMPLES)]
            self.middles[subject, part] = few[int(cdist(few, few).mean(axis=1).argmin())]
        return self.middles[subject, part]

"""The object most alike as a whole, laid on the target by ICP; the contact goes to the nearest point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator
from scipy.spatial.distance import pdist

from graft.evaluate.baselines.icp import align
from graft.evaluate.baselines.moments import shape_moments, standardised
from graft.evaluate.methods import Graphs, Prediction
from graft.evaluate.metrics import sample_surface
from graft.evaluate.protocols import Benchmark, Query, Source
from graft.graph import PartGraph
from graft.marking import closest_surface_point
from graft.objects import Floats, PartObject

SAMPLES = 256
"""Surface points of an object that are described and laid on each other."""

BINS = 16
"""Bins of the histogram of distances between points (D2, Osada et al. 2002)."""

LONGEST = 3.0
"""Last edge of that histogram, in root mean square distances."""


@dataclass(frozen=True)
class WholeObject:
    """Retrieval by moments and distance histogram of the whole object, transfer by ICP and nearest point.

    Attributes:
        name: In tables.
        graphs: Not used.
        exchangeable: No.
    """

    name: str = "whole object + ICP"
    graphs: Graphs = field(default_factory=Graphs)
    exchangeable: bool = False

    def fit(self, benchmark: Benchmark, graphs: Sequence[PartGraph]) -> _WholeObjects:
        """Sample and describe every object."""
        objects = tuple(subject.object for subject in benchmark.subjects)
        samples = tuple(_thinned(sample_surface(obj, SAMPLES).points) for obj in objects)
        features = standardised(np.array([describe(points) for points in samples]))
        return _WholeObjects(benchmark.sources, objects, samples, features)


def describe(points: Floats) -> Floats:
    """Return four moments and a histogram of distances of an object's surface points (s, 3)."""
    distances = pdist(points)
    spread = max(float(np.sqrt(np.square(distances).mean())), np.finfo(float).tiny)
    counts = np.histogram(distances / spread, bins=BINS, range=(0.0, LONGEST))[0]
    return np.concatenate([shape_moments(points), counts / len(distances)])


def _thinned(points: Floats) -> Floats:
    """Return about `SAMPLES` points: a cloud comes as it is."""
    return points[:: max(1, len(points) // SAMPLES)]


@dataclass(frozen=True, eq=False)
class _WholeObjects:
    """Samples and features of every object."""

    sources: tuple[Source, ...]
    objects: tuple[PartObject, ...]
    samples: tuple[Floats, ...]
    features: Floats

    def predict(self, query: Query, k: int, rng: Generator) -> list[Prediction]:
        """Return the contacts of the most similar objects, laid on the target."""
        target = self.objects[query.target]
        subjects = [self.sources[i].subject for i in query.sources]
        distances = np.linalg.norm(self.features[subjects] - self.features[query.target], axis=1)
        predictions = []
        for row in np.argsort(distances, kind="stable")[:k]:
            alignment = align(self.samples[subjects[row]], self.samples[query.target])
            contact = self.sources[query.sources[row]].demonstration.contact
            mapped = alignment.transform[:3, :3] @ contact.point + alignment.transform[:3, 3]
            found = [closest_surface_point(part, mapped) for part in target.parts]
            part = int(np.argmin([distance for _, _, distance in found]))
            predictions.append(Prediction(found[part][0], part, query.sources[row], -float(distances[row])))
        return predictions

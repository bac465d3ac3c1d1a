"""Chance: any point of the surface, or any point of any part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from numpy.random import Generator

from graft.evaluate.methods import Graphs, Prediction
from graft.evaluate.metrics import sample_surface
from graft.evaluate.protocols import Benchmark, Query
from graft.graph import PartGraph
from graft.objects import PartObject

DRAWS = 32
"""Draws per query; chance is their mean, so that its row is not itself a matter of luck."""


@dataclass(frozen=True)
class RandomPoint:
    """A point of the surface, by area.

    Attributes:
        name: In tables.
        graphs: Not used.
        exchangeable: Yes.
    """

    name: str = "random surface point"
    graphs: Graphs = field(default_factory=Graphs)
    exchangeable: bool = True

    def fit(self, benchmark: Benchmark, graphs: Sequence[PartGraph]) -> _Points:
        """Keep the objects."""
        return _Points(tuple(subject.object for subject in benchmark.subjects))


@dataclass(frozen=True, eq=False)
class _Points:
    objects: tuple[PartObject, ...]

    def predict(self, query: Query, k: int, rng: Generator) -> list[Prediction]:
        """Return `DRAWS` points."""
        surface = sample_surface(self.objects[query.target], DRAWS, int(rng.integers(2**31)))
        rows = range(DRAWS) if len(surface.points) == DRAWS else rng.integers(len(surface.points), size=DRAWS)
        return [Prediction(surface.points[row], int(surface.part[row])) for row in rows]


@dataclass(frozen=True)
class RandomPart:
    """A part, each with the same chance, and a point of its surface.

    Attributes:
        name: In tables.
        graphs: Whose surface samples are drawn from.
        exchangeable: Yes.
    """

    name: str = "random part"
    graphs: Graphs = field(default_factory=Graphs)
    exchangeable: bool = True

    def fit(self, benchmark: Benchmark, graphs: Sequence[PartGraph]) -> _Parts:
        """Keep the part graphs."""
        return _Parts(tuple(graphs))


@dataclass(frozen=True, eq=False)
class _Parts:
    graphs: tuple[PartGraph, ...]

    def predict(self, query: Query, k: int, rng: Generator) -> list[Prediction]:
        """Return `DRAWS` points of random parts."""
        points = self.graphs[query.target].points
        parts = rng.integers(len(points), size=DRAWS)
        return [Prediction(points[part][rng.integers(len(points[part]))], int(part)) for part in parts]

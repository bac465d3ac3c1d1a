"""What a method of answering a query is, and graft's own.

A method is fitted once to all objects of a benchmark and then asked, query by query, for ranked contacts. It
sees posed objects with the parts it is given, never the mask.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np
from numpy.random import Generator

from graft.contact import VOTERS, TransferredContact, agree, transfer_contact
from graft.contact.canonical import box_frame
from graft.evaluate.protocols import Benchmark, Query, Source
from graft.features import Descriptor, GeometricDescriptor
from graft.graph import PartGraph, Structure, build_graph
from graft.library import Match
from graft.marking import closest_surface_point
from graft.objects import Floats, PartObject
from graft.transport import UFGW, Transport


@dataclass(frozen=True, eq=False)
class Prediction:
    """A predicted contact.

    Attributes:
        point: (3,) target frame and units.
        part: Index of the target part it is said to lie on.
        source: Index of the source it comes from; None for methods that look at none.
        confidence: Higher is surer, comparable between queries of one method; None when it does not say.
        approach: (3,) unit direction in which the gripper should come, target frame; None when it does not say.
    """

    point: Floats
    part: int
    source: int | None = None
    confidence: float | None = None
    approach: Floats | None = None


class Predictor(Protocol):
    """A method fitted to a benchmark."""

    def predict(self, query: Query, k: int, rng: Generator) -> list[Prediction]:
        """Return up to k contacts, best first; anything random is drawn from `rng`."""
        ...


@dataclass(frozen=True)
class Graphs:
    """Which part graphs a method reads: parameters of `graft.graph.build_graph`.

    Attributes:
        descriptor: What parts are described by.
        structure: How edge lengths are told.
    """

    descriptor: Descriptor | None = field(default_factory=GeometricDescriptor)
    structure: Structure = "all_pairs"

    def build(self, obj: PartObject) -> PartGraph:
        """Build the part graph of an object."""
        return build_graph(obj, descriptor=self.descriptor, structure=self.structure)


class Method(Protocol):
    """A way to answer queries.

    Attributes:
        name: In tables; unique within an evaluation.
        graphs: Which part graphs it reads.
        exchangeable: Its contacts are draws without a rank: every rank is measured by their mean.
    """

    @property
    def name(self) -> str:
        """In tables."""
        ...

    @property
    def graphs(self) -> Graphs:
        """Which part graphs it reads."""
        ...

    @property
    def exchangeable(self) -> bool:
        """Whether its contacts have no rank."""
        ...

    def fit(self, benchmark: Benchmark, graphs: Sequence[PartGraph]) -> Predictor:
        """Return the predictor for a benchmark, given the part graphs of its subjects."""
        ...


class Solver(Protocol):
    """Matches many sources against one target; `graft.transport.UFGW` is one."""

    def batch(self, sources: Sequence[PartGraph], source_parts: Sequence[int], target: PartGraph) -> list[Transport]:
        """Return one transport per source, in order."""
        ...


Landing = Literal["codes", "projected", "unaligned"]
"""Where on the matched part the contact lands: the surface point with the nearest Fourier code and normal;
the surface point nearest to the contact carried over by the aligned frames; the same by the boxes' frames as
they are, without alignment."""


@dataclass(frozen=True)
class Graft:
    """graft: retrieval and part match by UFGW, contact by canonical frames.

    Attributes:
        name: In tables.
        solver: Matches part graphs.
        graphs: Parameters of the part graphs.
        landing: How the point is found on the matched part.
        voters: How many of the best matches vote on the part (`graft.contact.agree`); 1 takes the best as it is.
        exchangeable: No.
    """

    name: str = "graft"
    solver: Solver = field(default_factory=UFGW)
    graphs: Graphs = field(default_factory=Graphs)
    landing: Landing = "codes"
    voters: int = VOTERS
    exchangeable: bool = False

    def fit(self, benchmark: Benchmark, graphs: Sequence[PartGraph]) -> GraftPredictor:
        """Keep the graphs; nothing is learned."""
        return GraftPredictor(self.solver, self.landing, self.voters, benchmark.sources, tuple(graphs))


@dataclass(frozen=True, eq=False)
class GraftPredictor:
    """graft over the graphs of a benchmark.

    Attributes:
        solver: Matches part graphs.
        landing: How the point is found on the matched part.
        voters: How many of the best matches vote on the part.
        sources: All demonstrations of the benchmark.
        graphs: Of all its subjects.
    """

    solver: Solver
    landing: Landing
    voters: int
    sources: tuple[Source, ...]
    graphs: tuple[PartGraph, ...]

    def retrieve(self, query: Query, k: int) -> list[tuple[int, Match]]:
        """Return the k best matches among the sources of a query, and which sources they are.

        They are ranked as `Library.retrieve` ranks them: by cost, ties in the order of the sources.
        """
        chosen = [self.sources[i] for i in query.sources]
        target = self.graphs[query.target]
        transports = self.solver.batch(
            [self.graphs[source.subject] for source in chosen],
            [source.demonstration.contact.part for source in chosen],
            target,
        )
        order = np.argsort([transport.cost for transport in transports], kind="stable")[:k]
        return [
            (
                query.sources[i],
                Match(
                    demonstration=chosen[i].demonstration,
                    source=self.graphs[chosen[i].subject],
                    target=target,
                    transport=transports[i],
                    cost=transports[i].cost,
                    rank=rank,
                ),
            )
            for rank, i in enumerate(order)
        ]

    def transfers(self, query: Query, k: int) -> list[TransferredContact]:
        """Return the k best contacts, for pictures: the voters in the order of their parts' votes, then the others."""
        return [done for _, done in self._ranked(query, k)]

    def predict(self, query: Query, k: int, rng: Generator) -> list[Prediction]:
        """Return the contacts transferred along the k best matches."""
        return [
            Prediction(self._landed(done), done.target_part, source, done.confidence, done.contact.approach)
            for source, done in self._ranked(query, k)
        ]

    def _ranked(self, query: Query, k: int) -> list[tuple[int, TransferredContact]]:
        """Return k contacts and the sources they come from."""
        found = self.retrieve(query, max(k, self.voters))
        origin = {match.rank: source for source, match in found}
        done = [transfer_contact(match) for _, match in found]
        ranked = agree(done[: self.voters]) + done[self.voters :]
        return [(origin[d.match.rank], d) for d in ranked[:k]]

    def _landed(self, done: TransferredContact) -> Floats:
        """Return where the contact lands (3,), by this predictor's rule."""
        if self.landing == "codes":
            return done.contact.point
        frames = done.frames.source, done.frames.target
        if self.landing == "unaligned":
            frames = (
                box_frame(done.match.source, done.source_part),
                box_frame(done.match.target, done.target_part),
            )
        carried = frames[1].to_object(frames[0].to_canonical(done.match.demonstration.contact.point))
        return closest_surface_point(done.match.target.object.parts[done.target_part], carried)[0]

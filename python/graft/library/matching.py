"""What a retrieval gives: the objects that were found, solved for their plans."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from graft.graph import PartGraph
from graft.library.shelves import Shelf
from graft.objects import Demonstration
from graft.transport import UFGW, Transport

TOGETHER = 256
"""Objects that are read and solved at a time."""


@dataclass(frozen=True, eq=False)
class Match:
    """One demonstration matched against a target.

    Attributes:
        demonstration: The source object and the contact shown on it.
        source: Its part graph, n parts.
        target: The target's part graph, m parts.
        transport: The plan (n, m) and everything the solver knows about it.
        cost: What matches are ranked by, lower is better (`Transport.cost`).
        rank: 0 for the best match of its retrieval.
    """

    demonstration: Demonstration
    source: PartGraph
    target: PartGraph
    transport: Transport
    cost: float
    rank: int = 0

    @property
    def source_part(self) -> int:
        """Index of the demonstrated part of the source."""
        return self.demonstration.contact.part


def best_matches(shelf: Shelf, solver: UFGW, graph: PartGraph, positions: Sequence[int], k: int) -> list[Match]:
    """Solve objects of a shelf against a target and return the best k; equal costs keep the library's order."""
    kept: list[Match] = []
    for first in range(0, len(positions), TOGETHER):
        read = [shelf.read(position) for position in positions[first : first + TOGETHER]]
        transports = solver.batch([g for _, g in read], [d.contact.part for d, _ in read], graph)
        kept += [Match(d, g, graph, t, t.cost) for (d, g), t in zip(read, transports, strict=True)]
        # A stable sort: what comes first in the library stays first.
        kept = sorted(kept, key=lambda match: match.cost)[:k]
    return [replace(match, rank=rank) for rank, match in enumerate(kept)]

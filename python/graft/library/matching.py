"""What a retrieval gives."""

from __future__ import annotations

from dataclasses import dataclass

from graft.graph import PartGraph
from graft.objects import Demonstration
from graft.transport import Transport


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

"""The best k objects of many packed blocks: what one block with all of them would give.

Blocks are ranked one after the other; each is told the k-th best cost so far, so that its bounds rule out what could
not be among the best any more. Equal costs are in the order of the library.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from graft.errors import InputError
from graft.graph import PartGraph, target_prior
from graft.objects import Floats, Ints
from graft.transport import PackedGraphs

Found = list[tuple[float, int]]
"""(cost, position), best first."""


@dataclass(frozen=True, eq=False)
class Query:
    """A target as the core takes it, m parts.

    Attributes:
        name: Of the object, for messages.
        extents: (m, 3) half extents in diagonals.
        relations: (m, r).
        descriptors: (m, d) or None.
        structure: (m, m) edge lengths.
        prior: (m,) masses.
        descriptor_name: Of its descriptors, or None.
    """

    name: str
    extents: Floats
    relations: Floats
    descriptors: Floats | None
    structure: Floats
    prior: Floats
    descriptor_name: str | None

    @classmethod
    def of(cls, graph: PartGraph) -> Query:
        """Return the query of a target's graph."""
        return cls(
            graph.object.name,
            np.ascontiguousarray(graph.half_extents / graph.diagonal),
            graph.relations,
            graph.descriptors,
            graph.structure,
            target_prior(graph),
            graph.descriptor_name,
        )


@dataclass(frozen=True, eq=False)
class Block:
    """Packed graphs and where they are in the library.

    Attributes:
        packed: The graphs.
        first: Position of the first.
        among: Those that may answer, rising; None for all.
    """

    packed: PackedGraphs
    first: int = 0
    among: Ints | None = None


def best(blocks: Iterable[Block], query: Query, k: int, *, bar: float = np.inf, prune: bool = True) -> Found:
    """Return the k objects that cost least, of those that cost at most `bar`.

    Raises:
        InputError: The target's descriptors are not the library's, or a parameter is out of range.
    """
    found: Found = []
    for block in blocks:
        if block.among is not None and not len(block.among):
            continue
        found = merged([found, _rank(block, query, k, bar, prune)], k)
        bar = found[-1][0] if len(found) == k else bar
    return found


def merged(several: Iterable[Found], k: int) -> Found:
    """Return the k best of several answers; ties go to the lower position."""
    return sorted(pair for some in several for pair in some)[:k]


def _rank(block: Block, query: Query, k: int, bar: float, prune: bool) -> Found:
    packed = block.packed
    described = packed.descriptors is not None and query.descriptors is not None
    if described and packed.descriptor_name != query.descriptor_name:
        raise InputError(
            f"descriptors: expected {packed.descriptor_name} for {query.name}, got {query.descriptor_name}"
        )
    ranked = packed.rank_arrays(
        query.extents,
        query.relations,
        query.descriptors if described else None,
        query.structure,
        query.prior,
        k,
        bar=bar,
        among=block.among,
        prune=prune,
    )
    return list(zip(ranked.costs.tolist(), (ranked.indices + block.first).tolist(), strict=True))

"""Part graphs packed for retrieval: one target against all of them, the best k exactly, most never solved.

    packed = PackedGraphs.pack(graphs, demonstrated_parts, solver)
    ranked = packed.rank(target, k=5)          # indices into `graphs`, best first

A lower bound of every graph's cost comes from its features alone, in single precision; graphs are solved in the order
of their bounds until no bound left is below the k-th best cost, so the answer is that of solving all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from graft import _core
from graft.errors import InputError
from graft.graph import PartGraph, source_mass, target_prior
from graft.objects import Floats
from graft.transport.graphs import UFGW

LANES = 32
"""Parts that lie side by side in the data that bounds read (16 single-precision numbers a register, two registers)."""


CHUNK = 2048
"""Blocks that are laid out at a time, so that packing a large library needs little memory beside it."""


@dataclass(frozen=True, eq=False)
class Ranked:
    """The best graphs of a library for one target.

    Attributes:
        indices: (k,) positions in the library, least cost first; equal costs keep the library's order.
        costs: (k,) what `UFGW` ranks them by.
        solved: How many graphs had to be solved; the bounds ruled the others out.
    """

    indices: NDArray[np.int64]
    costs: Floats
    solved: int


@dataclass(frozen=True, eq=False)
class PackedGraphs:
    """Source graphs end to end, with p parts in all; `pack` makes them from part graphs.

    Attributes:
        offsets: (graphs + 1,) first part of every graph, then p.
        parts: (graphs,) demonstrated part of each.
        extents: (p, 3) half extents in diagonals.
        relations: (p, r) `PartGraph.relations`.
        descriptors: (p, d), or None.
        structures: (sum n^2,) edge lengths, row by row.
        masses: (p,) source masses.
        solver: What matches cost; its `cost` must be "sharp".
        descriptor_name: Model and version of the descriptors.
        hot: What bounds read: extents, unit descriptors with relations, masses as `side_by_side` lays them out;
            made from the above when not given.
    """

    offsets: NDArray[np.int64]
    parts: NDArray[np.int64]
    extents: Floats
    relations: Floats
    descriptors: Floats | None
    structures: Floats
    masses: Floats
    solver: UFGW
    descriptor_name: str | None = None
    hot: tuple[NDArray[np.float32], ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        if self.solver.cost != "sharp":
            raise InputError(f"cost: ranking packed graphs needs sharp, got {self.solver.cost}")
        if not self.hot:
            columns = ((self.extents,), (self.descriptors, self.relations), (self.masses[:, None],))
            object.__setattr__(self, "hot", tuple(side_by_side(*tables) for tables in columns))

    def __len__(self) -> int:
        return len(self.parts)

    @classmethod
    def pack(cls, graphs: Sequence[PartGraph], parts: Sequence[int], solver: UFGW) -> PackedGraphs:
        """Pack graphs with their demonstrated parts.

        Raises:
            InputError: None is given, there are not as many parts as graphs, one is no part of its graph, or
                the graphs have different descriptors.
        """
        if not graphs or len(graphs) != len(parts):
            raise InputError(f"parts: expected {max(len(graphs), 1)}, one per graph, got {len(parts)}")
        kinds = {(graph.descriptor_name, graph.descriptors is None) for graph in graphs}
        if len(kinds) > 1:
            names = ", ".join(sorted(str(name) for name, _ in kinds))
            raise InputError(f"descriptors: expected one kind in the library, got {names}")
        sizes = [len(graph.centers) for graph in graphs]
        for graph, part, size in zip(graphs, parts, sizes, strict=True):
            if not 0 <= part < size:
                raise InputError(f"parts: expected 0 to {size - 1} in {graph.object.name}, got {part}")
        described = [graph.descriptors for graph in graphs if graph.descriptors is not None]
        masses = [source_mass(graph, part, solver.saliency) for graph, part in zip(graphs, parts, strict=True)]
        return cls(
            np.concatenate(([0], np.cumsum(sizes))).astype(np.int64),
            np.array(parts, np.int64),
            np.concatenate([graph.half_extents / graph.diagonal for graph in graphs]),
            np.concatenate([graph.relations for graph in graphs]),
            np.concatenate(described) if described else None,
            np.concatenate([graph.structure for graph in graphs], axis=None),
            np.concatenate(masses),
            solver,
            graphs[0].descriptor_name,
        )

    def rank(
        self,
        target: PartGraph,
        k: int,
        *,
        bar: float = np.inf,
        among: NDArray[np.int64] | None = None,
        prune: bool = True,
    ) -> Ranked:
        """Return the k graphs that cost least to match with `target`: what solving all of them would give.

        Args:
            target: The target's part graph, described like the library or not at all.
            k: How many; fewer come back when the library has fewer.
            bar: Graphs that cost more are left out.
            among: Only these graphs, rising indices.
            prune: False solves every graph.

        Raises:
            InputError: k is not positive, the descriptors differ, or a parameter is out of range.
        """
        if k < 1:
            raise InputError(f"k: expected at least 1, got {k}")
        described = self.descriptors is not None and target.descriptors is not None
        if described and self.descriptor_name != target.descriptor_name:
            raise InputError(
                f"descriptors: expected {self.descriptor_name} for {target.object.name}, got {target.descriptor_name}"
            )
        return self.rank_arrays(
            np.ascontiguousarray(target.half_extents / target.diagonal),
            target.relations,
            target.descriptors if described else None,
            target.structure,
            target_prior(target),
            k,
            bar=bar,
            among=among,
            prune=prune,
        )

    def rank_arrays(
        self,
        extents: Floats,
        relations: Floats,
        descriptors: Floats | None,
        structure: Floats,
        prior: Floats,
        k: int,
        *,
        bar: float = np.inf,
        among: NDArray[np.int64] | None = None,
        prune: bool = True,
    ) -> Ranked:
        """Rank against a target given as arrays: (m, 3), (m, r), (m, d) or None, (m, m), (m,).

        Raises:
            InputError: An array has the wrong shape or is not finite, or a parameter is out of range.
        """
        solver = self.solver
        extents_hot, features_hot, masses_hot = self.hot
        try:
            indices, costs, solved = _core.rank_graphs(
                self.offsets, self.parts, self.extents, self.relations,
                self.descriptors, self.structures, self.masses, extents_hot, features_hot, masses_hot,
                np.ascontiguousarray(extents), np.ascontiguousarray(relations),
                None if descriptors is None else np.ascontiguousarray(descriptors),
                np.ascontiguousarray(structure), np.ascontiguousarray(prior),
                alpha=solver.alpha, tau_s=solver.tau_s, tau_t=solver.tau_t, eps=solver.eps, loss=solver.loss,
                entropy=solver.entropy, em_rate=solver.em_rate, tol=solver.tol, max_outer=solver.max_outer,
                lambda_obb=solver.lambda_obb, lambda_global=solver.lambda_global,
                lambda_relation=solver.lambda_relation, variant=solver.variant, part_weight=solver.part_weight,
                doubt_weight=solver.doubt_weight, rival_weight=solver.rival_weight, k=k,
                bar=bar, among=among, prune=prune,
            )  # fmt: skip
        except ValueError as error:
            raise InputError(str(error)) from None
        below = costs <= bar
        return Ranked(indices[below], costs[below], solved)


def side_by_side(*tables: Floats | None) -> NDArray[np.float32]:
    """Return tables (p, w) next to each other in blocks of `LANES` parts: (blocks, all w, LANES), flat.

    Of two tables the first, if there, is descriptors, whose rows are made unit vectors.
    """
    present = [table for table in tables if table is not None]
    parts, width = len(present[0]), sum(table.shape[1] for table in present)
    blocks = -(-parts // LANES)
    out = np.zeros((blocks, width, LANES), np.float32)
    for first in range(0, blocks, CHUNK):
        rows = slice(first * LANES, (first + CHUNK) * LANES)
        some = [table[rows] for table in present]
        if len(present) > 1:
            top = np.abs(some[0]).max(axis=1, keepdims=True, initial=0.0)
            unit = some[0] / np.where(top > 0, top, 1.0)
            norm = np.linalg.norm(unit, axis=1, keepdims=True)
            some[0] = unit / np.where(norm > 0, norm, 1.0)
        chunk = np.zeros((-(-len(some[0]) // LANES) * LANES, width), np.float32)
        chunk[: len(some[0])] = np.hstack(some)
        out[first : first + CHUNK] = chunk.reshape(-1, LANES, width).transpose(0, 2, 1)
    return out.ravel()

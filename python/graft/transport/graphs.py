"""The solver on part graphs: masses, feature costs and structures come from the graphs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from graft import _core
from graft.errors import InputError
from graft.graph import SALIENCY, PartGraph, source_mass, target_prior
from graft.objects import Floats
from graft.transport.costs import Cost
from graft.transport.result import Transport
from graft.transport.solver import Entropy, Loss, ufgw_batch

SMALLEST_SHARE = 1e-9
"""Shares and claims below this (a demonstrated part that goes nowhere) count as this in the ranking."""

EM_RATE = 0.4
"""The paper's lambda of the M-step."""


def claim(plan: Floats, source_part: int, target_part: int) -> float:
    """Return how much of what a target part receives comes from a source part, in [0, 1]; 0 of nothing."""
    received = float(plan[:, target_part].sum())
    return float(plan[source_part, target_part]) / received if received > 0 else 0.0


def part_shares(plan: Floats, target_mass: Floats, source_part: int) -> Floats:
    """Return how much each target part has of a source part, (m,), adding up to 1.

    In proportion to T_ij / sqrt(nu_j): half way between the plain row of the plan, which favours whatever is large
    (a body takes the handle's mass because it has room for it), and received mass for own mass, T_ij / nu_j, which
    favours whatever is tiny (a button).

    Args:
        plan: (n, m) transport plan.
        target_mass: (m,) target masses.
        source_part: Row of the plan. Of a row without mass all shares are 0.
    """
    root = np.sqrt(target_mass)
    row = np.divide(plan[source_part], root, out=np.zeros(plan.shape[1]), where=root > 0)
    shares: Floats = row / max(float(row.sum()), np.finfo(np.float64).tiny)
    return shares


def matched_part(plan: Floats, target_mass: Floats, source_part: int) -> tuple[int, float]:
    """Return the target part that a source part goes to, and its share (`part_shares`).

    Ties go to the lowest index. A source part without mass falls back to the part that receives most in all,
    with share 0.
    """
    shares = part_shares(plan, target_mass, source_part)
    part = int(np.argmax(shares if shares.any() else plan.sum(axis=0)))
    return part, float(shares[part])


@dataclass(frozen=True)
class UFGW:
    """Match part graphs by unbalanced fused Gromov-Wasserstein transport with EM target masses.

    The feature cost is::

        M_ij = lambda_obb tanh(|e_i - e_j| / 2) + lambda_global (1 - cos(f_i, f_j)) + lambda_relation (1 - r_i . r_j)

    with e half extents relative to the object's diagonal, f descriptors and r relations (`PartGraph.relations`);
    structures are the graphs' edge lengths; source masses are volumes damped by `saliency` per hop from the
    demonstrated part, the target's prior is its volumes.

    A match is ranked by the transport's cost plus three terms about the demonstrated part p, which goes to part q with
    a share of s (`matched_part`): `part_weight` M_pq, as most of a transport's cost is about bodies, which are large,
    and says little about the part that is taken; `doubt_weight` -log s, as a source that cannot tell two of the
    target's parts apart should not be the one to choose; and `rival_weight` -log c, where c is the share of q's mass
    that comes from p (`claim`), as a source with another part that resembles q more speaks against q.

    Attributes:
        alpha: Weight of the features; 1 - alpha weighs the structure (POT's alpha is the opposite).
        tau_s: Price of a source marginal other than the source masses; 0 frees it, inf fixes it.
        tau_t: Price of a target marginal other than the target masses.
        eps: Weight of the entropy.
        loss: "square" or "absolute".
        entropy: "relative", "plain" or "unit".
        em_rate: Share of the received mass in the M-step; None switches EM off.
        saliency: gamma of the source masses.
        lambda_obb: Weight of the boxes in M.
        lambda_global: Weight of the descriptors in M; without descriptors their term is dropped, the
            weights stay.
        lambda_relation: Weight of the relations in M; 0 is the paper's.
        part_weight: Weight of the demonstrated part's own feature cost in the ranking; 0 is the paper's.
        doubt_weight: Weight of -log share in the ranking; 0 is the paper's.
        rival_weight: Weight of -log claim in the ranking; 0 is the paper's.
        variant: "graft", or "paper" for the literal sigmoid of the extents' distance and cos, the latter plus 1 to be
            a cost.
        cost: What transports are ranked by, see `graft.transport.ufgw`.
        tol: Relative L1 change that counts as settled.
        max_outer: Linearisations at most.
        threads: 0 takes one per core; the results do not depend on it.
    """

    alpha: float = 0.5
    tau_s: float = 1.0
    tau_t: float = 1.0
    eps: float = 0.05
    loss: Loss = "square"
    entropy: Entropy = "relative"
    em_rate: float | None = EM_RATE
    saliency: float = SALIENCY
    lambda_obb: float = 1.0
    lambda_global: float = 1.0
    lambda_relation: float = 1.0
    part_weight: float = 0.3
    doubt_weight: float = 0.1
    rival_weight: float = 0.2
    variant: Literal["graft", "paper"] = "graft"
    cost: Cost = "sharp"
    tol: float = 1e-6
    max_outer: int = 200
    threads: int = 0

    def __call__(self, source: PartGraph, target: PartGraph, source_part: int) -> Transport:
        """Match one source, demonstrated at `source_part`, against a target.

        Raises:
            InputError: `source_part` is no part of the source, the graphs' descriptors differ, or a
                parameter is out of range.
        """
        return self.batch([source], [source_part], target)[0]

    def batch(self, sources: Sequence[PartGraph], source_parts: Sequence[int], target: PartGraph) -> list[Transport]:
        """Match many sources against one target, in order.

        Raises:
            InputError: As `__call__`, or as many parts as sources are not given.
        """
        if len(sources) != len(source_parts):
            raise InputError(f"source_parts: expected {len(sources)}, one per source, got {len(source_parts)}")
        for source, part in zip(sources, source_parts, strict=True):
            if not 0 <= part < len(source.centers):
                last = len(source.centers) - 1
                raise InputError(f"source_part: expected 0 to {last} in {source.object.name}, got {part}")
        if not sources:
            return []
        return self.solve(sources, source_parts, target, [target_prior(target)] * len(sources))

    def solve(
        self,
        sources: Sequence[PartGraph],
        source_parts: Sequence[int],
        target: PartGraph,
        target_masses: Sequence[Floats],
    ) -> list[Transport]:
        """Match many sources against one target whose masses (m,), with EM its priors, are given for every source."""
        features = self.features(sources, target)
        self_features = None
        if self.cost == "debiased":
            own_target = self.features([target], target)[0]
            self_features = [(self.features([source], source)[0], own_target) for source in sources]
        transports = ufgw_batch(
            features,
            [source.structure for source in sources],
            [target.structure] * len(sources),
            [source_mass(s, part, self.saliency) for s, part in zip(sources, source_parts, strict=True)],
            target_masses,
            alpha=self.alpha,
            tau_s=self.tau_s,
            tau_t=self.tau_t,
            eps=self.eps,
            loss=self.loss,
            entropy=self.entropy,
            em_rate=self.em_rate,
            cost=self.cost,
            self_features=self_features,
            tol=self.tol,
            max_outer=self.max_outer,
            threads=self.threads,
        )
        return [
            self.ranked(transport, matrix, part)
            for transport, matrix, part in zip(transports, features, source_parts, strict=True)
        ]

    def ranked(self, transport: Transport, features: Floats, source_part: int) -> Transport:
        """Return the transport with what it says of the demonstrated part in its ranking cost and terms."""
        part, share = matched_part(transport.plan, transport.target_mass, source_part)
        own = self.part_weight * float(features[source_part, part])
        doubt = -self.doubt_weight * float(np.log(max(share, SMALLEST_SHARE)))
        claimed = claim(transport.plan, source_part, part)
        rivals = -self.rival_weight * float(np.log(max(claimed, SMALLEST_SHARE)))
        terms = {**transport.terms, "part": own, "doubt": doubt, "rivals": rivals}
        return replace(transport, cost=transport.cost + own + doubt + rivals, terms=terms)

    def features(self, sources: Sequence[PartGraph], target: PartGraph) -> list[Floats]:
        """Return the feature cost M (n_k, m) of every source against the target.

        Raises:
            InputError: Both sides have descriptors, of different names or dimensions.
        """
        described = [_described(source, target) for source in sources]
        costs: list[Floats] = [np.empty(0)] * len(sources)
        for use in (True, False):
            chosen = [k for k, d in enumerate(described) if d == use]
            if not chosen:
                continue
            try:
                stacked = _core.feature_costs(
                    np.concatenate([_relative_extents(sources[k]) for k in chosen]),
                    np.concatenate([sources[k].relations for k in chosen]),
                    np.concatenate([_descriptors(sources[k]) for k in chosen]) if use else None,
                    _relative_extents(target),
                    target.relations,
                    _descriptors(target) if use else None,
                    lambda_obb=self.lambda_obb,
                    lambda_global=self.lambda_global,
                    lambda_relation=self.lambda_relation,
                    variant=self.variant,
                )
            except ValueError as error:
                raise InputError(str(error)) from None
            ends = np.cumsum([len(sources[k].centers) for k in chosen])[:-1]
            for k, matrix in zip(chosen, np.split(stacked, ends), strict=True):
                costs[k] = matrix
        return costs


def _relative_extents(graph: PartGraph) -> Floats:
    """Return the half extents (n, 3) in diagonals of the object."""
    return np.ascontiguousarray(graph.half_extents / graph.diagonal, np.float64)


def _descriptors(graph: PartGraph) -> Floats:
    """Return the descriptors (n, d) of a graph that has some."""
    return np.ascontiguousarray(graph.descriptors, np.float64)


def _described(source: PartGraph, target: PartGraph) -> bool:
    """Return whether both graphs have descriptors, which must then be the same ones."""
    if source.descriptors is None or target.descriptors is None:
        return False
    names = [
        f"{graph.descriptor_name} ({graph.descriptors.shape[1]}-d)"
        for graph in (source, target)
        if graph.descriptors is not None
    ]
    if names[0] != names[1]:
        raise InputError(
            f"descriptors: expected one kind, got {names[0]} for {source.object.name} "
            f"and {names[1]} for {target.object.name}"
        )
    return True

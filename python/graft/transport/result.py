"""What the solver returns: one transport, or a batch of them held in packed arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import overload

import numpy as np
from numpy.typing import NDArray

from graft.objects import Floats

TERMS = ("structure", "feature", "marginal_source", "marginal_target", "entropy", "prior")
"""Weighted terms: the first five sum to F, all six to J."""


@dataclass(frozen=True, eq=False, slots=True)
class Transport:
    """A transport plan and what the solver knows about it.

    Attributes:
        plan: (n, m) T, masses.
        source_mass: (n,) mu, as given.
        target_mass: (m,) nu: as given, with EM as estimated.
        f: (n,) source potential; T = R exp((f_i + g_j - C_ij) / eps) at a fixed point, where
            C = (1-alpha) C_GW(T) + alpha M. 0 for nodes without mass.
        g: (m,) target potential.
        terms: Weighted terms of the objective by name (`TERMS`).
        objective: F at the plan.
        cost: What matches are ranked by, lower is better.
        n_iters: Linearisations.
        n_sweeps: Sinkhorn sweeps.
        converged: Whether plan, target masses and marginals settled to the tolerance.
        history: F (with EM: J) at the start and after every iteration, when asked for.
    """

    plan: Floats
    source_mass: Floats
    target_mass: Floats
    f: Floats
    g: Floats
    terms: Mapping[str, float]
    objective: float
    cost: float
    n_iters: int
    n_sweeps: int
    converged: bool
    history: Floats | None = None


@dataclass(frozen=True, eq=False)
class Transports(Sequence[Transport]):
    """The transports of k pairs: a sequence that makes each `Transport` when it is looked at.

    Attributes:
        sizes: (k, 2) nodes of source and target.
        plans: All plans end to end; pair i's has `sizes[i].prod()` numbers.
        source_masses: All mu end to end.
        target_masses: All nu end to end.
        f: All source potentials end to end.
        g: All target potentials end to end.
        terms: (k, 6) weighted terms in the order of `TERMS`.
        cost: (k,) what matches are ranked by.
        n_iters: (k,) linearisations.
        n_sweeps: (k,) sweeps.
        converged: (k,) bool.
        histories: All histories end to end, and their ends; None when not asked for.
    """

    sizes: NDArray[np.int64]
    plans: Floats
    source_masses: Floats
    target_masses: Floats
    f: Floats
    g: Floats
    terms: Floats
    cost: Floats
    n_iters: NDArray[np.int64]
    n_sweeps: NDArray[np.int64]
    converged: NDArray[np.bool_]
    histories: tuple[Floats, NDArray[np.int64]] | None = None

    def __post_init__(self) -> None:
        rows, cols = self.sizes[:, 0], self.sizes[:, 1]
        ends = [np.concatenate(([0], np.cumsum(x))) for x in (rows, cols, rows * cols)]
        object.__setattr__(self, "_ends", ends)

    @property
    def objective(self) -> Floats:
        """(k,) F of every pair."""
        total: Floats = self.terms[:, :5].sum(axis=1)
        return total

    def __len__(self) -> int:
        return len(self.sizes)

    @overload
    def __getitem__(self, k: int) -> Transport: ...
    @overload
    def __getitem__(self, k: slice) -> list[Transport]: ...
    def __getitem__(self, k: int | slice) -> Transport | list[Transport]:
        if isinstance(k, slice):
            return [self[i] for i in range(*k.indices(len(self)))]
        if not -len(self) <= k < len(self):
            raise IndexError(f"expected an index below {len(self)}, got {k}")
        k %= len(self)
        rows, cols, cells = (slice(int(e[k]), int(e[k + 1])) for e in self._ends)  # type: ignore[attr-defined]
        history = None
        if self.histories is not None:
            numbers, ends = self.histories
            history = numbers[ends[k] : ends[k + 1]].copy()
        terms = self.terms[k].tolist()
        return Transport(
            # Copies, so that a kept plan does not keep the whole batch.
            plan=self.plans[cells].reshape(self.sizes[k]).copy(),
            source_mass=self.source_masses[rows].copy(),
            target_mass=self.target_masses[cols].copy(),
            f=self.f[rows].copy(),
            g=self.g[cols].copy(),
            terms=named(terms),
            objective=sum(terms[:5]),
            cost=float(self.cost[k]),
            n_iters=int(self.n_iters[k]),
            n_sweeps=int(self.n_sweeps[k]),
            converged=bool(self.converged[k]),
            history=history,
        )


def named(terms: Sequence[float]) -> Mapping[str, float]:
    """Return the six terms by name, read-only."""
    return MappingProxyType(dict(zip(TERMS, terms, strict=True)))

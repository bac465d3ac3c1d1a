"""The solver on plain matrices.

The objective over plans T (n, m), with KL(p|q) = sum p log(p/q) - p + q:

    F(T) = (1-alpha) 1/2 sum loss(A_ii', B_jj') T_ij T_i'j' + alpha <M, T>
           + tau_s KL(T1 | mu) + tau_t KL(T'1 | nu) + eps KL(T | mu nu')

`alpha` weighs the features and 1 - alpha the structure, as in the paper. POT's alpha is the opposite: it
weighs the structure. With EM the target masses move too, nu <- (1-em_rate) prior + em_rate T'1, which
minimises J = F + eta KL(prior | nu), eta = (tau_t + eps) (1-em_rate) / em_rate, exactly; F (with EM: J)
never rises.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from graft import _core
from graft.errors import InputError
from graft.objects import Floats

Loss = Literal["square", "absolute"]
"""How structures are compared: (a - b)^2, or |a - b| (the paper's literal l2 norm of a scalar; n^2 m^2
work)."""

Entropy = Literal["relative", "plain", "unit"]
"""eps KL(T | mu nu'), which splitting a node leaves alone; eps sum T log T (the paper's -eps H); eps KL(T
| 1)."""

Cost = Literal["sharp", "objective", "paper", "debiased"]
"""What `Transport.cost` is; see `ufgw`."""

TERMS = ("structure", "feature", "marginal_source", "marginal_target", "entropy", "prior")
"""Weighted terms: the first five sum to F, all six to J."""

_COSTS = ("sharp", "objective", "paper", "debiased")


@dataclass(frozen=True, eq=False)
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


def ufgw(
    M: ArrayLike,
    A: ArrayLike,
    B: ArrayLike,
    mu: ArrayLike,
    nu: ArrayLike,
    *,
    alpha: float = 0.5,
    tau_s: float = 1.0,
    tau_t: float = 1.0,
    eps: float = 0.05,
    loss: Loss = "square",
    entropy: Entropy = "relative",
    em_rate: float | None = None,
    prior: ArrayLike | None = None,
    start: ArrayLike | None = None,
    cost: Cost = "sharp",
    self_features: tuple[ArrayLike, ArrayLike] | None = None,
    tol: float = 1e-6,
    max_outer: int = 200,
    history: bool = False,
) -> Transport:
    """Transport the nodes of one weighted graph to those of another.

    Args:
        M: (n, m) feature cost, >= 0.
        A: (n, n) source structure, e.g. distances; need not be symmetric.
        B: (m, m) target structure.
        mu: (n,) source masses, >= 0; a node of mass 0 gets a row of zeros.
        nu: (m,) target masses, >= 0; a node of mass 0 gets a column of zeros.
        alpha: Weight of the features in [0, 1]; 1 - alpha weighs the structure (POT's alpha is the opposite).
        tau_s: Price of a source marginal other than mu; 0 leaves it free, inf fixes it.
        tau_t: Price of a target marginal other than nu; 0 leaves it free, inf fixes it.
        eps: Weight of the entropy, > 0.
        loss: "square" or "absolute".
        entropy: "relative", "plain" or "unit".
        em_rate: Share of T'1 in the M-step, in [0, 1); None leaves nu alone. With tau_t = inf, and with a
            rate of 0, the masses are the prior.
        prior: (m,) what EM pulls the target masses to; nu if None. Read only with EM; a node without prior
            mass then gets a column of zeros.
        start: (n, m) plan to start from, >= 0; mu nu' / sqrt(sum mu sum nu) if None.
        cost: "sharp", F without the entropy, comparable across sizes; "objective", F; "paper", the paper's
            equation 2, sharp + eps sum T log T; "debiased", F(s,t) - F(s,s)/2 - F(t,t)/2
            + eps/2 (sum mu - sum nu)^2, which needs `self_features` and the relative entropy.
        self_features: M of the source with itself (n, n) and of the target with itself (m, m).
        tol: Relative L1 change at which plan, target masses and marginals count as settled.
        max_outer: Linearisations at most.
        history: Keep the objective of every iteration.

    Raises:
        InputError: An argument has the wrong shape, is empty, negative, not finite or out of range; the
            message names it.
    """
    return ufgw_batch(
        [M],
        [A],
        [B],
        [mu],
        [nu],
        alpha=alpha,
        tau_s=tau_s,
        tau_t=tau_t,
        eps=eps,
        loss=loss,
        entropy=entropy,
        em_rate=em_rate,
        prior=None if prior is None else [prior],
        start=None if start is None else [start],
        cost=cost,
        self_features=None if self_features is None else [self_features],
        tol=tol,
        max_outer=max_outer,
        history=history,
    )[0]


def ufgw_batch(
    M: Sequence[ArrayLike],
    A: Sequence[ArrayLike],
    B: Sequence[ArrayLike],
    mu: Sequence[ArrayLike],
    nu: Sequence[ArrayLike],
    *,
    alpha: float = 0.5,
    tau_s: float = 1.0,
    tau_t: float = 1.0,
    eps: float = 0.05,
    loss: Loss = "square",
    entropy: Entropy = "relative",
    em_rate: float | None = None,
    prior: Sequence[ArrayLike] | None = None,
    start: Sequence[ArrayLike] | None = None,
    cost: Cost = "sharp",
    self_features: Sequence[tuple[ArrayLike, ArrayLike]] | None = None,
    tol: float = 1e-6,
    max_outer: int = 200,
    history: bool = False,
    threads: int = 0,
) -> list[Transport]:
    """Solve many pairs, of any sizes, in one call that releases the GIL.

    Args:
        M: One feature cost per pair, (n_k, m_k); the other sequences likewise. See `ufgw` for all other
            arguments.
        A: Source structures.
        B: Target structures.
        mu: Source masses.
        nu: Target masses.
        alpha: See `ufgw`.
        tau_s: See `ufgw`.
        tau_t: See `ufgw`.
        eps: See `ufgw`.
        loss: See `ufgw`.
        entropy: See `ufgw`.
        em_rate: See `ufgw`.
        prior: Priors, or None.
        start: Plans to start from, or None.
        cost: See `ufgw`.
        self_features: Pairs of self costs, or None.
        tol: See `ufgw`.
        max_outer: See `ufgw`.
        history: See `ufgw`.
        threads: How many threads; 0 takes one per core. The results do not depend on it.

    Returns:
        One transport per pair, in order; each is what `ufgw` gives for that pair.

    Raises:
        InputError: Sequences of different lengths, or an argument as in `ufgw`; the message names argument
            and pair.
    """
    pairs = len(M)
    for name, sequence in (("A", A), ("B", B), ("mu", mu), ("nu", nu), ("prior", prior), ("start", start)):
        if sequence is not None and len(sequence) != pairs:
            raise InputError(f"{name}: expected {pairs} arrays, one per M, got {len(sequence)}")
    if cost not in _COSTS:
        raise InputError(f"cost: expected one of {', '.join(_COSTS)}, got {cost}")
    if max_outer < 1:
        raise InputError(f"max_outer: expected at least 1, got {max_outer}")
    if threads < 0:
        raise InputError(f"threads: expected 0 or more, got {threads}")
    if not pairs:
        return []
    mus = [_array("mu", x, None, k, pairs) for k, x in enumerate(mu)]
    nus = [_array("nu", x, None, k, pairs) for k, x in enumerate(nu)]
    sizes = [(len(s), len(t)) for s, t in zip(mus, nus, strict=True)]
    shapes: dict[str, list[tuple[int, ...]]] = {
        "M": [(n, m) for n, m in sizes],
        "A": [(n, n) for n, _ in sizes],
        "B": [(m, m) for _, m in sizes],
        "prior": [(m,) for _, m in sizes],
        "start": [(n, m) for n, m in sizes],
    }

    def packed(name: str, arrays: Sequence[ArrayLike]) -> Floats:
        checked = [_array(name, x, shapes[name][k], k, pairs).ravel() for k, x in enumerate(arrays)]
        return np.concatenate(checked)

    try:
        plans, masses, fs, gs, terms, histories, lengths, n_iters, n_sweeps, converged = _core.ufgw_batch(
            np.array(sizes, np.int64),
            packed("M", M),
            packed("A", A),
            packed("B", B),
            np.concatenate(mus),
            np.concatenate(nus),
            None if prior is None else packed("prior", prior),
            None if start is None else packed("start", start),
            alpha=alpha,
            tau_s=tau_s,
            tau_t=tau_t,
            eps=eps,
            loss=loss,
            entropy=entropy,
            em_rate=em_rate,
            tol=tol,
            max_outer=max_outer,
            threads=threads,
        )
    except ValueError as error:
        raise InputError(str(error)) from None

    rows = np.cumsum([0, *(n for n, _ in sizes)])
    cols = np.cumsum([0, *(m for _, m in sizes)])
    cells = np.cumsum([0, *(n * m for n, m in sizes)])
    steps = np.cumsum([0, *lengths])
    objectives = terms[:, :5].sum(axis=1)
    split = [plans[cells[k] : cells[k + 1]].reshape(size) for k, size in enumerate(sizes)]
    masses_of = [masses[cols[k] : cols[k + 1]] for k in range(pairs)]
    if cost == "objective":
        costs = objectives
    elif cost == "debiased":
        selves = _self_objectives(
            A,
            B,
            mus,
            masses_of,
            self_features,
            entropy,
            alpha,
            tau_s,
            tau_t,
            eps,
            loss,
            tol,
            max_outer,
            threads,
        )
        gaps = np.array([s.sum() - t.sum() for s, t in zip(mus, masses_of, strict=True)])
        costs = objectives - selves / 2 + eps / 2 * gaps**2
    else:
        costs = terms[:, :4].sum(axis=1)
        if cost == "paper":
            costs = costs + eps * np.array([_negative_entropy(plan) for plan in split])
    return [
        Transport(
            plan=split[k].copy(),
            source_mass=mus[k],
            target_mass=masses_of[k].copy(),
            f=fs[rows[k] : rows[k + 1]].copy(),
            g=gs[cols[k] : cols[k + 1]].copy(),
            terms=MappingProxyType(dict(zip(TERMS, terms[k].tolist(), strict=True))),
            objective=float(objectives[k]),
            cost=float(costs[k]),
            n_iters=int(n_iters[k]),
            n_sweeps=int(n_sweeps[k]),
            converged=bool(converged[k]),
            history=histories[steps[k] : steps[k + 1]].copy() if history else None,
        )
        for k in range(pairs)
    ]


def _array(name: str, value: ArrayLike, shape: tuple[int, ...] | None, pair: int, pairs: int) -> Floats:
    """Return `value` as a C-contiguous float64 copy of the given shape (None: any vector)."""
    where = f" (pair {pair})" if pairs > 1 else ""
    expected = "a vector of numbers" if shape is None else f"numbers of shape {shape}"
    try:
        array = np.array(value, np.float64, order="C")
    except (TypeError, ValueError):
        raise InputError(f"{name}: expected {expected}, got {type(value).__name__}{where}") from None
    if array.ndim != 1 if shape is None else array.shape != shape:
        raise InputError(f"{name}: expected {expected}, got shape {array.shape}{where}")
    return array


def _negative_entropy(plan: Floats) -> float:
    """Return sum T log T with 0 log 0 = 0."""
    positive = plan[plan > 0]
    return float(positive @ np.log(positive))


def _self_objectives(
    A: Sequence[ArrayLike],
    B: Sequence[ArrayLike],
    mu: Sequence[Floats],
    nu: Sequence[Floats],
    self_features: Sequence[tuple[ArrayLike, ArrayLike]] | None,
    entropy: Entropy,
    alpha: float,
    tau_s: float,
    tau_t: float,
    eps: float,
    loss: Loss,
    tol: float,
    max_outer: int,
    threads: int,
) -> Floats:
    """Return F(s,s) + F(t,t) of every pair, t with the masses EM found, started from the identity.

    Source and target marginals of a self transport are priced alike: the source's with tau_s, the target's
    with tau_t.
    """
    if self_features is None or len(self_features) != len(mu):
        got = "none" if self_features is None else len(self_features)
        raise InputError(f"self_features: cost='debiased' needs {len(mu)} pairs of matrices, got {got}")
    if entropy != "relative":
        raise InputError(f"entropy: cost='debiased' needs relative, got {entropy}")
    total = np.zeros(len(mu))
    sides = (([f[0] for f in self_features], A, mu, tau_s), ([f[1] for f in self_features], B, nu, tau_t))
    for features, structure, mass, tau in sides:
        own = ufgw_batch(
            features,
            structure,
            structure,
            mass,
            mass,
            alpha=alpha,
            tau_s=tau,
            tau_t=tau,
            eps=eps,
            loss=loss,
            start=[np.diag(x) for x in mass],
            tol=tol,
            max_outer=max_outer,
            threads=threads,
        )
        total += [transport.objective for transport in own]
    return total

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

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from graft import _core
from graft.errors import InputError
from graft.transport import costs
from graft.transport.costs import Cost
from graft.transport.pairs import Pairs, array
from graft.transport.result import Transport, Transports, named

Loss = Literal["square", "absolute"]
"""How structures are compared: (a - b)^2, or |a - b| (the paper's literal l2 norm of a scalar; n^2 m^2
work)."""

Entropy = Literal["relative", "plain", "unit"]
"""eps KL(T | mu nu'), which splitting a node leaves alone; eps sum T log T (the paper's -eps H); eps KL(T
| 1)."""

Precision = Literal["f64", "f32"]
"""Floats of the iteration over small pairs. "f32" is twice as fast and good to about 1e-5; pairs that it cannot hold or
settle are solved again in "f64"."""


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
    start_g: ArrayLike | None = None,
    n_init: int = 1,
    seed: int = 0,
    precision: Precision = "f64",
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
        eps: Weight of the entropy, at least 1e-9.
        loss: "square" or "absolute".
        entropy: "relative", "plain" or "unit".
        em_rate: Share of T'1 in the M-step, in [0, 1); None leaves nu alone. With tau_t = inf, and with a
            rate of 0, the masses are the prior.
        prior: (m,) what EM pulls the target masses to; nu if None. Read only with EM; a node without prior
            mass then gets a column of zeros.
        start: (n, m) plan to start from, >= 0; mu nu' / sqrt(sum mu sum nu) if None.
        start_g: (m,) target potential to start from, e.g. `Transport.g` of a similar pair; 0 if None. (The source's
            follows from it.)
        n_init: How many starts; those after the first are random plans. The lowest objective wins.
        seed: Of the random starts.
        precision: "f64" or "f32".
        cost: "sharp", "objective", "paper" or "debiased", see `graft.transport.costs.Cost`; "debiased" needs
            `self_features` and the relative entropy.
        self_features: M of the source with itself (n, n) and of the target with itself (m, m).
        tol: Relative L1 change at which plan, target masses and marginals count as settled.
        max_outer: Linearisations at most.
        history: Keep the objective of every iteration.

    Raises:
        InputError: An argument has the wrong shape, is empty, negative, not finite or out of range; the
            message names it.
    """
    if cost == "debiased":
        return ufgw_batch(
            [M], [A], [B], [mu], [nu], alpha=alpha, tau_s=tau_s, tau_t=tau_t, eps=eps, loss=loss, entropy=entropy,
            em_rate=em_rate, prior=None if prior is None else [prior], start=None if start is None else [start],
            start_g=None if start_g is None else [start_g], n_init=n_init, seed=seed, precision=precision,
            cost=cost, self_features=None if self_features is None else [self_features], tol=tol,
            max_outer=max_outer, history=history,
        )[0]  # fmt: skip
    costs.check(cost)
    _check_counts(max_outer, n_init, seed)
    source_mass, target_mass = array("mu", mu, None), array("nu", nu, None)
    n, m = len(source_mass), len(target_mass)
    try:
        plan, masses, f, g, terms, values, n_iters, n_sweeps, converged = _core.ufgw_pair(
            array("M", M, (n, m)),
            array("A", A, (n, n)),
            array("B", B, (m, m)),
            source_mass,
            target_mass,
            None if prior is None else array("prior", prior, (m,)),
            None if start is None else array("start", start, (n, m)),
            None if start_g is None else array("start_g", start_g, (m,)),
            alpha,
            tau_s,
            tau_t,
            eps,
            loss,
            entropy,
            em_rate,
            tol,
            max_outer,
            n_init,
            seed,
            precision,
            history,
        )
    except ValueError as error:
        raise InputError(str(error)) from None
    objective = sum(terms[:5])
    if cost == "sharp":
        value = sum(terms[:4])
    elif cost == "objective":
        value = objective
    else:
        value = sum(terms[:4]) + eps * costs.negative_entropy(plan)
    # The masses are the caller's array: kept apart from what becomes of it.
    return Transport(
        plan, source_mass.copy(), masses, f, g, named(terms), objective, value, n_iters, n_sweeps, converged,
        values if history else None,
    )  # fmt: skip


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
    start_g: Sequence[ArrayLike] | None = None,
    n_init: int = 1,
    seed: int = 0,
    precision: Precision = "f64",
    cost: Cost = "sharp",
    self_features: costs.SelfFeatures | None = None,
    tol: float = 1e-6,
    max_outer: int = 200,
    history: bool = False,
    threads: int = 0,
) -> Transports:
    """Solve many pairs, of any sizes, in one call that releases the GIL.

    Takes sequences of what `ufgw` takes, one entry per pair: M of (n_k, m_k) and so on. Where the arrays lie end to
    end already, `ufgw_packed` saves their packing.

    Returns:
        One transport per pair, in order; each is what `ufgw` gives for that pair, to the last bit. Random starts
        (`n_init`) differ from pair to pair.

    Raises:
        InputError: Sequences of different lengths, or an argument as in `ufgw`; the message names argument
            and pair.
    """
    pairs = Pairs.pack(M, A, B, mu, nu, prior, start, start_g)
    return ufgw_packed(
        pairs, alpha=alpha, tau_s=tau_s, tau_t=tau_t, eps=eps, loss=loss, entropy=entropy, em_rate=em_rate,
        n_init=n_init, seed=seed, precision=precision, cost=cost, self_features=self_features, tol=tol,
        max_outer=max_outer, history=history, threads=threads,
    )  # fmt: skip


def ufgw_packed(
    pairs: Pairs,
    *,
    alpha: float = 0.5,
    tau_s: float = 1.0,
    tau_t: float = 1.0,
    eps: float = 0.05,
    loss: Loss = "square",
    entropy: Entropy = "relative",
    em_rate: float | None = None,
    n_init: int = 1,
    seed: int = 0,
    precision: Precision = "f64",
    cost: Cost = "sharp",
    self_features: costs.SelfFeatures | None = None,
    tol: float = 1e-6,
    max_outer: int = 200,
    history: bool = False,
    threads: int = 0,
    instructions: Literal["best", "avx512", "avx2", "baseline"] = "best",
) -> Transports:
    """Solve packed pairs; see `ufgw` for the options and `ufgw_batch` for what comes back.

    Args:
        pairs: See `Pairs`.
        alpha: See `ufgw`, as all below but the last two.
        tau_s: See `ufgw`.
        tau_t: See `ufgw`.
        eps: See `ufgw`.
        loss: See `ufgw`.
        entropy: See `ufgw`.
        em_rate: See `ufgw`.
        n_init: See `ufgw`.
        seed: See `ufgw`.
        precision: See `ufgw`.
        cost: See `ufgw`.
        self_features: One pair of self costs per pair, or None.
        tol: See `ufgw`.
        max_outer: See `ufgw`.
        history: See `ufgw`.
        threads: How many threads; 0 takes one per core. The results do not depend on it.
        instructions: The most that may be used of the processor; the results do not depend on it either.

    Raises:
        InputError: An array's length contradicts `pairs.sizes`, or an argument as in `ufgw`.
    """
    costs.check(cost)
    _check_counts(max_outer, n_init, seed)
    if threads < 0:
        raise InputError(f"threads: expected 0 or more, got {threads}")
    if not len(pairs):
        none, counts = np.empty(0), np.empty(0, np.int64)
        return Transports(
            pairs.sizes, none, none, none, none, none, np.empty((0, 6)), none, counts, counts, np.empty(0, np.bool_)
        )
    sides = costs.self_sides(self_features, len(pairs), entropy) if cost == "debiased" else None
    try:
        plans, masses, f, g, terms, values, lengths, n_iters, n_sweeps, converged = _core.ufgw_batch(
            pairs.sizes, pairs.M, pairs.A, pairs.B, pairs.mu, pairs.nu, pairs.prior, pairs.start, pairs.start_g,
            alpha=alpha, tau_s=tau_s, tau_t=tau_t, eps=eps, loss=loss, entropy=entropy, em_rate=em_rate, tol=tol,
            max_outer=max_outer, n_init=n_init, seed=seed, precision=precision, history=history, threads=threads,
            instructions=instructions,
        )  # fmt: skip
    except ValueError as error:
        raise InputError(str(error)) from None
    rows, cols = pairs.sizes[:, 0], pairs.sizes[:, 1]
    if sides is not None:
        own = np.zeros(len(pairs))
        both = ((sides[0], pairs.A, pairs.mu, rows, tau_s), (sides[1], pairs.B, masses, cols, tau_t))
        # Source and target marginals of a self transport are priced alike, and it starts from the identity.
        for features, structure, mass, counts, tau in both:
            split = np.split(mass, np.cumsum(counts)[:-1])
            matrices = np.split(structure, np.cumsum(counts**2)[:-1])
            square = [x.reshape(k, k) for x, k in zip(matrices, counts, strict=True)]
            own += ufgw_batch(
                features, square, square, split, split, alpha=alpha, tau_s=tau, tau_t=tau, eps=eps, loss=loss,
                start=[np.diag(x) for x in split], tol=tol, max_outer=max_outer, threads=threads,
            ).objective  # fmt: skip
        edges = [np.concatenate(([0], np.cumsum(x)[:-1])) for x in (rows, cols)]
        gaps = np.add.reduceat(pairs.mu, edges[0]) - np.add.reduceat(masses, edges[1])
        ranks = terms[:, :5].sum(axis=1) - own / 2 + eps / 2 * gaps**2
    else:
        each = np.split(plans, np.cumsum(rows * cols)[:-1]) if cost == "paper" else []
        ranks = costs.plain(cost, terms, each, eps)
    ends = np.concatenate(([0], np.cumsum(lengths)))
    return Transports(
        pairs.sizes, plans, pairs.mu, masses, f, g, terms, ranks, n_iters, n_sweeps, converged,
        (values, ends) if history else None,
    )  # fmt: skip


def _check_counts(max_outer: int, n_init: int, seed: int) -> None:
    if max_outer >= 1 and n_init >= 1 and seed >= 0:
        return
    for name, value, least in (("max_outer", max_outer, 1), ("n_init", n_init, 1), ("seed", seed, 0)):
        if value < least:
            raise InputError(f"{name}: expected at least {least}, got {value}")

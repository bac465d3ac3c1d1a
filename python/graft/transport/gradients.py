"""Envelope gradients: how the optimal objective changes with the data, at a solution.

At a minimiser over the plan (and, with EM, over nu) the derivative of the optimal value is the partial derivative of
the objective with the plan held fixed, so no solver has to be differentiated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from graft.objects import Floats
from graft.transport.pairs import array
from graft.transport.result import Transport
from graft.transport.solver import Entropy, Loss


@dataclass(frozen=True, eq=False)
class Gradients:
    """Derivatives of F (with EM: J) at its minimum; exact as far as the solver converged.

    Attributes:
        M: (n, m) by the feature cost.
        A: (n, n) by the source structure, its entries varied one by one.
        B: (m, m) by the target structure.
        mu: (n,) by the source masses; 0 at nodes without mass.
        nu: (m,) by the target masses, with EM by the prior; 0 at nodes without mass.
    """

    M: Floats
    A: Floats
    B: Floats
    mu: Floats
    nu: Floats


def ufgw_gradients(
    transport: Transport,
    A: ArrayLike,
    B: ArrayLike,
    *,
    alpha: float = 0.5,
    tau_s: float = 1.0,
    tau_t: float = 1.0,
    eps: float = 0.05,
    loss: Loss = "square",
    entropy: Entropy = "relative",
    em_rate: float | None = None,
    prior: ArrayLike | None = None,
) -> Gradients:
    """Differentiate the minimum that `ufgw` found by its data.

    Args:
        transport: A converged solution; tighten `tol` for accurate gradients (their error is of its order).
        A: (n, n) source structure it was found with.
        B: (m, m) target structure.
        alpha: As given to `ufgw`, like all that follow.
        tau_s: See `ufgw`. With inf the derivative by mu is the potential's, up to one constant if both are inf.
        tau_t: See `ufgw`.
        eps: See `ufgw`.
        loss: See `ufgw`.
        entropy: See `ufgw`.
        em_rate: See `ufgw`.
        prior: (m,) prior of EM; needed when EM moved the masses.

    Raises:
        InputError: A, B or prior has the wrong shape, or the prior is missing.
    """
    T, mu, nu = transport.plan, transport.source_mass, transport.target_mass
    (n, m), u, v = T.shape, T.sum(1), T.sum(0)
    source, target = array("A", A, (n, n)), array("B", B, (m, m))
    if loss == "square":
        by_A = source * np.outer(u, u) - T @ target @ T.T
        by_B = target * np.outer(v, v) - T.T @ source @ T
    else:
        signs = np.sign(source[:, None, :, None] - target[None, :, None, :])
        by_A = np.einsum("ij,kl,ijkl->ik", T, T, signs) / 2
        by_B = -np.einsum("ij,kl,ijkl->jl", T, T, signs) / 2
    relative = eps if entropy == "relative" else 0.0
    by_mu = _by_mass(u, mu, transport.f, tau_s, relative, nu.sum())
    moved = em_rate is not None and em_rate > 0 and np.isfinite(tau_t)
    if moved:
        assert em_rate is not None
        delta = array("prior", () if prior is None else prior, (m,))
        heavy = (delta > 0) & (nu > 0)
        ratio = np.where(heavy, delta, 1.0) / np.where(heavy, nu, 1.0)
        by_nu = (tau_t + relative) * (1 - em_rate) / em_rate * np.log(ratio)
    else:
        by_nu = _by_mass(v, nu, transport.g, tau_t, relative, mu.sum())
    return Gradients(alpha * T, (1 - alpha) * by_A, (1 - alpha) * by_B, by_mu, by_nu)


def _by_mass(marginal: Floats, mass: Floats, potential: Floats, tau: float, eps: float, other: float) -> Floats:
    """Return the derivative of tau KL(marginal | mass) + eps KL(T | mass other') by mass."""
    heavy = mass > 0
    share = np.where(heavy, marginal, 0.0) / np.where(heavy, mass, 1.0)
    # A fixed marginal is a constraint, whose multiplier is the potential.
    priced = potential if np.isinf(tau) else tau * (1 - share)
    return np.where(heavy, priced + eps * (other - share), 0.0)

"""Against other solvers, closed forms and definitions."""

import numpy as np
import pytest
from scipy.special import lambertw
from ufgw_problems import four_loops, linearised, make_pair, objective

from graft.transport import ufgw

TIGHT = {"tol": 1e-11, "max_outer": 5000}


@pytest.mark.parametrize(("n", "m"), [(1, 1), (3, 5), (8, 6), (20, 15)])
@pytest.mark.parametrize("eps", [0.05, 0.5])
@pytest.mark.parametrize("tau", [(1.0, 1.0), (0.3, 4.0)])
def test_features_alone_are_pots_unbalanced_sinkhorn(ot, n, m, eps, tau):
    pair = make_pair(n * m, n, m)
    expected = ot.unbalanced.sinkhorn_unbalanced(
        pair.mu, pair.nu, pair.M, eps, tau, reg_type="kl", stopThr=1e-14, numItermax=100_000
    )
    found = ufgw(*pair.data, alpha=1.0, tau_s=tau[0], tau_t=tau[1], eps=eps, **TIGHT)
    assert found.converged
    np.testing.assert_allclose(found.plan, expected, atol=1e-10)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("alpha", [0.2, 0.7])
def test_fixed_marginals_are_a_fixed_point_of_pots_fused_gw(ot, seed, alpha):
    pair = make_pair(seed, 6, 5)
    found = ufgw(*pair.data, alpha=alpha, tau_s=np.inf, tau_t=np.inf, eps=0.05, **TIGHT)
    assert found.converged
    np.testing.assert_allclose(found.plan.sum(1), pair.mu, atol=1e-14)
    np.testing.assert_allclose(found.plan.sum(0), pair.nu, atol=1e-14)
    # POT minimises (1-a) <M,T> + a sum (..)^2 T T: its quadratic has no 1/2.
    pots_alpha = (1 - alpha) / 2 / (alpha + (1 - alpha) / 2)
    scale = alpha + (1 - alpha) / 2
    kept = ot.gromov.entropic_fused_gromov_wasserstein(
        pair.M,
        pair.A,
        pair.B,
        pair.mu,
        pair.nu,
        epsilon=0.05 / scale,
        alpha=pots_alpha,
        G0=found.plan,
        max_iter=10,
        tol=1e-13,
        stopThr=1e-14,
    )
    np.testing.assert_allclose(kept, found.plan, atol=1e-8)


def test_one_node_each_by_lambert_w():
    # t solves a + (1-alpha) l t + tau_s log(t/p) + tau_t log(t/q) + eps log(t/(p q)) = 0 with l = (A - B)^2.
    a, length, p, q, alpha, tau_s, tau_t, eps = 0.7, 2.5, 0.4, 1.7, 0.3, 0.9, 0.2, 0.05
    pull = tau_s + tau_t + eps
    base = (tau_s * np.log(p) + tau_t * np.log(q) + eps * np.log(p * q) - alpha * a) / pull
    curvature = (1 - alpha) * length**2 / pull
    expected = lambertw(curvature * np.exp(base)).real / curvature
    found = ufgw([[a]], [[length]], [[0.0]], [p], [q], alpha=alpha, tau_s=tau_s, tau_t=tau_t, eps=eps, tol=1e-13)
    assert found.converged
    np.testing.assert_allclose(found.plan[0, 0], expected, rtol=1e-12)


def test_free_marginals_have_a_closed_form():
    pair = make_pair(3)
    found = ufgw(*pair.data, alpha=1.0, tau_s=0.0, tau_t=0.0, eps=0.1)
    np.testing.assert_allclose(found.plan, np.outer(pair.mu, pair.nu) * np.exp(-pair.M / 0.1), rtol=1e-12)


@pytest.mark.parametrize("entropy", ["plain", "unit"])
def test_other_entropies_have_their_closed_forms(entropy):
    pair = make_pair(4)
    found = ufgw(*pair.data, alpha=1.0, tau_s=0.0, tau_t=0.0, eps=0.1, entropy=entropy)
    reference = np.exp(-1.0) if entropy == "plain" else 1.0
    np.testing.assert_allclose(found.plan, reference * np.exp(-pair.M / 0.1), rtol=1e-12)


@pytest.mark.parametrize("loss", ["square", "absolute"])
@pytest.mark.parametrize("symmetric", [True, False])
@pytest.mark.parametrize("entropy", ["relative", "plain", "unit"])
def test_terms_are_the_definition(loss, symmetric, entropy):
    pair = make_pair(5, 4, 3, symmetric=symmetric)
    options = {"alpha": 0.3, "tau_s": 0.8, "tau_t": 0.4, "eps": 0.07, "loss": loss, "entropy": entropy}
    found = ufgw(*pair.data, **options)
    np.testing.assert_allclose(found.objective, objective(pair, found.plan, **options), rtol=1e-12)
    np.testing.assert_allclose(
        found.terms["structure"], 0.7 / 2 * four_loops(pair.A, pair.B, found.plan, loss), rtol=1e-12
    )
    assert found.objective == pytest.approx(sum(found.terms.values()), rel=1e-14)


KKT = [
    {},
    {"alpha": 0.1},
    {"tau_s": 0.05, "tau_t": 3.0},
    {"tau_s": 0.0},
    {"tau_t": 0.0},
    {"tau_s": np.inf},
    {"tau_t": np.inf},
    {"tau_s": np.inf, "tau_t": np.inf},
    {"eps": 0.01},
    {"loss": "absolute"},
    {"entropy": "plain"},
    {"entropy": "unit"},
]


@pytest.mark.parametrize("options", KKT, ids=str)
@pytest.mark.parametrize("symmetric", [True, False])
def test_fixed_points_satisfy_the_optimality_conditions(options, symmetric):
    """T = R exp((f + g - C(T)) / eps) with C by brute force, T1 = mu exp(-f / tau_s), T'1 = nu exp(-g /
    tau_t)."""
    pair = make_pair(6, 4, 5, symmetric=symmetric)
    found = ufgw(*pair.data, **TIGHT, **options)
    assert found.converged
    eps = options.get("eps", 0.05)
    shared = {k: v for k, v in options.items() if k in ("alpha", "loss")}
    C = linearised(pair, found.plan, **shared)
    R = {"relative": np.outer(pair.mu, pair.nu), "plain": np.exp(-1.0), "unit": 1.0}[options.get("entropy", "relative")]
    np.testing.assert_allclose(
        found.plan, R * np.exp((found.f[:, None] + found.g[None] - C) / eps), rtol=1e-7, atol=1e-14
    )
    for tau, marginal, mass, potential in (
        (options.get("tau_s", 1.0), found.plan.sum(1), pair.mu, found.f),
        (options.get("tau_t", 1.0), found.plan.sum(0), pair.nu, found.g),
    ):
        if tau == 0:
            np.testing.assert_array_equal(potential, 0.0)
        else:
            np.testing.assert_allclose(marginal, mass * np.exp(-potential / tau), rtol=1e-8)


@pytest.mark.parametrize("loss", ["square", "absolute"])
def test_no_direction_descends_from_the_solution(loss):
    """Finite differences of F itself, no formula of the gradient used."""
    pair = make_pair(7, 3, 4, symmetric=False)
    options = {"alpha": 0.4, "tau_s": 0.7, "tau_t": 1.3, "eps": 0.1, "loss": loss}
    found = ufgw(*pair.data, **TIGHT, **options)
    for index in np.ndindex(found.plan.shape):
        step = np.zeros_like(found.plan)
        step[index] = 1e-4 * found.plan[index]
        up = objective(pair, found.plan + step, **options)
        down = objective(pair, found.plan - step, **options)
        assert abs(up - down) / (2 * step[index]) < 1e-6

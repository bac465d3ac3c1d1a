"""F (with EM: J) never rises, and nothing is ever NaN."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ufgw_problems import linearised, make_pair, objective, pairs, prices

from graft.transport import ufgw


def check(found, pair, *, tau_s=1.0, tau_t=1.0, eps=0.05, **_):
    """Check finiteness and descent, up to rounding of the numbers whose differences F is made of."""
    numbers = [found.plan, found.f, found.g, found.target_mass, found.history, [*found.terms.values()]]
    assert all(np.isfinite(x).all() for x in numbers)
    assert np.isfinite(found.cost)
    assert (found.plan >= 0).all()
    mass = max(found.plan.sum(), pair.mu.sum(), found.target_mass.sum())
    size = abs(found.history).max() + (eps + sum(t for t in (tau_s, tau_t) if np.isfinite(t))) * mass
    size += (pair.A.max() + pair.B.max()) ** 2 * mass**2
    assert np.diff(found.history).max(initial=0.0) <= 1e-12 * size
    assert found.history[-1] == pytest.approx(found.objective + found.terms["prior"], abs=1e-12 * size)


@settings(max_examples=150, deadline=None)
@given(
    pairs(),
    st.sampled_from([0.0, 0.1, 0.5, 1.0]),
    prices,
    prices,
    st.sampled_from([1e-4, 0.005, 0.05, 1.0, 10.0]),
    st.sampled_from(["square", "absolute"]),
    st.sampled_from(["relative", "plain", "unit"]),
    st.sampled_from([None, 0.0, 0.4, 0.9]),
)
def test_descends_and_stays_finite(pair, alpha, tau_s, tau_t, eps, loss, entropy, em_rate):
    options = {"alpha": alpha, "tau_s": tau_s, "tau_t": tau_t, "eps": eps, "loss": loss, "entropy": entropy}
    found = ufgw(*pair.data, **options, em_rate=em_rate, max_outer=30, history=True)
    check(found, pair, **options)
    if np.isinf(tau_s):
        np.testing.assert_allclose(found.plan.sum(1), pair.mu, rtol=1e-9)
    if np.isinf(tau_t):
        np.testing.assert_allclose(found.plan.sum(0), pair.nu, rtol=1e-9)


@pytest.mark.parametrize("tau", [(1.0, 1.0), (0.01, 0.01), (np.inf, 1.0), (0.0, 1.0)])
@pytest.mark.parametrize("n", [1, 6, 20])
def test_a_tiny_eps_is_solved(tau, n):
    pair = make_pair(n, n, n)
    options = {"alpha": 1.0, "tau_s": tau[0], "tau_t": tau[1], "eps": 1e-4}
    found = ufgw(*pair.data, **options, history=True)
    check(found, pair, **options)
    assert found.converged


@pytest.mark.parametrize("seed", range(8))
def test_where_the_undamped_iteration_diverges(seed):
    """Structures times ten at alpha = tau = .1: the plain fixed point iteration never settles there."""
    pair = make_pair(seed, 6, 6, scale=10.0)
    options = {"alpha": 0.1, "tau_s": 0.1, "tau_t": 0.1}
    found = ufgw(*pair.data, **options, max_outer=2000, history=True)
    check(found, pair, **options)
    assert found.converged
    # The plain iteration: solve the problem linearised at the plan (alpha = 1, the cost as features), repeat.
    plan, values = np.outer(pair.mu, pair.nu), []
    for _ in range(30):
        cost = linearised(pair, plan, alpha=0.1)
        shifted = cost - min(cost.min(), 0.0)
        plan = ufgw(shifted, *pair.data[1:], alpha=1.0, tau_s=0.1, tau_t=0.1).plan
        values.append(objective(pair, plan, **options))
    assert max(np.diff(values)) > 1e-3 or abs(values[-1] - values[-2]) > 1e-3


@pytest.mark.parametrize("mass", [1e-6, 1e6])
@pytest.mark.parametrize("em_rate", [None, 0.4])
def test_extreme_masses(mass, em_rate):
    pair = make_pair(3, mass=mass)
    check(ufgw(*pair.data, em_rate=em_rate, history=True), pair)


def test_identical_parts_are_treated_alike():
    found = ufgw(np.zeros((4, 4)), np.zeros((4, 4)), np.zeros((4, 4)), np.ones(4) / 4, np.ones(4) / 4)
    np.testing.assert_allclose(found.plan, 1 / 16, rtol=1e-12)
    assert found.converged


def test_giving_up_is_said():
    found = ufgw(*make_pair(5).data, max_outer=1, tol=1e-12)
    assert not found.converged
    assert found.n_iters == 1


def test_masses_that_underflow_leave_the_objective_finite():
    pair = make_pair(25, 2, 5, mass=1e3, symmetric=False)
    options = {"alpha": 0.0, "tau_t": 1e-3, "eps": 1e-4, "loss": "absolute"}
    found = ufgw(*pair.data, **options, max_outer=30, history=True)
    check(found, pair, **options)

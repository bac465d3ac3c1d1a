"""Large graphs and extreme numbers: finite, descending, converged or flagged."""

import numpy as np
import pytest
from test_ufgw_descent import check
from ufgw_problems import make_pair

from graft.transport import ufgw, ufgw_batch

EXTREMES = [
    {"eps": 1e-4},
    {"eps": 10.0},
    {"tau": 1e-3, "eps": 1e-3},
    {"tau": np.inf},
    {"mass": 1e-6},
    {"mass": 1e6},
    {"scale": 100.0},
    {"scale": 100.0, "eps": 1e-3, "tau": 0.1},
]


def extreme(n, *, eps=0.05, tau=1.0, mass=1.0, scale=1.0):
    """Return a pair with a few nodes without mass, and the options."""
    pair = make_pair(n, n, n - 3, scale=scale, mass=mass)
    for masses in (pair.mu, pair.nu):
        masses[::7] = 0.0
        masses *= mass / masses.sum()
    return pair, {"eps": eps, "tau_s": tau, "tau_t": tau}


def solve(n, settings, em_rate, max_outer):
    pair, options = extreme(n, **settings)
    found = ufgw(*pair.data, **options, em_rate=em_rate, max_outer=max_outer, history=True)
    check(found, pair, **options)
    np.testing.assert_array_equal(found.plan[pair.mu == 0], 0.0)
    np.testing.assert_array_equal(found.plan[:, pair.nu == 0], 0.0)
    assert found.plan.sum() > 0
    return found


@pytest.mark.parametrize("em_rate", [None, 0.4])
@pytest.mark.parametrize("settings", EXTREMES, ids=str)
@pytest.mark.parametrize("n", [80, 200, 500])
def test_large_graphs_stay_finite_and_descend(n, settings, em_rate):
    solve(n, settings, em_rate, 10 if n < 500 else 4)


@pytest.mark.parametrize("n", [100, 200])
def test_large_graphs_settle_where_they_say(n):
    found = solve(n, {}, 0.4, 200)
    assert found.converged
    pair, options = extreme(n)
    exact = ufgw(*pair.data, **options, em_rate=0.4, tol=1e-10, max_outer=2000)
    assert exact.converged
    assert np.abs(found.plan - exact.plan).sum() < 1e-5 * exact.plan.sum()


@pytest.mark.parametrize("n", [8, 40, 120])
def test_identical_parts_settle(n):
    """All nodes alike: every cost is zero and the product plan, scaled, is the solution."""
    ones = np.full(n, 1.0 / n)
    found = ufgw(np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n)), ones, ones, em_rate=0.4)
    assert found.converged
    np.testing.assert_allclose(found.plan, 1.0 / n**2, rtol=1e-9)
    assert found.objective == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("n", [6, 40])
@pytest.mark.parametrize("settings", EXTREMES, ids=str)
def test_single_precision_has_the_values_of_double(settings, n):
    """Value against value, relative to what the objective's terms are made of, where both settle."""
    drawn = [extreme(n + k, **settings) for k in range(4)]
    columns = [list(column) for column in zip(*(pair.data for pair, _ in drawn), strict=True)]
    options = drawn[0][1]
    double = ufgw_batch(*columns, **options, em_rate=0.4, max_outer=100)
    single = ufgw_batch(*columns, **options, em_rate=0.4, max_outer=100, tol=1e-5, precision="f32")
    assert np.isfinite(single.plans).all()
    both = double.converged & single.converged
    size = np.abs(double.terms).sum(axis=1) + np.array([pair.mu.sum() for pair, _ in drawn]) * options["eps"]
    assert (np.abs(single.objective - double.objective) <= 1e-4 * size)[both].all()
    # A pair that single precision left unsettled was solved in double.
    assert single.converged[double.converged].all()


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_large_pairs_have_one_answer_for_all_threads_and_neighbours(precision):
    sizes = [(30, 25), (25, 60), (3, 40), (20, 18), (64, 33), (24, 24)]
    pairs = [make_pair(k, *size) for k, size in enumerate(sizes)]
    columns = [list(column) for column in zip(*(pair.data for pair in pairs), strict=True)]
    whole = ufgw_batch(*columns, em_rate=0.4, precision=precision, threads=1)
    spread = ufgw_batch(*columns, em_rate=0.4, precision=precision, threads=3)
    np.testing.assert_array_equal(spread.plans, whole.plans)
    for pair, found in zip(pairs, whole, strict=True):
        alone = ufgw(*pair.data, em_rate=0.4, precision=precision)
        np.testing.assert_array_equal(alone.plan, found.plan)
        assert dict(alone.terms) == dict(found.terms)

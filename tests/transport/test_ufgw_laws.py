"""Laws that hold whatever the numbers: symmetry, splitting, masses, EM, batches, threads."""

import numpy as np
import pytest
from ufgw_problems import kl, make_pair, objective

from graft.transport import ufgw, ufgw_batch

TIGHT = {"tol": 1e-11, "max_outer": 5000}


@pytest.mark.parametrize("options", [{}, {"em_rate": 0.4}, {"tau_s": np.inf}, {"loss": "absolute"}], ids=str)
@pytest.mark.parametrize("symmetric", [True, False])
def test_permuting_the_nodes_permutes_the_plan(options, symmetric):
    pair = make_pair(1, 5, 6, symmetric=symmetric)
    rng = np.random.default_rng(0)
    p, q = rng.permutation(5), rng.permutation(6)
    plain = ufgw(*pair.data, **TIGHT, **options)
    mixed = ufgw(
        pair.M[np.ix_(p, q)], pair.A[np.ix_(p, p)], pair.B[np.ix_(q, q)], pair.mu[p], pair.nu[q],
        **TIGHT, **options,
    )  # fmt: skip
    np.testing.assert_allclose(mixed.plan, plain.plan[np.ix_(p, q)], atol=1e-9)
    np.testing.assert_allclose(mixed.target_mass, plain.target_mass[q], atol=1e-9)
    np.testing.assert_allclose(mixed.cost, plain.cost, rtol=1e-9)


@pytest.mark.parametrize("options", [{}, {"eps": 0.01}, {"entropy": "plain"}, {"entropy": "unit"}], ids=str)
@pytest.mark.parametrize("symmetric", [True, False])
def test_exchanging_source_and_target_transposes_the_plan(options, symmetric):
    pair = make_pair(2, 4, 6, symmetric=symmetric)
    there = ufgw(*pair.data, tau_s=0.4, tau_t=2.0, **TIGHT, **options)
    back = ufgw(pair.M.T, pair.B, pair.A, pair.nu, pair.mu, tau_s=2.0, tau_t=0.4, **TIGHT, **options)
    np.testing.assert_allclose(back.plan.T, there.plan, atol=1e-9)
    assert back.objective == pytest.approx(there.objective, rel=1e-10)
    assert back.terms["marginal_source"] == pytest.approx(there.terms["marginal_target"], rel=1e-6)


@pytest.mark.parametrize("em_rate", [None, 0.4])
def test_splitting_a_target_node_splits_its_column(em_rate):
    """Relative entropy: a part cut in two equal-looking halves carries the same mass at the same cost."""
    pair = make_pair(3, 5, 4)
    split = [0, 1, 2, 3, 3]
    nu = pair.nu[split] * np.array([1, 1, 1, 0.3, 0.7])
    whole = ufgw(*pair.data, em_rate=em_rate, **TIGHT)
    halves = ufgw(pair.M[:, split], pair.A, pair.B[np.ix_(split, split)], pair.mu, nu, em_rate=em_rate, **TIGHT)
    np.testing.assert_allclose(halves.plan[:, 3] + halves.plan[:, 4], whole.plan[:, 3], atol=1e-9)
    np.testing.assert_allclose(halves.plan[:, 4], 0.7 * whole.plan[:, 3], atol=1e-9)
    assert halves.objective == pytest.approx(whole.objective, rel=1e-10)
    assert halves.cost == pytest.approx(whole.cost, rel=1e-9)


@pytest.mark.parametrize("options", [{}, {"em_rate": 0.4}, {"entropy": "plain"}, {"tau_t": np.inf}], ids=str)
def test_nodes_without_mass_change_nothing_and_carry_nothing(options):
    pair = make_pair(4, 5, 4)
    mu, nu = pair.mu.copy(), pair.nu.copy()
    mu[2], nu[0] = 0.0, 0.0
    found = ufgw(pair.M, pair.A, pair.B, mu, nu, **TIGHT, **options)
    rows, cols = [0, 1, 3, 4], [1, 2, 3]
    small = ufgw(
        pair.M[np.ix_(rows, cols)], pair.A[np.ix_(rows, rows)], pair.B[np.ix_(cols, cols)],
        mu[rows], nu[cols], **TIGHT, **options,
    )  # fmt: skip
    np.testing.assert_array_equal(found.plan[2], 0.0)
    np.testing.assert_array_equal(found.plan[:, 0], 0.0)
    np.testing.assert_array_equal(found.plan[np.ix_(rows, cols)], small.plan)
    assert found.objective == small.objective
    assert found.target_mass[0] == 0.0


@pytest.mark.parametrize("mass", [1.0, 3.0])
@pytest.mark.parametrize("entropy", ["relative", "plain", "unit"])
def test_the_m_step_minimises_j(mass, entropy):
    """At the fixed point no other target masses give a smaller J, by finite differences of the definition."""
    rate, tau_t, eps = 0.4, 0.8, 0.1
    pair = make_pair(5, 4, 5, mass=mass)
    options = {"tau_t": tau_t, "eps": eps, "entropy": entropy}
    found = ufgw(*pair.data, em_rate=rate, **TIGHT, **options)
    assert found.converged
    eta = (tau_t + (eps if entropy == "relative" else 0.0)) * (1 - rate) / rate

    def j(nu):
        return objective(pair, found.plan, nu, **options) + eta * kl(pair.nu, nu)

    at = j(found.target_mass)
    assert at == pytest.approx(found.objective + found.terms["prior"], rel=1e-12)
    for direction in np.eye(5):
        for step in (1e-3, -1e-3):
            assert j(found.target_mass * (1 + step * direction)) > at


def test_the_m_step_is_the_papers_for_unit_source_mass():
    pair = make_pair(6)
    found = ufgw(*pair.data, em_rate=0.4, **TIGHT)
    np.testing.assert_allclose(found.target_mass, 0.6 * pair.nu + 0.4 * found.plan.sum(0), rtol=1e-8)
    assert np.abs(found.target_mass - pair.nu).max() > 1e-3


def test_em_keeps_the_prior_where_it_cannot_move():
    pair, prior = make_pair(7), np.array([0.1, 0.2, 0.3, 0.4])
    for options in ({"em_rate": 0.0}, {"em_rate": 0.4, "tau_t": np.inf}):
        found = ufgw(*pair.data, prior=prior, **options)
        np.testing.assert_array_equal(found.target_mass, prior)
        fixed = ufgw(*pair.replaced(nu=prior).data, tau_t=options.get("tau_t", 1.0))
        np.testing.assert_array_equal(found.plan, fixed.plan)


def test_identical_graphs_match_themselves():
    pair = make_pair(8, 6, 6)
    distinct = 1.0 - np.eye(6)
    found = ufgw(distinct, pair.A, pair.A, pair.mu, pair.mu, eps=0.01)
    np.testing.assert_array_equal(found.plan.argmax(1), np.arange(6))
    assert found.cost < 0.02


def test_a_solution_is_where_a_warm_start_stays():
    pair = make_pair(9)
    found = ufgw(*pair.data, **TIGHT)
    again = ufgw(*pair.data, start=found.plan, start_g=found.g, tol=1e-9)
    assert again.n_iters <= 2
    np.testing.assert_allclose(again.plan, found.plan, atol=1e-10)


def test_costs_are_what_they_say():
    pair = make_pair(10)
    found = {c: ufgw(*pair.data, cost=c) for c in ("sharp", "objective", "paper")}
    terms, plan = found["sharp"].terms, found["sharp"].plan
    assert found["sharp"].cost == pytest.approx(found["sharp"].objective - terms["entropy"], rel=1e-12)
    assert found["objective"].cost == found["objective"].objective
    assert found["paper"].cost == pytest.approx(objective(pair, plan, entropy="plain"), rel=1e-12)


def test_the_debiased_cost_of_a_graph_and_itself_vanishes():
    pair = make_pair(11, 5, 5)
    features = 1.0 - np.eye(5)
    found = ufgw(
        features, pair.A, pair.A, pair.mu, pair.mu, start=np.diag(pair.mu), cost="debiased",
        self_features=(features, features), **TIGHT,
    )  # fmt: skip
    assert abs(found.cost) < 1e-10
    other = ufgw(*pair.data, cost="debiased", self_features=(features, features), **TIGHT)
    assert other.cost > 0.01


@pytest.mark.parametrize("em_rate", [None, 0.4])
def test_a_ragged_batch_is_its_single_calls_for_any_threads(em_rate):
    shapes = [(1, 1), (3, 7), (6, 6), (12, 2), (9, 10)] * 4
    pairs = [make_pair(k, n, m) for k, (n, m) in enumerate(shapes)]
    columns = [list(column) for column in zip(*(pair.data for pair in pairs), strict=True)]
    single = [ufgw(*pair.data, em_rate=em_rate) for pair in pairs]
    for threads in (0, 1, 2, 5):
        batch = ufgw_batch(*columns, em_rate=em_rate, threads=threads)
        for one, many in zip(single, batch, strict=True):
            np.testing.assert_array_equal(one.plan, many.plan)
            np.testing.assert_array_equal(one.f, many.f)
            np.testing.assert_array_equal(one.g, many.g)
            np.testing.assert_array_equal(one.target_mass, many.target_mass)
            assert dict(one.terms) == dict(many.terms)
            assert one.cost == many.cost
            assert (one.n_iters, one.n_sweeps, one.converged) == (many.n_iters, many.n_sweeps, many.converged)


def test_an_empty_batch_is_empty():
    assert list(ufgw_batch([], [], [], [], [])) == []

"""Small pairs are solved side by side in vector lanes: the answers must be those of the scalar solver."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_ufgw_descent import check
from ufgw_problems import make_pair

from graft.errors import InputError
from graft.transport import Pairs, ufgw, ufgw_batch, ufgw_packed

SCALAR = 9e-13
"""A tolerance below what lanes take on: the scalar solver, to the last bit it can get."""

FIELDS = ("plans", "target_masses", "f", "g", "terms", "cost", "n_iters", "n_sweeps", "converged")


def columns(pairs):
    return [list(column) for column in zip(*(pair.data for pair in pairs), strict=True)]


def ragged(count=60, largest=14):
    rng = np.random.default_rng(0)
    return [make_pair(k, *rng.integers(1, largest, 2)) for k in range(count)]


def assert_same(left, right):
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(left, name), getattr(right, name), err_msg=name)


@pytest.mark.parametrize("em_rate", [None, 0.4, 0.8])
@pytest.mark.parametrize("options", [{}, {"tau_s": 0.1, "tau_t": 5.0}, {"eps": 0.5}, {"eps": 0.01}], ids=str)
def test_lanes_find_the_scalar_solution(options, em_rate):
    pairs = ragged()
    lanes = ufgw_batch(*columns(pairs), em_rate=em_rate, tol=1e-11, max_outer=5000, **options)
    scalar = ufgw_batch(*columns(pairs), em_rate=em_rate, tol=SCALAR, max_outer=5000, **options)
    assert lanes.converged.all()
    np.testing.assert_allclose(lanes.plans, scalar.plans, atol=2e-9)
    np.testing.assert_allclose(lanes.target_masses, scalar.target_masses, atol=2e-9)
    np.testing.assert_allclose(lanes.objective, scalar.objective, rtol=1e-10)
    np.testing.assert_allclose(lanes.f, scalar.f, atol=1e-7)


def test_default_tolerances_are_met():
    pairs = ragged(200)
    found = ufgw_batch(*columns(pairs), em_rate=0.4)
    exact = ufgw_batch(*columns(pairs), em_rate=0.4, tol=1e-11, max_outer=5000)
    assert found.converged.all()
    for near, true in zip(found, exact, strict=True):
        assert np.abs(near.plan - true.plan).sum() < 1e-5 * true.plan.sum()


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_every_instruction_set_gives_the_same_bits(precision):
    pairs = Pairs.pack(*columns(ragged(150)))
    best = ufgw_packed(pairs, em_rate=0.4, precision=precision)
    for instructions in ("avx512", "avx2", "baseline"):
        assert_same(best, ufgw_packed(pairs, em_rate=0.4, precision=precision, instructions=instructions))


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_threads_and_neighbours_change_no_bit(precision):
    pairs = ragged(300)
    whole = ufgw_batch(*columns(pairs), em_rate=0.4, precision=precision, threads=1)
    for threads in (0, 2, 3):
        assert_same(whole, ufgw_batch(*columns(pairs), em_rate=0.4, precision=precision, threads=threads))
    # In reverse every pair has other neighbours, another lane and another padding.
    reverse = ufgw_batch(*columns(pairs[::-1]), em_rate=0.4, precision=precision, threads=1)
    for one, other in zip(whole, list(reverse)[::-1], strict=True):
        np.testing.assert_array_equal(one.plan, other.plan)
        assert dict(one.terms) == dict(other.terms)
    alone = ufgw(*pairs[7].data, em_rate=0.4, precision=precision)
    np.testing.assert_array_equal(alone.plan, whole[7].plan)


def test_padding_with_massless_nodes_changes_no_bit():
    pair = make_pair(3, 5, 4)
    padded = [
        np.pad(pair.M, ((0, 3), (0, 2)), constant_values=7.0),
        np.pad(pair.A, (0, 3), constant_values=0.5),
        np.pad(pair.B, (0, 2), constant_values=0.5),
        np.pad(pair.mu, (0, 3)),
        np.pad(pair.nu, (0, 2)),
    ]
    small, large = ufgw(*pair.data, em_rate=0.4), ufgw(*padded, em_rate=0.4)
    np.testing.assert_array_equal(large.plan[:5, :4], small.plan)
    assert large.plan.sum() == pytest.approx(small.plan.sum(), rel=1e-15)
    assert large.objective == pytest.approx(small.objective, rel=1e-14)


def test_single_precision_is_near_double():
    pairs = ragged(200)
    double = ufgw_batch(*columns(pairs), em_rate=0.4, tol=1e-11, max_outer=5000)
    single = ufgw_batch(*columns(pairs), em_rate=0.4, precision="f32", tol=1e-5)
    assert single.converged.all()
    np.testing.assert_allclose(single.objective, double.objective, atol=1e-5)
    np.testing.assert_allclose(single.cost, double.cost, atol=1e-4)
    np.testing.assert_allclose(single.plans, double.plans, atol=1e-4)


@pytest.mark.parametrize("options", [{"eps": 0.002}, {"tau_s": 1e-3, "tau_t": 1e-3, "eps": 1e-3}], ids=str)
def test_what_single_precision_cannot_hold_is_solved_in_double(options):
    pairs = ragged(40)
    double = ufgw_batch(*columns(pairs), **options, max_outer=2000)
    single = ufgw_batch(*columns(pairs), **options, precision="f32", max_outer=2000)
    np.testing.assert_array_equal(single.converged, double.converged)
    np.testing.assert_allclose(single.objective, double.objective, rtol=1e-4, atol=1e-6)


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 2**20),
    st.sampled_from([1e-4, 1e-3, 0.01, 0.05, 1.0, 10.0]),
    st.sampled_from([1e-3, 0.1, 1.0, 1e3, np.inf]),
    st.sampled_from([1e-6, 1.0, 1e6]),
    st.sampled_from([1.0, 100.0]),
    st.sampled_from([None, 0.4]),
    st.sampled_from(["f64", "f32"]),
)
def test_batches_descend_and_stay_finite(seed, eps, tau, mass, scale, em_rate, precision):
    """Any precision, down to where lanes hand over: each pair of a ragged batch descends and is finite."""
    rng = np.random.default_rng(seed)
    pairs = [make_pair(seed + k, *rng.integers(1, 9, 2), scale=scale, mass=mass) for k in range(6)]
    options = {"eps": eps, "tau_s": tau, "tau_t": tau, "em_rate": em_rate}
    found = ufgw_batch(*columns(pairs), **options, precision=precision, max_outer=25, history=True)
    for transport, pair in zip(found, pairs, strict=True):
        if precision == "f64":
            check(transport, pair, **options)
        assert np.isfinite(transport.plan).all()
        assert np.isfinite(transport.cost)


@pytest.mark.parametrize("n", [1, 2, 31, 32, 33, 64])
def test_sizes_around_the_largest_block(n):
    pair = make_pair(n, n, n)
    found = ufgw(*pair.data, em_rate=0.4, history=True)
    check(found, pair)
    assert found.converged


def test_several_starts_never_do_worse_and_repeat():
    pairs = ragged(20)
    options = {"alpha": 0.05, "eps": 0.01}
    one = ufgw_batch(*columns(pairs), **options)
    many = ufgw_batch(*columns(pairs), **options, n_init=6, seed=3)
    assert (many.objective <= one.objective + 1e-9).all()
    assert (many.objective < one.objective - 1e-6).any()
    assert_same(many, ufgw_batch(*columns(pairs), **options, n_init=6, seed=3, threads=2))


def test_a_warm_start_with_its_potential_is_quicker():
    pairs = ragged(30, 8)
    cold = ufgw_batch(*columns(pairs), em_rate=0.4)
    # With EM, nu is where the masses start and the prior what they are pulled to.
    *data, nu = columns(pairs)
    warm = ufgw_batch(
        *data, [t.target_mass for t in cold], prior=nu, em_rate=0.4, start=[t.plan for t in cold],
        start_g=[t.g for t in cold],
    )  # fmt: skip
    assert warm.n_iters.mean() < 0.7 * cold.n_iters.mean()
    np.testing.assert_allclose(warm.plans, cold.plans, atol=1e-5)


def test_packed_arrays_are_checked():
    pairs = Pairs.pack(*columns(ragged(3)))
    short = Pairs(pairs.sizes, pairs.M[:-1], pairs.A, pairs.B, pairs.mu, pairs.nu)
    with pytest.raises(InputError, match=r"^M: expected \d+ more numbers, got \d+$"):
        ufgw_packed(short)
    with pytest.raises(InputError, match=r"^precision: expected one of f64, f32, got f16$"):
        ufgw_packed(pairs, precision="f16")
    with pytest.raises(InputError, match=r"^n_init: expected at least 1, got 0$"):
        ufgw_packed(pairs, n_init=0)


def test_a_batch_is_a_sequence():
    found = ufgw_batch(*columns(ragged(5)))
    assert len(found) == 5
    np.testing.assert_array_equal(found[-1].plan, found[4].plan)
    assert [t.cost for t in found[1:3]] == found.cost[1:3].tolist()
    with pytest.raises(IndexError):
        found[5]

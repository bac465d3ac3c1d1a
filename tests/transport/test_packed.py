"""Ranking a packed library: exactly what solving every graph gives, with most graphs never solved."""

from dataclasses import replace

import numpy as np
import pytest
from test_ufgw_graphs import make_graph

from graft.errors import InputError
from graft.transport import UFGW, PackedGraphs

K = 10


def random_library(seed, graphs, dim, solver, noise=0.5):
    """Return packed graphs of 2 to 8 parts whose features come in 50 families, and a target's arrays."""
    rng = np.random.default_rng(seed)
    sizes = rng.integers(2, 9, graphs)
    offsets = np.concatenate(([0], np.cumsum(sizes)))
    looks, boxes = rng.normal(size=(50, 8, dim)), rng.random((50, 8, 3)) / 2
    family = np.repeat(rng.integers(50, size=graphs), sizes)
    slot = np.arange(offsets[-1]) - np.repeat(offsets[:-1], sizes)
    masses = rng.random(offsets[-1]) + 0.05
    masses /= np.repeat(np.add.reduceat(masses, offsets[:-1]), sizes)
    extents = np.abs(boxes[family, slot] + 0.05 * rng.normal(size=(offsets[-1], 3)))
    descriptors = looks[family, slot] + noise * rng.normal(size=(offsets[-1], dim))
    relations = rng.normal(size=(offsets[-1], 4))
    relations /= np.linalg.norm(relations, axis=1, keepdims=True)
    structures = np.concatenate([lengths(rng, n) for n in sizes], axis=None)
    parts = (rng.random(graphs) * sizes).astype(np.int64)
    packed = PackedGraphs(offsets, parts, extents, relations, descriptors, structures, masses, solver)
    m = 5
    relation = rng.normal(size=(m, 4))
    prior = rng.random(m) + 0.05
    target = (
        np.abs(boxes[7, :m] + 0.05 * rng.normal(size=(m, 3))),
        relation / np.linalg.norm(relation, axis=1, keepdims=True),
        looks[7, :m] + noise * rng.normal(size=(m, dim)),
        lengths(rng, m),
        prior / prior.sum(),
    )
    return packed, target


def lengths(rng, n):
    points = rng.random((n, 3))
    x = np.linalg.norm(points[:, None] - points[None], axis=-1)
    return x / (1 + x)


SOLVERS = [
    UFGW(),
    UFGW(em_rate=None, tau_s=0.2),
    UFGW(part_weight=0.0, doubt_weight=0.0, rival_weight=0.0),
    UFGW(tau_s=np.inf, alpha=0.9),
    UFGW(lambda_relation=0.0, lambda_obb=3.0, tau_t=0.1),
]


@pytest.mark.parametrize(("seed", "solver"), list(enumerate(SOLVERS)))
def test_pruning_never_changes_the_best_of_ten_thousand(seed, solver):
    packed, target = random_library(seed, 10_000, 16, solver)
    pruned, brute = packed.rank_arrays(*target, K), packed.rank_arrays(*target, K, prune=False)
    np.testing.assert_array_equal(pruned.indices, brute.indices)
    np.testing.assert_array_equal(pruned.costs, brute.costs)
    assert brute.solved == 10_000
    assert pruned.solved < 5_000


@pytest.mark.parametrize("noise", [0.0, 5.0])
def test_equal_costs_keep_the_librarys_order(noise):
    """Every graph twice: the copy must come right after its original's equals, lower index first."""
    packed, target = random_library(5, 400, 8, UFGW(), noise)
    parts = len(packed.masses)
    twice = PackedGraphs(
        np.concatenate([packed.offsets, packed.offsets[1:] + parts]),
        *(np.concatenate([x, x]) for x in (packed.parts, packed.extents, packed.relations, packed.descriptors)),
        *(np.concatenate([x, x]) for x in (packed.structures, packed.masses)),
        UFGW(),
    )
    once, found = packed.rank_arrays(*target, 6), twice.rank_arrays(*target, 12)
    expected = np.stack([once.indices, once.indices + 400], axis=1).ravel()
    np.testing.assert_array_equal(found.indices, expected)


@pytest.mark.parametrize("described", [True, False])
def test_it_ranks_as_the_solver_ranks(described):
    graphs = [make_graph(k, 2 + k % 6, descriptors=described) for k in range(150)]
    parts = [k % 2 for k in range(150)]
    solver = UFGW()
    packed = PackedGraphs.pack(graphs, parts, solver)
    for seed in (500, 501, 502):
        target = make_graph(seed, 5)
        costs = np.array([t.cost for t in solver.batch(graphs, parts, target)])
        order = np.argsort(costs, kind="stable")[:K]
        found = packed.rank(target, K)
        np.testing.assert_array_equal(found.indices, order)
        np.testing.assert_allclose(found.costs, costs[order], rtol=1e-12)


def test_more_than_there_are_gives_all():
    packed, target = random_library(1, 12, 4, UFGW())
    found = packed.rank_arrays(*target, 100)
    assert sorted(found.indices) == list(range(12))
    assert (np.diff(found.costs) >= 0).all()


def test_bad_arguments_are_named():
    graphs = [make_graph(1, 3), make_graph(2, 4)]
    packed = PackedGraphs.pack(graphs, [0, 1], UFGW())
    target = make_graph(3, 3)
    with pytest.raises(InputError, match=r"^k: expected at least 1, got 0$"):
        packed.rank(target, 0)
    with pytest.raises(InputError, match=r"^descriptors: expected random-1 for object3, got other$"):
        packed.rank(replace(target, descriptor_name="other"), 1)
    with pytest.raises(InputError, match=r"^parts: expected 0 to 3 in object2, got 4$"):
        PackedGraphs.pack(graphs, [0, 4], UFGW())
    with pytest.raises(InputError, match=r"^parts: expected 2, one per graph, got 1$"):
        PackedGraphs.pack(graphs, [0], UFGW())
    with pytest.raises(InputError, match=r"^descriptors: expected one kind in the library, got None, random-1$"):
        PackedGraphs.pack([graphs[0], make_graph(2, 4, descriptors=False)], [0, 1], UFGW())
    with pytest.raises(InputError, match=r"^cost: ranking packed graphs needs sharp, got debiased$"):
        PackedGraphs.pack(graphs, [0, 1], UFGW(cost="debiased"))
    with pytest.raises(InputError, match=r"^eps: expected a finite number of at least 1e-9, got 0$"):
        PackedGraphs.pack(graphs, [0, 1], UFGW(eps=0.0)).rank(target, 1)
    wrong = replace(target, structure=np.full((3, 3), np.nan))
    with pytest.raises(InputError, match=r"^target structure: expected finite numbers, got NaN"):
        packed.rank(wrong, 1)


def test_only_graphs_that_are_asked_for_answer():
    packed, target = random_library(6, 3000, 8, UFGW())
    every = packed.rank_arrays(*target, 3000, prune=False)
    rng = np.random.default_rng(0)
    for count in (1, 7, 500, 3000):
        among = np.sort(rng.choice(3000, count, replace=False))
        found = packed.rank_arrays(*target, K, among=among)
        expected = np.isin(every.indices, among)
        np.testing.assert_array_equal(found.indices, every.indices[expected][:K])
        np.testing.assert_array_equal(found.costs, every.costs[expected][:K])
    assert len(packed.rank_arrays(*target, K, among=np.empty(0, np.int64)).indices) == 0


def test_a_bar_leaves_out_what_costs_more_and_saves_solving():
    packed, target = random_library(7, 3000, 8, UFGW())
    every = packed.rank_arrays(*target, 3000, prune=False)
    for rank in (0, 3, 40):
        found = packed.rank_arrays(*target, K, bar=every.costs[rank])
        np.testing.assert_array_equal(found.indices, every.indices[: min(K, rank + 1)])
    nothing = packed.rank_arrays(*target, K, bar=every.costs[0] / 2)
    assert len(nothing.indices) == 0
    assert nothing.solved < packed.rank_arrays(*target, K).solved


@pytest.mark.parametrize("among", [[1, 1], [2, 1], [-1, 2], [0, 12]])
def test_graphs_that_are_none_are_refused(among):
    packed, target = random_library(1, 12, 4, UFGW())
    with pytest.raises(InputError, match=r"^among: expected rising numbers from 0 to 11, got others$"):
        packed.rank_arrays(*target, 2, among=np.array(among))

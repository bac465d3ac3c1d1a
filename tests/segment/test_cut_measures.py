"""The benchmark's measures against their definitions, face by face."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graft.evaluate.cut_measures import (
    CutField,
    Net,
    consistency_errors,
    cut_discrepancy,
    hamming_distance,
    rand_index_error,
)

LABELLINGS = st.integers(2, 12).flatmap(
    lambda n: st.tuples(*[st.lists(st.integers(0, 3), min_size=n, max_size=n).map(np.array)] * 2)
)


@given(LABELLINGS)
def test_rand_index_error_counts_pairs(two) -> None:
    a, b = two
    n = len(a)
    apart = sum((a[i] == a[j]) != (b[i] == b[j]) for i in range(n) for j in range(i))
    assert rand_index_error(a, b) == pytest.approx(apart / (n * (n - 1) / 2))


@given(LABELLINGS, st.integers(0, 100))
def test_consistency_follows_its_definition(two, seed: int) -> None:
    a, b = two
    areas = np.random.default_rng(seed).uniform(0.1, 1.0, len(a))

    def refinement(x, y, i):
        own = x == x[i]
        return areas[own & (y != y[i])].sum() / areas[own].sum()

    forth = np.array([refinement(a, b, i) for i in range(len(a))])
    back = np.array([refinement(b, a, i) for i in range(len(a))])
    overall, local = consistency_errors(a, b, areas)
    assert overall == pytest.approx(min(forth @ areas, back @ areas) / areas.sum(), abs=1e-12)
    assert local == pytest.approx(np.minimum(forth, back) @ areas / areas.sum(), abs=1e-12)
    assert local <= overall + 1e-12


@given(LABELLINGS, st.integers(0, 100))
def test_hamming_follows_its_definition(two, seed: int) -> None:
    a, b = two
    areas = np.random.default_rng(seed).uniform(0.1, 1.0, len(a))

    def directional(x, y):
        missed = 0.0
        for label in np.unique(y):
            best = max(np.unique(x), key=lambda k: areas[(y == label) & (x == k)].sum())
            missed += areas[(y == label) & (x != best)].sum()
        return missed / areas.sum()

    assert hamming_distance(a, b, areas) == pytest.approx((directional(a, b) + directional(b, a)) / 2, abs=1e-12)


@given(LABELLINGS)
def test_all_are_zero_for_equal_cuts_under_other_names(two) -> None:
    a, _ = two
    other, areas = 7 - a, np.ones(len(a))
    assert rand_index_error(a, other) == 0.0
    assert hamming_distance(a, other, areas) == pytest.approx(0.0, abs=1e-12)
    assert consistency_errors(a, other, areas) == pytest.approx((0.0, 0.0), abs=1e-12)


def strip(n: int):
    """A strip of n unit squares, each of two triangles."""
    x = np.arange(n + 1.0)
    vertices = np.concatenate([np.stack([x, 0 * x, 0 * x], 1), np.stack([x, 0 * x + 1, 0 * x], 1)])
    i = np.arange(n)
    faces = np.concatenate([np.stack([i, i + 1, i + n + 2], 1), np.stack([i, i + n + 2, i + n + 1], 1)])
    return vertices, faces, np.tile(i, 2)


def test_cut_discrepancy_is_how_far_cuts_lie_apart() -> None:
    vertices, faces, column = strip(10)
    net = Net.of(vertices, faces)
    a, b = (CutField.of(net, (column >= k).astype(np.int64)) for k in (3, 7))
    centers = vertices[faces].mean(axis=1)
    radius = np.linalg.norm(centers - centers.mean(axis=0), axis=1).mean()
    assert net.radius == pytest.approx(radius)
    assert cut_discrepancy(a, b, net.radius) == pytest.approx(2 * 4.0 / radius)
    assert cut_discrepancy(a, a, net.radius) == 0.0


def test_cut_discrepancy_is_unknown_without_cuts() -> None:
    vertices, faces, column = strip(4)
    net = Net.of(vertices, faces)
    none, some = CutField.of(net, 0 * column), CutField.of(net, column)
    assert cut_discrepancy(none, some, net.radius) is None

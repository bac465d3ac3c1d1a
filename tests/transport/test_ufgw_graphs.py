"""The solver on part graphs: masses, feature costs, descriptors."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from graft.errors import InputError
from graft.objects import Floats
from graft.transport import UFGW, ufgw


@dataclass(frozen=True)
class Named:
    name: str


@dataclass(frozen=True, eq=False)
class Graph:
    """What the solver reads of a part graph."""

    object: Named
    diagonal: float
    centers: Floats
    half_extents: Floats
    volumes: Floats
    structure: Floats
    adjacency: np.ndarray
    descriptors: Floats | None
    descriptor_name: str | None


def make_graph(seed, n, descriptors=True, diagonal=2.0):
    rng = np.random.default_rng(seed)
    centers = rng.random((n, 3))
    distance = np.linalg.norm(centers[:, None] - centers[None], axis=-1)
    extents = -np.sort(-rng.random((n, 3)), axis=1)
    path = np.abs(np.subtract.outer(np.arange(n), np.arange(n))) == 1
    return Graph(
        object=Named(f"object{seed}"),
        diagonal=diagonal,
        centers=centers,
        half_extents=diagonal * extents,
        volumes=8 * extents.prod(1),
        structure=distance / (1 + distance),
        adjacency=path,
        descriptors=rng.normal(size=(n, 8)) if descriptors else None,
        descriptor_name="random-1" if descriptors else None,
    )


def feature_cost(source, target, lambda_obb=1.0, lambda_global=1.0):
    cost = np.empty((len(source.centers), len(target.centers)))
    for i, j in np.ndindex(cost.shape):
        e, d = source.half_extents[i] / source.diagonal, target.half_extents[j] / target.diagonal
        cost[i, j] = lambda_obb * np.tanh(np.linalg.norm(e - d) / 2)
        if source.descriptors is not None and target.descriptors is not None:
            f, g = source.descriptors[i], target.descriptors[j]
            cost[i, j] += lambda_global * (1 - f @ g / np.linalg.norm(f) / np.linalg.norm(g))
    return cost


def test_the_defaults_are_designs():
    solver = UFGW()
    assert (solver.alpha, solver.tau_s, solver.tau_t, solver.eps) == (0.5, 1.0, 1.0, 0.05)
    assert (solver.em_rate, solver.saliency, solver.loss, solver.entropy) == (0.4, 0.6, "square", "relative")


def test_features_are_their_formula_whatever_each_source_has():
    sources = [make_graph(1, 4), make_graph(2, 3, descriptors=False), make_graph(3, 5)]
    target = make_graph(4, 6, diagonal=0.1)
    found = UFGW(lambda_obb=0.7, lambda_global=0.2).features(sources, target)
    for source, cost in zip(sources, found, strict=True):
        np.testing.assert_allclose(cost, feature_cost(source, target, 0.7, 0.2), atol=1e-12)


def test_one_call_is_the_formulas_by_hand():
    source, target = make_graph(1, 4), make_graph(2, 5)
    mass = source.volumes * 0.6 ** np.array([1, 0, 1, 2])
    expected = ufgw(
        feature_cost(source, target),
        source.structure,
        target.structure,
        mass / mass.sum(),
        target.volumes / target.volumes.sum(),
        em_rate=0.4,
    )
    found = UFGW()(source, target, 1)
    np.testing.assert_allclose(found.plan, expected.plan, atol=1e-12)
    np.testing.assert_allclose(found.source_mass, mass / mass.sum(), atol=1e-14)


def test_a_batch_is_its_single_calls():
    sources, target = [make_graph(k, 2 + k) for k in range(6)], make_graph(9, 4)
    parts = [k % 2 for k in range(6)]
    solver = UFGW()
    for found, source, part in zip(solver.batch(sources, parts, target), sources, parts, strict=True):
        np.testing.assert_array_equal(found.plan, solver(source, target, part).plan)
    assert solver.batch([], [], target) == []


def test_an_object_suits_itself_best():
    target = make_graph(1, 5)
    costs = [t.cost for t in UFGW().batch([make_graph(k, 5) for k in range(4)], [0] * 4, target)]
    assert int(np.argmin(costs)) == 1


def test_the_debiased_cost_is_nearly_nothing_for_an_object_and_itself():
    target = make_graph(1, 5)
    solver = UFGW(cost="debiased", em_rate=None, saliency=1.0, eps=0.01)
    same, other = solver.batch([target, make_graph(2, 5)], [0, 0], target)
    assert abs(same.cost) < 0.1 * other.cost


def test_the_papers_variant_is_its_formula():
    source, target = make_graph(1, 3), make_graph(2, 4)
    gap = np.linalg.norm(source.half_extents[:, None] / 2 - target.half_extents[None] / 2, axis=-1)
    unit = [g.descriptors / np.linalg.norm(g.descriptors, axis=1, keepdims=True) for g in (source, target)]
    expected = 1 / (1 + np.exp(-gap)) + 1 + unit[0] @ unit[1].T
    np.testing.assert_allclose(UFGW(variant="paper").features([source], target)[0], expected, atol=1e-12)


def test_different_descriptors_are_refused_and_named():
    source, target = make_graph(1, 3), replace(make_graph(2, 3), descriptor_name="dino-2")
    with pytest.raises(InputError, match=r"got random-1 \(8-d\) for object1 and dino-2 \(8-d\) for object2"):
        UFGW()(source, target, 0)
    shorter = replace(make_graph(2, 3), descriptors=np.ones((3, 5)))
    with pytest.raises(InputError, match=r"random-1 \(8-d\) .* random-1 \(5-d\)"):
        UFGW()(source, shorter, 0)


def test_bad_arguments_are_named():
    graph = make_graph(1, 3)
    with pytest.raises(InputError, match=r"^source_part: expected 0 to 2 in object1, got 3$"):
        UFGW()(graph, graph, 3)
    with pytest.raises(InputError, match=r"^source_parts: expected 2, one per source, got 1$"):
        UFGW().batch([graph, graph], [0], graph)
    with pytest.raises(InputError, match=r"^lambda_obb: expected a finite number >= 0, got -1$"):
        UFGW(lambda_obb=-1.0)(graph, graph, 0)
    with pytest.raises(InputError, match=r"^variant: expected one of graft, paper, got other$"):
        UFGW(variant="other")(graph, graph, 0)

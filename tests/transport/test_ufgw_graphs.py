"""The solver on part graphs: masses, feature costs, descriptors."""

from dataclasses import replace

import numpy as np
import pytest

from graft.errors import InputError
from graft.graph import PartFlag, PartGraph
from graft.objects import Part, PartObject
from graft.transport import UFGW, claim, matched_part, ufgw


def make_graph(seed, n, descriptors=True, diagonal=2.0):
    """A part graph of n parts with random boxes, relations and descriptors; its parts hang in a row."""
    rng = np.random.default_rng(seed)
    centers = rng.random((n, 3))
    distance = np.linalg.norm(centers[:, None] - centers[None], axis=-1)
    extents = -np.sort(-rng.random((n, 3)), axis=1)
    relations = rng.normal(size=(n, 6))
    return PartGraph(
        object=PartObject(f"object{seed}", tuple(Part(f"part{k}", [c]) for k, c in enumerate(centers))),
        diagonal=diagonal,
        centers=centers,
        axes=np.tile(np.eye(3), (n, 1, 1)),
        half_extents=diagonal * extents,
        volumes=8 * (diagonal * extents).prod(1),
        areas=np.ones(n),
        flags=(PartFlag.CLOUD,) * n,
        points=tuple(centers[:, None]),
        normals=tuple(np.tile([0.0, 0.0, 1.0], (n, 1, 1))),
        gaps=distance,
        structure=distance / (1 + distance),
        adjacency=np.abs(np.subtract.outer(np.arange(n), np.arange(n))) == 1,
        relations=relations / np.linalg.norm(relations, axis=1, keepdims=True),
        descriptors=rng.normal(size=(n, 8)) if descriptors else None,
        descriptor_name="random-1" if descriptors else None,
    )


def feature_cost(source, target, lambda_obb=1.0, lambda_global=1.0, lambda_relation=1.0):
    cost = np.empty((len(source.centers), len(target.centers)))
    for i, j in np.ndindex(cost.shape):
        e, d = source.half_extents[i] / source.diagonal, target.half_extents[j] / target.diagonal
        cost[i, j] = lambda_obb * np.tanh(np.linalg.norm(e - d) / 2)
        cost[i, j] += lambda_relation * (1 - source.relations[i] @ target.relations[j])
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
    found = UFGW(lambda_obb=0.7, lambda_global=0.2, lambda_relation=0.4).features(sources, target)
    for source, cost in zip(sources, found, strict=True):
        np.testing.assert_allclose(cost, feature_cost(source, target, 0.7, 0.2, 0.4), atol=1e-12)


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


def test_the_ranking_adds_the_demonstrated_parts_own_cost():
    source, target = make_graph(1, 4), make_graph(2, 5)
    plain = UFGW(part_weight=0.0, doubt_weight=0.0, rival_weight=0.0)(source, target, 2)
    ranked = UFGW(part_weight=0.7, doubt_weight=0.2, rival_weight=0.3)(source, target, 2)
    part, share = matched_part(plain.plan, plain.target_mass, 2)
    own, doubt = 0.7 * feature_cost(source, target)[2, part], -0.2 * np.log(share)
    rivals = -0.3 * np.log(plain.plan[2, part] / plain.plan[:, part].sum())
    np.testing.assert_array_equal(ranked.plan, plain.plan)
    assert ranked.terms["part"] == pytest.approx(own)
    assert ranked.terms["doubt"] == pytest.approx(doubt)
    assert ranked.terms["rivals"] == pytest.approx(rivals)
    assert ranked.cost == pytest.approx(plain.cost + own + doubt + rivals)


def test_a_part_that_receives_nothing_is_claimed_by_none():
    plan = np.array([[0.3, 0.0], [0.1, 0.0]])
    assert [claim(plan, i, 0) for i in (0, 1)] == pytest.approx([0.75, 0.25])
    assert [claim(plan, i, 1) for i in (0, 1)] == [0.0, 0.0]


def test_the_matched_part_receives_most_for_the_root_of_its_mass():
    plan = np.array([[0.1, 0.15], [0.1, 0.6]])
    assert matched_part(plan, np.array([0.16, 0.64]), 0) == (0, pytest.approx(0.25 / (0.25 + 0.1875)))
    assert matched_part(np.array([[0.1, 0.2]]), np.array([0.16, 0.64]), 0) == (0, 0.5), "ties go to the lowest"
    assert matched_part(np.array([[0.0, 0.0], [0.1, 0.5]]), np.array([0.2, 0.8]), 0) == (1, 0.0)
    assert matched_part(np.array([[0.1, 0.0]]), np.array([0.1, 0.0]), 0) == (0, 1.0), "a part without mass"


def test_an_object_suits_itself_best():
    target = make_graph(1, 5)
    costs = [t.cost for t in UFGW().batch([make_graph(k, 5) for k in range(4)], [0] * 4, target)]
    assert int(np.argmin(costs)) == 1


def test_the_debiased_cost_is_nearly_nothing_for_an_object_and_itself():
    target = make_graph(1, 5)
    solver = UFGW(
        cost="debiased", em_rate=None, saliency=1.0, eps=0.01, part_weight=0.0, doubt_weight=0.0, rival_weight=0.0
    )
    same, other = solver.batch([target, make_graph(2, 5)], [0, 0], target)
    assert abs(same.cost) < 0.1 * other.cost


def test_the_papers_variant_is_its_formula():
    source, target = make_graph(1, 3), make_graph(2, 4)
    gap = np.linalg.norm(source.half_extents[:, None] / 2 - target.half_extents[None] / 2, axis=-1)
    unit = [g.descriptors / np.linalg.norm(g.descriptors, axis=1, keepdims=True) for g in (source, target)]
    expected = 1 / (1 + np.exp(-gap)) + 1 + unit[0] @ unit[1].T
    np.testing.assert_allclose(
        UFGW(variant="paper", lambda_relation=0.0).features([source], target)[0], expected, atol=1e-12
    )


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

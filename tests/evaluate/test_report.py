import json

import numpy as np
import pytest
from evaluation_shapes import tools
from numpy.testing import assert_allclose

from graft.evaluate.ablation import RootAnchored, ablations
from graft.evaluate.diversity import diversity, normalised_entropy, retrieving_methods
from graft.evaluate.methods import Graft, Graphs
from graft.evaluate.protocols import Posing, from_objects
from graft.evaluate.report import (
    by_category,
    calibration_error,
    coverage_area,
    coverage_curve,
    document,
    effects,
    summarise,
)
from graft.evaluate.rows import Answer, Row
from graft.evaluate.runner import build_graphs, evaluate
from graft.transport import UFGW


def answer(right, source="mug", confidence=0.5):
    return Answer(
        source=f"{source}_1",
        source_category=source,
        part="p",
        right=right,
        inside=right,
        nss=1.0 if right else -1.0,
        distance=0.0 if right else 0.2,
        confidence=confidence,
        point=(0.0, 0.0, 0.0),
    )


def row(target, answers, category="jug", exchangeable=False):
    return Row("method", target, target, category, exchangeable, tuple(answers))


def test_top_one_and_top_k():
    rows = [row("a", [answer(True), answer(False)]), row("b", [answer(False), answer(False)])]
    (summary,) = summarise(rows, k=2)
    values = {name: figure.value for name, figure in summary.figures.items()}
    assert summary.targets == 2
    assert values["part"] == values["asr"] == 0.5
    assert values["part_top"] == 0.25
    assert_allclose([values["nss"], values["dtm"], values["dtm_top"]], [0.0, 0.1, 0.15])


def test_draws_without_a_rank_all_count():
    draws = [answer(True)] * 3 + [answer(False)]
    (summary,) = summarise([row("a", draws, exchangeable=True)], k=2)
    assert summary.figures["part"].value == summary.figures["part_top"].value == 0.75


def test_categories_are_kept_apart():
    rows = [row("a", [answer(True)], "jug"), row("b", [answer(False)], "cup")]
    assert {k: v[0].figures["part"].value for k, v in by_category(rows).items()} == {"cup": 0.0, "jug": 1.0}


def test_coverage_curve_falls_when_confidence_is_right():
    rows = [row(str(i), [answer(i < 5, confidence=1.0 - i / 10)]) for i in range(10)]
    curve = coverage_curve(rows)
    assert [coverage for coverage, _ in curve] == [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]
    assert_allclose([accuracy for _, accuracy in curve], [1] * 5 + [5 / 6, 5 / 7, 5 / 8, 5 / 9, 0.5])
    backwards = [row(str(i), [answer(i < 5, confidence=i / 10)]) for i in range(10)]
    assert coverage_curve(backwards)[0][1] == 0.0


def test_the_area_is_largest_when_right_answers_are_surest():
    rows = [row(str(i), [answer(i < 5, confidence=1.0 - i / 10)]) for i in range(10)]
    area, most = coverage_area(rows)
    assert area == most == pytest.approx((5 + sum(5 / n for n in range(6, 11))) / 10)
    backwards = [row(str(i), [answer(i < 5, confidence=i / 10)]) for i in range(10)]
    assert coverage_area(backwards) == pytest.approx((sum((n - 5) / n for n in range(6, 11)) / 10, most))
    assert coverage_area([row("0", [answer(True)])]) == (1.0, 1.0)


def test_calibration_compares_confidence_with_being_right():
    assert calibration_error([row("a", [answer(True, confidence=0.8)]), row("b", [answer(False, confidence=0.4)])]) == (
        pytest.approx((0.2**2 + 0.4**2) / 2)
    )
    assert calibration_error([row("a", [answer(True, confidence=-0.8)])]) is None
    assert calibration_error([row("a", [answer(True, confidence=None)])]) is None


def test_effects_are_paired_by_query():
    ours = [row(str(i), [answer(i < 5)]) for i in range(10)]
    theirs = [
        Row("other", r.query, r.target, r.category, False, (answer(i < 5 or i == 7),)) for i, r in enumerate(ours)
    ]
    (found,) = effects([*ours, *theirs], "method").values()
    assert_allclose(found["part"].value, 0.1)
    assert found["part"].low >= 0.0, "no query got worse"
    same = [Row("same", r.query, r.target, r.category, False, r.answers) for r in ours]
    assert effects([*ours, *same], "method")["same"]["part"].high == 0.0


def test_entropy_of_one_and_of_all_different():
    assert normalised_entropy(["a"] * 4) == 0.0
    assert_allclose(normalised_entropy("abcd"), 1.0)
    assert_allclose(normalised_entropy("aabb"), 0.5)
    assert normalised_entropy(["a"]) == 0.0


def test_diversity_counts_categories_and_follows_accuracy():
    rows = [row("a", [answer(True, "mug"), answer(True, "pan"), answer(False, "mug")])]
    (found,) = diversity(rows, 3)
    assert found.categories.value == 2.0
    assert_allclose(found.entropy.value, -(2 * np.log(2 / 3) + np.log(1 / 3)) / 3 / np.log(3))
    assert_allclose([estimate.value for estimate in found.accuracy], [1.0, 1.0, 2 / 3])


@pytest.fixture(scope="module")
def benchmark():
    return from_objects("leave-category-out", tools(), Posing())


@pytest.fixture(scope="module")
def rows(benchmark):
    return evaluate(benchmark, retrieving_methods(), k=2)


def test_the_document_is_json_and_complete(benchmark, rows):
    found = document(benchmark, rows, 2, varied=diversity(rows, 2))
    again = json.loads(json.dumps(found, allow_nan=False))
    assert again["targets"] == again["queries"] == 4
    assert [m["method"] for m in again["methods"]] == [method.name for method in retrieving_methods()]
    assert set(again["categories"]) == {"hammer", "paddle"}
    assert again["quoted"]["GRAFT, paper (quoted)"] == {"asr": 0.85, "nss": 0.82, "dtm": 0.02}
    assert len(again["rows"]) == len(rows)


def test_every_ablation_runs_and_differs_in_parameters(benchmark):
    methods = ablations()
    assert len({repr((m.solver, m.graphs, m.landing, m.voters)) for m in methods}) == len(methods)
    assert len({m.name for m in methods}) == len(methods)
    rows = evaluate(benchmark, methods, k=1)
    assert len(rows) == 4 * len(methods)
    points = {r.method: r.answers[0].point for r in rows if r.query == "hammer_a"}
    assert points["landing: boxes not aligned"] != points["graft"]


def test_root_anchor_is_ufgw_without_em_when_the_masses_agree(benchmark):
    # Saliency 1 makes the anchored masses the target's volumes, which are UFGW's prior.
    (graphs,) = build_graphs(benchmark, [Graphs()])
    anchored = RootAnchored(UFGW(saliency=1.0)).batch(graphs[:2], [1, 1], graphs[2])
    plain = UFGW(saliency=1.0, em_rate=None).batch(graphs[:2], [1, 1], graphs[2])
    for a, b in zip(anchored, plain, strict=True):
        assert_allclose(a.plan, b.plan, atol=1e-9)
    # Otherwise mass moves to the root's side.
    moved = RootAnchored(UFGW()).batch(graphs[:1], [1], graphs[2])[0]
    assert not np.allclose(moved.target_mass, anchored[0].target_mass)


def test_projected_contacts_lie_on_the_matched_part(benchmark):
    (graphs,) = build_graphs(benchmark, [Graphs()])
    for query in benchmark.queries:
        (codes,), (projected,) = (
            Graft(landing=landing).fit(benchmark, graphs).predict(query, 1, np.random.default_rng(0))
            for landing in ("codes", "projected")
        )
        assert codes.part == projected.part
        assert codes.source == projected.source

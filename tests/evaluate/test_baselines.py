import numpy as np
import pytest
from evaluation_shapes import capped_sphere, hammer, paddle, tools, turned
from numpy.testing import assert_allclose

from graft.errors import InputError
from graft.evaluate.baselines import (
    FunctionalMap,
    NearestDescriptor,
    NearestMoments,
    RandomPart,
    RandomPoint,
    WholeObject,
)
from graft.evaluate.baselines.icp import align, rigid
from graft.evaluate.baselines.moments import shape_moments, standardised
from graft.evaluate.baselines.spectral import Spectrum, functional_map
from graft.evaluate.baselines.whole_object import describe
from graft.evaluate.methods import Graphs
from graft.evaluate.metrics import GraspableMask, sample_surface
from graft.evaluate.protocols import Posing, from_objects, stream
from graft.evaluate.runner import build_graphs


@pytest.fixture(scope="module")
def within():
    return from_objects("within-category", tools(), Posing(seed=1))


@pytest.fixture(scope="module")
def graphs(within):
    return build_graphs(within, [Graphs()])[0]


@pytest.mark.parametrize("method", [NearestMoments(), NearestDescriptor(), WholeObject()], ids=lambda m: m.name)
def test_what_looks_alike_is_found_among_its_kind(within, graphs, method):
    predictor = method.fit(within, graphs)
    for query in within.queries:
        (best,) = predictor.predict(query, 1, stream(0))
        subject = within.subjects[query.target]
        assert best.part in subject.object.graspable
        assert GraspableMask.of(subject.truth, subject.diagonal).measure(best.point[None]).inside.all()


@pytest.mark.parametrize("method", [RandomPart(), RandomPoint()], ids=lambda m: m.name)
def test_chance_depends_on_its_seed_only(within, graphs, method):
    predictor, query = method.fit(within, graphs), within.queries[0]
    first, again, other = (predictor.predict(query, 1, stream(seed)) for seed in (1, 1, 2))
    assert [p.point.tolist() for p in first] == [p.point.tolist() for p in again]
    assert [p.point.tolist() for p in first] != [p.point.tolist() for p in other]


def test_random_points_come_by_area_and_random_parts_do_not(within, graphs):
    query = within.queries[0]
    surface = sample_surface(within.subjects[query.target].object)
    share = float(surface.weights[surface.part == 1].sum())

    def frequency(method):
        predictor = method.fit(within, graphs)
        parts = [p.part for seed in range(40) for p in predictor.predict(query, 1, stream(seed))]
        return float(np.mean(np.array(parts) == 1))

    assert abs(frequency(RandomPoint()) - share) < 0.05
    assert abs(frequency(RandomPart()) - 0.5) < 0.06


def test_nearest_descriptor_needs_descriptors(within):
    (bare,) = build_graphs(within, [Graphs(descriptor=None)])
    with pytest.raises(InputError, match="with descriptors"):
        NearestDescriptor().fit(within, bare)


@pytest.mark.parametrize("seed", range(3))
def test_descriptions_do_not_change_when_turned_and_scaled(seed):
    points = sample_surface(hammer("hammer"), 400).points
    transform = turned(seed, scale=5.0)
    moved = points @ transform[:3, :3].T + transform[:3, 3]
    assert_allclose(shape_moments(moved), shape_moments(points), rtol=1e-9)
    assert_allclose(describe(moved), describe(points), atol=1e-9)


def test_moments_of_a_sphere_and_of_flat_points():
    ratio, thin, _, sphericity = shape_moments(sample_surface(capped_sphere(1.0), 4000).points)
    assert_allclose([ratio, thin, sphericity], 1.0, atol=0.05)
    flat = shape_moments(np.random.default_rng(0).random((50, 3)) * [1, 1, 0])
    assert np.isfinite(flat).all()
    assert np.isfinite(shape_moments(np.zeros((5, 3)))).all()


def test_standardised_columns():
    rows = standardised(np.array([[1.0, 5.0], [3.0, 5.0]]))
    assert_allclose(rows, [[-1.0, 0.0], [1.0, 0.0]])


def test_rigid_fit_recovers_the_motion():
    points = np.random.default_rng(0).random((30, 3))
    transform = turned(2)
    found = rigid(points, points @ transform[:3, :3].T + transform[:3, 3])
    assert_allclose(found, transform, atol=1e-9)
    # Mirrored points are fitted by a rotation all the same.
    assert_allclose(np.linalg.det(rigid(points, points * [1, 1, -1])[:3, :3]), 1.0)


@pytest.mark.parametrize("seed", range(3))
def test_icp_lays_a_copy_on_its_original(seed):
    points = sample_surface(paddle("paddle"), 256).points
    transform = turned(seed, scale=1.7)
    found = align(points, points @ transform[:3, :3].T + transform[:3, 3])
    assert found.error < 0.02
    spots = sample_surface(paddle("paddle"), 50, seed=4).points
    # The paddle is symmetric: what must agree is where its two parts went.
    moved = spots @ found.transform[:3, :3].T + found.transform[:3, 3]
    back = (moved - transform[:3, 3]) @ np.linalg.inv(transform[:3, :3]).T
    assert_allclose(back[:, 0], spots[:, 0], atol=0.1)


def test_functional_map_of_an_object_to_itself_is_the_identity():
    spectrum = Spectrum.of(hammer("hammer"))
    assert_allclose(spectrum.functions.T @ spectrum.functions, np.eye(24), atol=1e-8)
    mapped = functional_map(spectrum, spectrum)
    assert_allclose(mapped, np.eye(24), atol=0.15)


def test_functional_map_carries_a_contact_to_a_turned_copy():
    copy = hammer("hammer_c").transformed(turned(0))
    benchmark = from_objects("within-category", [hammer("hammer_a"), copy], Posing(turn=False))
    (graphs,) = build_graphs(benchmark, [Graphs()])
    predictor = FunctionalMap().fit(benchmark, graphs)
    for query in benchmark.queries:
        (best,) = predictor.predict(query, 1, stream(0))
        assert best.part == 1

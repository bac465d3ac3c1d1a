"""The metrics against closed forms: strips of a plane, caps of a sphere."""

from math import erf

import numpy as np
import pytest
from evaluation_shapes import capped_sphere, strips, turned
from numpy.testing import assert_allclose

from graft.errors import InputError
from graft.evaluate.metrics import (
    BLUR,
    GraspableMask,
    PartSurface,
    Surface,
    blur,
    sample_surface,
)
from graft.objects import Part, PartObject

CUT = 0.3


def soup(triangles):
    return PartSurface.of(Part("soup", triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)))


def test_samples_share_the_area():
    surface = sample_surface(strips(CUT), 1000)
    assert abs(int((surface.part == 1).sum()) - 700) <= 1
    assert_allclose(surface.weights.sum(), 1.0)
    assert_allclose(surface.points[:, 2], 0.0)
    assert (surface.points[surface.part == 0, 0] <= CUT).all()


def test_blurred_edge_is_the_normal_distribution():
    # Far from the rim a half plane blurred by a Gaussian is Phi(x / sigma).
    surface = sample_surface(strips(CUT), 40_000)
    mask = (surface.part == 0).astype(float)
    sigma = 0.05
    offsets = np.linspace(-0.12, 0.12, 9)
    along = np.linspace(0.3, 0.7, 20)
    places = np.array([[CUT + x, y, 0.0] for x in offsets for y in along])
    expected = [0.5 * (1.0 - erf(x / (sigma * np.sqrt(2)))) for x in offsets]
    assert_allclose(blur(surface, mask, sigma, places).reshape(9, 20).mean(axis=1), expected, atol=0.015)


def test_blur_of_a_constant_is_the_constant_and_stays_in_range():
    surface = sample_surface(capped_sphere(1.0), 700)
    assert_allclose(blur(surface, np.ones(700), 0.05), 1.0)
    noise = np.random.default_rng(0).random(700)
    smooth = blur(surface, noise, 0.05)
    assert noise.min() <= smooth.min() <= smooth.max() <= noise.max()
    assert smooth.std() < noise.std()


def test_blur_is_the_plain_double_sum():
    rng = np.random.default_rng(1)
    weights = rng.random(90)
    surface = Surface(rng.random((90, 3)), weights / weights.sum(), np.zeros(90, int))
    values = rng.random(90)
    squares = np.square(surface.points[:, None] - surface.points).sum(axis=2)
    kernel = np.exp(-squares / (2 * 0.2**2)) * surface.weights
    kernel[squares > 1.0] = 0.0
    assert_allclose(blur(surface, values, 0.2), kernel @ values / kernel.sum(axis=1), rtol=1e-12)


def test_blur_out_of_reach_takes_the_nearest():
    surface = Surface(np.array([[0.0, 0, 0], [10.0, 0, 0]]), np.array([0.5, 0.5]), np.array([0, 1]))
    assert_allclose(blur(surface, np.array([2.0, 5.0]), 0.01, np.array([[4.0, 0, 0], [6.0, 0, 0]])), [2.0, 5.0])


def test_nss_deep_inside_a_small_blur():
    # With a sharp mask of share m, NSS is sqrt((1 - m) / m) inside and -sqrt(m / (1 - m)) outside; the blur
    # takes a little off the deviation.
    mask = GraspableMask.of(strips(CUT), np.sqrt(2.0))
    inside, outside = mask.measure(np.array([[0.1, 0.5, 0.0], [0.8, 0.5, 0.0]])).nss
    assert_allclose(mask.mean, CUT, atol=2e-3)
    assert_allclose(inside, np.sqrt(0.7 / 0.3), rtol=0.05)
    assert_allclose(outside, -np.sqrt(0.3 / 0.7), rtol=0.05)
    # Var of Phi(x / s) across the cut: m (1 - m) - s / sqrt(pi), from the integral of Phi (1 - Phi).
    variance = 0.3 * 0.7 - BLUR * np.sqrt(2) / np.sqrt(np.pi)
    assert_allclose(mask.deviation**2, variance, rtol=0.02)


def test_nss_at_random_places_is_zero_on_average():
    mask = GraspableMask.of(capped_sphere(1.2, rings=20), 2 * np.sqrt(3))
    places = sample_surface(mask.object, 600, seed=9).points
    assert abs(mask.measure(places).nss.mean()) < 0.05


def test_distance_on_the_strip_and_on_the_sphere():
    mask = GraspableMask.of(strips(CUT), 2.0)
    measures = mask.measure(np.array([[0.2, 0.5, 0.0], [0.7, 0.4, 0.0]]))
    assert measures.inside.tolist() == [True, False]
    assert_allclose(measures.distance, [0.0, 0.4 / 2.0])
    sphere = GraspableMask.of(capped_sphere(1.0, rings=120), 1.0)
    pole = sphere.measure(np.array([[0.0, 0.0, -1.0]]))
    assert_allclose(pole.distance, 2 * np.sin((np.pi - 1.0) / 2), rtol=1e-2)


def test_the_seam_belongs_to_the_mask():
    mask = GraspableMask.of(strips(CUT), 1.0)
    assert mask.measure(np.array([[CUT, 0.5, 0.0]])).inside.all()


@pytest.mark.parametrize("seed", range(3))
def test_turning_and_scaling_change_nothing(seed):
    obj, transform = capped_sphere(0.8), turned(seed, scale=3.7)
    points = sample_surface(obj, 40, seed=5).points
    plain = GraspableMask.of(obj, 2.0).measure(points)
    moved = GraspableMask.of(obj.transformed(transform), 2.0 * 3.7)
    again = moved.measure(points @ transform[:3, :3].T + transform[:3, 3])
    assert_allclose(again.nss, plain.nss, atol=1e-9)
    assert_allclose(again.distance, plain.distance, atol=1e-9)
    assert (again.inside == plain.inside).all()


def test_distance_to_triangles_is_the_least_over_a_fine_grid():
    rng = np.random.default_rng(3)
    u, v = np.meshgrid(np.linspace(0, 1, 201), np.linspace(0, 1, 201))
    keep = u + v <= 1 + 1e-12
    u, v = u[keep][:, None], v[keep][:, None]
    for _ in range(25):
        triangles, point = rng.normal(size=(4, 3, 3)), rng.normal(size=3)
        grid = np.concatenate([t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]) for t in triangles])
        best = np.linalg.norm(grid - point, axis=1).min()
        exact = soup(triangles).distance(point)
        assert exact <= best + 1e-12
        assert_allclose(exact, best, atol=0.01)


def test_distance_to_a_degenerate_triangle():
    line = np.array([[[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]]])
    assert_allclose(soup(line).distance(np.array([1.5, 2.0, 0])), 2.0)


def test_clouds_count_their_points():
    cloud = PartObject(
        "cloud",
        (
            Part("a", np.diag([0.0, 1.0, 2.0]) @ np.full((3, 3), [1.0, 0, 0])),
            Part("b", np.array([[5.0, 0, 0]])),
        ),
        graspable=(1,),
    )
    surface = sample_surface(cloud)
    assert_allclose(surface.weights, 0.25)
    point = np.array([4.0, 0, 0])
    assert_allclose([PartSurface.of(part).distance(point) for part in cloud.parts], [2.0, 1.0])
    assert GraspableMask.of(cloud, 5.0).measure(np.array([[4.0, 0, 0]])).inside.all()


def test_where_everything_is_graspable_nss_is_zero():
    mask = GraspableMask.of(strips(CUT, graspable=(0, 1)), 1.0)
    measures = mask.measure(np.array([[0.9, 0.9, 0.0]]))
    assert measures.nss.tolist() == [0.0]
    assert measures.inside.all()


def test_bad_objects_are_named():
    with pytest.raises(InputError, match=r"strips.*graspable"):
        GraspableMask.of(strips(CUT, graspable=()), 1.0)
    flat = Part("flat", np.zeros((3, 3)), np.array([[0, 1, 2]]))
    with pytest.raises(InputError, match="no face with an area"):
        sample_surface(PartObject("nothing", (flat,)))
    with pytest.raises(InputError, match="got both"):
        sample_surface(PartObject("mixed", (flat, Part("cloud", np.zeros((1, 3))))))

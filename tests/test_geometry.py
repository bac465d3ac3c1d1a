"""Minimal boxes, hulls and gaps through the border: laws, closed forms, and trimesh as the peer."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from graft import _core

SEEDS = st.integers(0, 2**32 - 1)


def cloud(seed: int, count: int | None = None) -> np.ndarray:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 200)) if count is None else count
    return rng.normal(size=(count, 3)) * rng.uniform(0.05, 1.0, 3) @ Rotation.random(rng=rng).as_matrix()


def volume(points: np.ndarray) -> float:
    return float(8 * _core.oriented_box(np.ascontiguousarray(points))[2].prod())


MESHES = {
    "capsule": trimesh.creation.capsule(height=2.0, radius=0.4),
    "cone": trimesh.creation.cone(radius=0.7, height=1.3, sections=24),
    "cylinder": trimesh.creation.cylinder(radius=0.5, height=2.0, sections=40),
    "ring": trimesh.creation.torus(major_radius=1.0, minor_radius=0.2),
    "ball": trimesh.creation.icosphere(subdivisions=3),
    "globe": trimesh.creation.uv_sphere(radius=1.0, count=[16, 24]).convex_hull,
    "slab": trimesh.creation.box([1.0, 0.5, 0.001]),
}


@pytest.mark.parametrize("name", MESHES)
def test_never_larger_than_the_peers_box(name):
    points = np.ascontiguousarray(MESHES[name].vertices @ Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix())
    peer = trimesh.bounds.oriented_bounds(points)[1].prod()
    assert volume(points) <= peer * (1 + 1e-9)


@given(SEEDS)
@settings(max_examples=60, deadline=None)
def test_contains_its_points_and_is_smaller_than_other_boxes(seed):
    points = cloud(seed)
    center, axes, half = _core.oriented_box(points)
    assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) > 0
    assert (np.diff(half) <= 1e-12).all()
    reach = np.abs((points - center) @ axes).max(axis=0)
    assert_allclose(reach, half, rtol=1e-9, atol=1e-12)
    principal = np.linalg.svd(points - points.mean(axis=0))[2].T
    for frame in (np.eye(3), principal):
        assert 8 * half.prod() <= np.ptp(points @ frame, axis=0).prod() * (1 + 1e-9)
    assert 8 * half.prod() <= trimesh.bounds.oriented_bounds(points)[1].prod() * (1 + 1e-9)


@given(SEEDS, st.sampled_from([1e-6, 1e-2, 1.0, 1e6]))
@settings(max_examples=40, deadline=None)
def test_moves_with_its_points(seed, scale):
    points = cloud(seed, 80)
    center, axes, half = _core.oriented_box(points)
    turn = Rotation.from_rotvec(np.random.default_rng(seed).normal(size=3)).as_matrix()
    moved = np.ascontiguousarray((points @ turn.T + [0.3, -2.0, 1.0]) * scale)
    center_m, axes_m, half_m = _core.oriented_box(moved)
    # The search starts from the hull's own axes, but it is a search: one cloud in thousands falls into another minimum
    # in another pose, .14 % larger in the one that was met.
    assert_allclose(half_m.prod() / scale**3, half.prod(), rtol=5e-3)
    if abs(half_m.prod() / scale**3 / half.prod() - 1) > 1e-6:
        return
    assert_allclose(half_m / scale, half, rtol=1e-3)
    assert_allclose(center_m / scale, turn @ center + [0.3, -2.0, 1.0], atol=1e-3 * half[0])
    assert_allclose(np.abs((axes_m * (turn @ axes)).sum(axis=0)), 1.0, atol=1e-3)


@pytest.mark.parametrize(
    ("points", "half"),
    [
        (trimesh.creation.box([3.0, 2.0, 1.0]).vertices, [1.5, 1.0, 0.5]),
        (trimesh.creation.cylinder(radius=0.5, height=2.0, sections=64).vertices, [1.0, 0.5, 0.5]),
        # The minimal box of a regular tetrahedron is the cube whose face diagonals are its edges.
        (np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1.0]]), [1.0, 1.0, 1.0]),
    ],
    ids=["cuboid", "cylinder", "tetrahedron"],
)
def test_known_boxes(points, half):
    turn = Rotation.from_rotvec([0.4, 1.2, -0.3]).as_matrix()
    found = _core.oriented_box(np.ascontiguousarray(points @ turn.T))[2]
    assert_allclose(found, half, rtol=2e-3)


def test_small_hulls_against_a_brute_force_search():
    rng = np.random.default_rng(3)
    turns = Rotation.random(20_000, rng=rng).as_matrix()
    for seed in range(12):
        points = cloud(seed, 8)
        extents = np.ptp(np.einsum("pi,rij->rpj", points, turns), axis=1)
        assert volume(points) <= extents.prod(axis=1).min() * (1 + 1e-9)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_flat_straight_and_single_points(scale):
    turn = Rotation.from_rotvec([1.0, 0.2, 0.5]).as_matrix().T * scale
    square = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [1, 0.5, 0]], float)
    for points, half in (
        (square, [1, 0.5, 0]),
        (square * [1, 0, 0], [1, 0, 0]),
        (np.zeros((4, 3)), [0, 0, 0]),
        (np.ones((1, 3)), [0, 0, 0]),
    ):
        _, axes, found = _core.oriented_box(np.ascontiguousarray(points @ turn))
        assert_allclose(found / scale, half, atol=1e-9)
        assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)


@given(SEEDS, st.booleans())
@settings(max_examples=60, deadline=None)
def test_hull_is_qhulls(seed, on_a_grid):
    points = cloud(seed)
    # Points on a coarse grid: many on one plane, which is where rounding contradicts itself.
    points = np.round(points * 4) if on_a_grid else points
    if np.linalg.matrix_rank(points - points[0]) < 3:
        return
    vertices, faces = _core.convex_hull(points)
    a, b, c = vertices[faces].transpose(1, 0, 2)
    enclosed = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert_allclose(enclosed, ConvexHull(points).volume, rtol=1e-9)
    assert len(vertices) - 3 * len(faces) / 2 + len(faces) == 2


def test_bad_arguments_name_themselves():
    with pytest.raises(ValueError, match=r"points: expected at least one"):
        _core.oriented_box(np.empty((0, 3)))
    with pytest.raises(ValueError, match=r"points: expected shape \(n, 3\)"):
        _core.oriented_box(np.zeros((4, 2)))
    with pytest.raises(ValueError, match=r"points: expected finite"):
        _core.convex_hull(np.full((4, 3), np.nan))
    with pytest.raises(ValueError, match=r"faces: expected vertex indices"):
        _core.part_geometry(
            np.zeros((3, 3)), np.zeros((3, 3)), np.array([3]), np.array([[0, 1, 3]]), np.array([1]), 4, 0
        )
    with pytest.raises(ValueError, match=r"joints: expected part indices"):
        _core.part_adjacency(np.zeros((2, 2)), np.array([[0, 2]]), 0.1)


@given(SEEDS)
@settings(max_examples=40, deadline=None)
def test_gap_is_the_distance_of_the_boxes(seed):
    rng = np.random.default_rng(seed)
    centers = np.array([np.zeros(3), rng.normal(size=3) * 2])
    axes = np.ascontiguousarray(Rotation.random(2, rng=rng).as_matrix())
    half = rng.uniform(0.1, 0.8, (2, 3))
    gap = _core.box_gaps(centers, axes, half)
    assert_allclose(gap, gap.T)
    # Alternating projections onto two convex sets converge to a closest pair.
    point = centers[1]
    for _ in range(3000):
        for k in (0, 1):
            point = centers[k] + axes[k] @ np.clip(axes[k].T @ (point - centers[k]), -half[k], half[k])
    other = centers[0] + axes[0] @ np.clip(axes[0].T @ (point - centers[0]), -half[0], half[0])
    assert_allclose(gap[0, 1], np.linalg.norm(point - other), atol=2e-3)
    assert gap[0, 1] <= np.linalg.norm(point - other) + 1e-9

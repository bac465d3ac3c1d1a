import numpy as np
import pytest
from numpy.testing import assert_allclose

from graft import zoo
from graft.contact.canonical import CUBE_ROTATIONS, CanonicalFrame, CanonicalFrames, box_frame, turns_about
from graft.graph import build_graph


def test_cube_rotations_are_the_24_proper_ones_identity_first():
    assert_allclose(CUBE_ROTATIONS[0], np.eye(3))
    assert len({tuple(r.ravel()) for r in CUBE_ROTATIONS}) == 24
    assert_allclose(np.linalg.det(CUBE_ROTATIONS), 1.0)
    changed = [(np.diag(r) != 1).sum() for r in CUBE_ROTATIONS]
    assert changed == sorted(changed)


def test_frames_map_there_and_back():
    graph = build_graph(zoo.make("kettle", 0), descriptor=None)
    for index in range(len(graph.object.parts)):
        frame = box_frame(graph, index)
        canonical = frame.to_canonical(graph.points[index])
        assert np.abs(canonical).max() <= 1 + 1e-9
        assert_allclose(frame.to_object(canonical), graph.points[index], atol=1e-12)


def test_directions_keep_their_length_under_a_distorting_box():
    frame = CanonicalFrame(np.eye(3), np.zeros(3), np.array([3.0, 2.0, 1.0]))
    assert_allclose(np.linalg.norm(frame.directions(np.eye(3)), axis=1), 1.0)


@pytest.mark.parametrize("axis", range(3))
def test_turns_are_rotations_about_their_axis(axis):
    angles = np.linspace(-3.0, 3.0, 7)
    turns = turns_about(axis, angles)
    assert_allclose(turns @ turns.transpose(0, 2, 1), np.broadcast_to(np.eye(3), turns.shape), atol=1e-12)
    assert_allclose(turns @ np.eye(3)[axis], np.tile(np.eye(3)[axis], (7, 1)))
    assert_allclose(np.trace(turns, axis1=1, axis2=2), 1.0 + 2.0 * np.cos(angles))
    # Right-handed: a quarter turn takes the next axis to the one after.
    quarter = turns_about(axis, np.array([np.pi / 2]))[0]
    assert_allclose(quarter @ np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3], atol=1e-12)


def test_fitted_frames_are_tight_in_every_direction():
    points = np.random.default_rng(0).normal(size=(200, 3)) * [3.0, 2.0, 1.0]
    frames = CanonicalFrames.fitted(points, turns_about(1, np.linspace(0, 1, 5)), floor=1e-6)
    canonical = frames.to_canonical(points)
    assert_allclose(canonical.max(axis=1), 1.0)
    assert_allclose(canonical.min(axis=1), -1.0)
    for row in range(len(frames)):
        assert_allclose(canonical[row], frames.one(row).to_canonical(points), atol=1e-12)


def test_a_flat_set_of_points_gets_the_floor_thickness():
    points = np.random.default_rng(0).normal(size=(50, 3)) * [1.0, 1.0, 0.0]
    frame = CanonicalFrames.fitted(points, np.eye(3)[None], floor=1e-3).one(0)
    assert frame.half_extents[2] == 1e-3
    assert np.isfinite(frame.to_canonical(points)).all()


def test_permuted_frames_bound_the_same_box():
    frame = CanonicalFrame(turns_about(0, np.array([0.3]))[0], np.array([1.0, 2.0, 3.0]), np.array([3.0, 2.0, 1.0]))
    frames = CanonicalFrames.of([frame]).permuted()
    corners = frame.to_object(np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0]]))
    assert len(frames) == 24
    assert_allclose(np.abs(frames.to_canonical(corners)), 1.0)

"""MimicGen's formula, its laws, and what becomes of demonstrations that are replayed."""

from dataclasses import replace

import numpy as np
import pytest
from generation_scenes import demonstration, shown
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

pytest.importorskip("mujoco")

from graft.datagen.retarget import HOLD, carried, retargeted, source_of, upright_frame
from graft.datagen.rotations import interpolated, rotation_about, rotation_vector
from graft.errors import InputError
from graft.grasp.conventions import rigid_inverse

SEEDS = st.integers(0, 2**32 - 1)


def poses(seed, count=1):
    rng = np.random.default_rng(seed)
    result = np.tile(np.eye(4), (count, 1, 1))
    result[:, :3, :3] = Rotation.random(count, rng=rng).as_matrix()
    result[:, :3, 3] = rng.normal(size=(count, 3))
    return result


@given(SEEDS)
@settings(max_examples=30, deadline=None)
def test_small_rotations_agree_with_scipy(seed):
    rotation = poses(seed)[0, :3, :3]
    vector = Rotation.from_matrix(rotation).as_rotvec()
    np.testing.assert_allclose(rotation_vector(rotation), vector, atol=1e-9)
    np.testing.assert_allclose(rotation_about(vector), rotation, atol=1e-12)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0.8, 0)])
def test_half_turns_have_an_axis(axis):
    rotation = rotation_about(np.pi * np.array(axis, float))
    np.testing.assert_allclose(rotation_about(rotation_vector(rotation)), rotation, atol=1e-7)


@given(SEEDS)
@settings(max_examples=30, deadline=None)
def test_the_motion_relative_to_the_frame_is_the_sources(seed):
    source, new, *targets = poses(seed, 7)
    moved = retargeted(np.array(targets), source, new)
    np.testing.assert_allclose(rigid_inverse(new) @ moved, rigid_inverse(source) @ np.array(targets), atol=1e-9)
    np.testing.assert_allclose(retargeted(np.array(targets), source, source), targets, atol=1e-9)


@given(SEEDS, st.floats(-3, 3))
@settings(max_examples=30, deadline=None)
def test_what_is_carried_rises_as_in_the_source_however_it_was_taken(seed, heading):
    start, new, place, center = poses(seed, 4)
    targets = np.repeat(start[None], 5, axis=0)
    targets[:, 2, 3] += 0.03 * np.arange(5)
    old = upright_frame(start[:3, 3], start[:3, 3] + (np.cos(heading), np.sin(heading), 0))
    moved = carried(targets, old, upright_frame(place[:3, 3], center[:3, 3]), new)
    np.testing.assert_allclose(moved[:, :3, 3] - new[:3, 3], np.outer(0.03 * np.arange(5), (0, 0, 1)), atol=1e-9)
    np.testing.assert_allclose(moved[:, :3, :3], np.repeat(new[None, :3, :3], 5, axis=0), atol=1e-9)


def test_a_tilt_goes_the_way_that_the_object_faces():
    towards_x, towards_y = (
        upright_frame(np.zeros(3), np.array([1.0, 0, 0])),
        upright_frame(np.zeros(3), np.array([0, 1.0, 0])),
    )
    tilt = np.eye(4)
    tilt[:3, :3] = rotation_about(np.array([0, 0.5, 0]))
    moved = carried(np.array([np.eye(4), tilt]), towards_x, towards_y, np.eye(4))
    np.testing.assert_allclose(rotation_vector(moved[1, :3, :3]), (-0.5, 0, 0), atol=1e-12)


def test_upright_frames_stand_upright_also_above_the_center():
    assert upright_frame(np.array([0.1, 0.2, 0.3]), np.array([0.1, 0.2, 0.0]))[:3, :3].tolist() == np.eye(3).tolist()


def test_interpolation_is_even_and_ends_where_it_should():
    begin, end = poses(3, 2)
    steps = interpolated(begin, end, 5)
    assert steps[-1].tolist() == end.tolist()
    np.testing.assert_allclose(
        np.diff([begin[:3, 3], *steps[:, :3, 3]], axis=0), np.tile((end - begin)[:3, 3] / 5, (5, 1))
    )


def test_a_source_is_replayed_without_its_hold():
    source = source_of(demonstration())
    assert [s.name for s in source.trajectory.segments] == ["reach", "grasp", "lift"]
    assert source.reach == 1
    assert source.trajectory.gripper[source.closing - 1] < 0 < source.trajectory.gripper[source.closing]


def test_a_reach_is_cut_off_where_the_source_has_one_segment():
    given = demonstration()
    whole = replace(given.trajectory, segments=())
    source = source_of(replace(given, trajectory=whole, grasp=None))
    assert [s.name for s in source.trajectory.segments] == ["reach", "all"]
    way = source.targets(1)[0, :3, 3] - whole.T_world_target[source.closing, :3, 3]
    assert np.linalg.norm(way) == pytest.approx(0.08, abs=0.015)
    # Not told where it was taken, the pose that was reached when it closed counts.
    np.testing.assert_allclose(source.grasp, given.grasp, atol=2e-3)


def test_what_is_done_to_other_objects_is_left_out():
    given = demonstration()
    trajectory, steps = given.trajectory, len(given.trajectory)
    poses = {**trajectory.T_world_object, "machine": np.tile(np.eye(4), (steps, 1, 1))}
    segments = (*trajectory.segments[:2], *(replace(s, anchor="machine") for s in trajectory.segments[2:]))
    source = source_of(replace(given, trajectory=replace(trajectory, T_world_object=poses, segments=segments)))
    assert [s.name for s in source.trajectory.segments] == ["reach", "grasp"]


def test_what_cannot_be_replayed_is_named():
    given = demonstration()
    part = given.trajectory.segments[-1]
    with pytest.raises(InputError, match="'source': it has no trajectory to replay"):
        source_of(shown())
    with pytest.raises(InputError, match="its gripper never closes"):
        source_of(replace(given, trajectory=replace(given.trajectory, gripper=-np.ones(len(given.trajectory)))))
    with pytest.raises(InputError, match=f"no segment of the object that is taken, beside '{HOLD}'"):
        source_of(replace(given, trajectory=given.trajectory.subset(part.start, part.end)))

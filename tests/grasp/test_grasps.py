"""Sets of grasps: order, thinning, joining, other frames, other conventions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from graft.errors import InputError
from graft.grasp import (
    CONVENTIONS,
    PANDA_HAND,
    ROBOTIQ_2F85,
    Box,
    GraspSet,
    Gripper,
    from_convention,
    to_convention,
)
from graft.grasp.conventions import rigid_inverse
from graft.grasp.grasps import angles_between

FLANGE = np.eye(4)
FLANGE[:3, :3] = Rotation.from_rotvec([0.1, 0.2, -0.7]).as_matrix()
FLANGE[:3, 3] = (0.01, -0.02, 0.13)
OBLIQUE = Gripper("oblique", 0.05, (), (Box.spanning((-0.01, 0, -0.01), (0.01, 0.01, 0.01)),), FLANGE)


def some_poses(n, seed=0):
    random = np.random.default_rng(seed)
    poses = np.tile(np.eye(4), (n, 1, 1))
    poses[:, :3, :3] = Rotation.random(n, rng=random).as_matrix()
    poses[:, :3, 3] = random.uniform(-0.3, 0.3, (n, 3))
    return poses


def some(n, seed=0, gripper=PANDA_HAND, **fields):
    random = np.random.default_rng(seed)
    return GraspSet(
        some_poses(n, seed),
        random.uniform(0, 0.08, n),
        random.normal(size=n),
        random.normal(size=(n, 2, 3)),
        random.uniform(size=n),
        gripper,
        **fields,
    )


def around(angle, offset=(0.0, 0.0, 0.0), axis="z"):
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler(axis, angle, degrees=True).as_matrix()
    pose[:3, 3] = offset
    return pose


def of(poses, scores):
    n = len(poses)
    return GraspSet(poses, np.zeros(n), scores, np.zeros((n, 2, 3)), np.zeros(n), PANDA_HAND)


def test_sorting_puts_the_best_first_and_keeps_ties():
    grasps = of([around(0, (i, 0, 0)) for i in range(5)], [1.0, 3.0, 1.0, 3.0, 2.0])
    np.testing.assert_array_equal(grasps.sorted().poses[:, 0, 3], [1, 3, 4, 0, 2])
    np.testing.assert_array_equal(grasps.top(2).poses[:, 0, 3], [1, 3])
    assert len(grasps.top(9)) == 5


def test_a_mask_indices_and_a_slice_choose_the_same():
    grasps = some(6, terms={"cone": np.arange(6.0)})
    mask = np.array([False, True, True, False, False, True])
    for chosen in (grasps[mask], grasps[np.array([1, 2, 5])]):
        np.testing.assert_array_equal(chosen.scores, grasps.scores[[1, 2, 5]])
        np.testing.assert_array_equal(chosen.terms["cone"], [1, 2, 5])
    assert len(grasps[2:4]) == 2
    assert grasps[-1].score == grasps.scores[5]
    with pytest.raises(IndexError):
        grasps[6]


def test_nms_keeps_the_best_of_those_that_are_alike():
    poses = [around(0), around(10), around(20), around(0, (0.02, 0, 0)), around(180), around(0, axis="x"), around(90)]
    kept = of(poses, [5.0, 9.0, 4.0, 3.0, 2.0, 1.0, 0.0]).nms(translation=0.01, rotation=np.radians(12))
    # 10 degrees is best; 0, 20 and, fingers changed, 180 are alike; the one 2 cm away and the one at 90 are not.
    np.testing.assert_array_equal(kept.scores, [9.0, 3.0, 0.0])


def test_nms_of_other_approaches_keeps_them():
    poses = [around(0), around(180, axis="x"), around(180, axis="y"), around(180, axis="z")]
    assert len(of(poses, [4.0, 3.0, 2.0, 1.0]).nms(rotation=0.1)) == 2  # the turns about x and y differ by one about z


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 40), st.floats(0.0, 0.3), st.floats(0.0, 3.0), st.integers(0, 1000))
def test_nms_leaves_no_two_alike_and_drops_none_without_a_better_one(n, translation, rotation, seed):
    grasps = some(n, seed)
    kept = grasps.nms(translation, rotation)
    scores = set(kept.scores.tolist())

    def alike(a, b):
        near = np.linalg.norm(a.pose[:3, 3] - b.pose[:3, 3]) <= translation
        return near and angles_between(a.pose[None, :3, :3], b.pose[:3, :3])[0] <= rotation

    assert not any(alike(a, b) for i, a in enumerate(kept) for b in list(kept)[:i])
    for grasp in grasps:
        if grasp.score not in scores:
            assert any(alike(grasp, better) and better.score >= grasp.score for better in kept)


def test_nms_refuses_what_is_no_bound():
    with pytest.raises(InputError, match="nms rotation"):
        some(2).nms(rotation=-1.0)
    with pytest.raises(InputError, match="nms translation"):
        some(2).nms(translation=np.nan)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000))
def test_angles_agree_with_scipy(seed):
    first, second = Rotation.random(2, rng=np.random.default_rng(seed))
    turn = Rotation.from_rotvec([0, 0, np.pi])
    expected = min((first.inv() * second).magnitude(), (first.inv() * second * turn).magnitude())
    found = angles_between(first.as_matrix()[None], second.as_matrix())[0]
    assert found == pytest.approx(expected, abs=1e-7)
    assert found <= np.pi + 1e-12


def test_joined_sets_have_all_grasps_and_what_they_share():
    first = some(
        3, 1, terms={"cone": np.ones(3), "lever": np.ones(3)}, rejected={"palm": 2}, metadata={"seed": 1, "k": 3}
    )
    second = some(2, 2, terms={"cone": np.zeros(2)}, rejected={"palm": 1, "pad": 4}, metadata={"seed": 2, "k": 3})
    both = GraspSet.concatenate([first, second])
    np.testing.assert_array_equal(both.poses, np.concatenate([first.poses, second.poses]))
    assert list(both.terms) == ["cone"]
    assert both.rejected == {"palm": 3, "pad": 4}
    assert both.metadata == {"k": 3}
    with pytest.raises(InputError, match="'panda_hand' and 'robotiq_2f85'"):
        GraspSet.concatenate([first, some(1, gripper=ROBOTIQ_2F85)])
    with pytest.raises(InputError, match="at least one"):
        GraspSet.concatenate([])


def test_an_empty_set_says_why():
    none = GraspSet.empty(PANDA_HAND, {"too wide": 7})
    assert len(none) == 0
    assert none.rejected == {"too wide": 7}
    assert len(none.nms()) == len(none.top(3)) == len(GraspSet.concatenate([none, none])) == 0


def test_grasps_move_with_the_object():
    grasps, motion = some(4), some_poses(1, 9)[0]
    moved = grasps.transformed(motion)
    local = np.einsum("nji,nkj->nki", grasps.poses[:, :3, :3], grasps.contacts - grasps.poses[:, None, :3, 3])
    again = np.einsum("nji,nkj->nki", moved.poses[:, :3, :3], moved.contacts - moved.poses[:, None, :3, 3])
    np.testing.assert_allclose(again, local, atol=1e-12)
    with pytest.raises(InputError, match="rotation and a translation"):
        grasps.transformed(2 * np.eye(4))


def test_a_pose_that_is_no_motion_is_refused_with_its_number():
    poses = some_poses(3)
    poses[1, :3, :3] *= 1.1
    with pytest.raises(InputError, match=r"pose 1: expected a rotation"):
        of(poses, [1.0, 2.0, 3.0])
    mirrored = some_poses(3)
    mirrored[2, :3, 0] *= -1
    with pytest.raises(InputError, match=r"pose 2: expected a rotation"):
        of(mirrored, [1.0, 2.0, 3.0])
    with pytest.raises(InputError, match="finite"):
        of(np.full((1, 4, 4), np.nan), [1.0])


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("gripper", [PANDA_HAND, OBLIQUE], ids=lambda g: g.name)
def test_conventions_have_inverses(convention, gripper):
    poses = some_poses(20)
    there = to_convention(poses, convention, gripper)
    np.testing.assert_allclose(from_convention(there, convention, gripper), poses, atol=1e-15)
    np.testing.assert_allclose(np.linalg.det(there[:, :3, :3]), 1.0)
    np.testing.assert_array_equal(to_convention(poses[3], convention, gripper), there[3])


def test_conventions_name_approach_and_closing():
    pose = some_poses(1, 4)[0]
    approach, closing = pose[:3, 2], pose[:3, 1]
    graspnet = to_convention(pose, "graspnet", PANDA_HAND)
    graspgen = to_convention(pose, "graspgen", PANDA_HAND)
    np.testing.assert_array_equal(graspnet[:3, :2].T, [approach, closing])
    np.testing.assert_array_equal(graspgen[:3, [2, 0]].T, [approach, closing])
    np.testing.assert_array_equal(graspnet[:3, 3], pose[:3, 3])
    # The base of a Panda's hand lies 10.34 cm behind the TCP.
    np.testing.assert_allclose(graspgen[:3, 3], pose[:3, 3] - 0.1034 * approach)
    np.testing.assert_allclose(to_convention(pose, "flange", PANDA_HAND)[:3, 3], pose[:3, 3] - 0.1034 * approach)
    np.testing.assert_array_equal(to_convention(pose, "panda", PANDA_HAND), pose)


def test_the_flange_carries_the_tcp():
    pose = some_poses(1, 5)[0]
    np.testing.assert_allclose(to_convention(pose, "flange", OBLIQUE) @ FLANGE, pose, atol=1e-15)
    np.testing.assert_allclose(rigid_inverse(FLANGE) @ FLANGE, np.eye(4), atol=1e-15)


def test_other_conventions_and_shapes_are_refused():
    with pytest.raises(InputError, match="one of panda, graspnet, graspgen, flange, got 'dexnet'"):
        to_convention(np.eye(4), "dexnet", PANDA_HAND)
    with pytest.raises(InputError, match=r"shape \(..., 4, 4\), got \(3, 3\)"):
        from_convention(np.eye(3), "panda", PANDA_HAND)

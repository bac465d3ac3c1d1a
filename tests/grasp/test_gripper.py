"""Grippers as data: boxes, the built-in hands, what is refused."""

import numpy as np
import pytest

from graft.errors import InputError
from graft.grasp import PANDA_HAND, ROBOTIQ_2F85, Box, Gripper

PAD = Box.spanning((-0.01, 0.0, -0.01), (0.01, 0.01, 0.01))
BOTH = pytest.mark.parametrize("gripper", [PANDA_HAND, ROBOTIQ_2F85], ids=lambda g: g.name)


def turned(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def test_a_box_spans_its_corners():
    box = Box.spanning((-1.0, 0.0, 2.0), (3.0, 1.0, 5.0))
    np.testing.assert_array_equal(box.corners.min(axis=0), (-1.0, 0.0, 2.0))
    np.testing.assert_array_equal(box.corners.max(axis=0), (3.0, 1.0, 5.0))


def test_the_mirror_image_of_a_box_has_the_mirrored_corners():
    box = Box((0.01, 0.02, 0.03), (0.001, 0.002, 0.003), turned(0.4))
    mirrored = {tuple(np.round(c * [1, -1, 1], 12)) for c in box.corners}
    assert {tuple(np.round(c, 12)) for c in box.mirrored().corners} == mirrored
    assert np.linalg.det(box.mirrored().rotation) == pytest.approx(1.0)


@BOTH
@pytest.mark.parametrize("opening", [0.0, 0.03, 0.08])
def test_the_pads_are_as_far_apart_as_the_gripper_is_open(gripper, opening):
    boxes = gripper.boxes(opening)
    fingers = boxes[len(gripper.palm) :]
    right, left = fingers[0], fingers[len(gripper.finger)]
    assert right.corners[:, 1].min() == pytest.approx(opening / 2)
    assert left.corners[:, 1].max() == pytest.approx(-opening / 2)
    assert all(box.corners[:, 2].max() < gripper.pad.corners[:, 2].min() for box in gripper.palm)


@BOTH
def test_the_tcp_lies_in_the_middle_of_the_pads(gripper):
    np.testing.assert_allclose(gripper.pad.center[[0, 2]], 0.0, atol=1e-12)


def test_the_panda_has_the_sizes_of_its_data_sheet():
    assert PANDA_HAND.stroke == 0.08
    assert PANDA_HAND.reach == pytest.approx(0.1034)
    extents = np.ptp(PANDA_HAND.palm[0].corners, axis=0)
    np.testing.assert_allclose(extents, (0.063, 0.205, 0.066))
    # The palm begins at the flange.
    assert PANDA_HAND.palm[0].corners[:, 2].min() == pytest.approx(-PANDA_HAND.reach)


def test_the_reach_follows_a_turned_flange():
    flange = np.eye(4)
    flange[:3, :3] = turned(np.pi / 4)
    flange[:3, 3] = (0.0, 0.0, 0.12)
    assert Gripper("turned", 0.05, (), (PAD,), flange).reach == pytest.approx(0.12)


def test_a_gripper_is_like_one_of_another_name_and_unlike_one_of_another_shape():
    twin = Gripper("twin", 0.05, (), (PAD,))
    assert twin.is_like(Gripper("other", 0.05, (), (PAD,), force=3.0))
    assert not twin.is_like(Gripper("twin", 0.06, (), (PAD,)))
    assert not twin.is_like(Gripper("twin", 0.05, (PAD,), (PAD,)))
    assert not PANDA_HAND.is_like(ROBOTIQ_2F85)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"stroke": 0.0}, "stroke: expected a positive number, got 0.0"),
        ({"stroke": np.nan}, "stroke"),
        ({"finger": ()}, "at least one box, the pad"),
        ({"name": ""}, "expected a name"),
        ({"force": 100.0}, "at most max_force 70 N, got 100 N"),
        ({"flange": 2 * np.eye(4)}, "flange: expected a rotation"),
        ({"finger": (PAD.moved(np.array([0.0, 0.01, 0.0])),)}, "at y = 0, got y = 0.01"),
    ],
)
def test_a_gripper_that_cannot_be_is_refused(fields, message):
    with pytest.raises(InputError, match=message):
        Gripper(**{"name": "g", "stroke": 0.05, "palm": (), "finger": (PAD,), **fields})


@pytest.mark.parametrize(
    ("box", "message"),
    [
        (lambda: Box((0, 0, 0), (1, 0, 1)), "positive"),
        (lambda: Box((0, 0, 0), (1, 1, 1), np.diag([1.0, 1.0, -1.0])), "rotation matrix"),
        (lambda: Box((0, 0, np.inf), (1, 1, 1)), "finite"),
    ],
)
def test_a_box_that_cannot_be_is_refused(box, message):
    with pytest.raises(InputError, match=message):
        box()

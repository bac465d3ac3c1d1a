import numpy as np
import pytest
from motion_scenes import beside, down, mug

from graft.errors import InputError
from graft.grasp import PANDA_HAND, Grasp
from graft.motion import plan_approach

OBJECT, TABLE = mug()
START = beside(OBJECT, -1, 0.2)


def grasp(pose, width=0.016):
    return Grasp(pose, width, 1.0, np.zeros((2, 3)), 0.0, PANDA_HAND)


def on_handle():
    """The pads beside the handle, the hand coming along -x."""
    pose = np.eye(4)
    pose[:3, :3] = np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]])
    pose[:3, 3] = OBJECT.bounds[1][0] - 0.01, 0.0, 0.055
    return pose


def test_three_legs_meet():
    plan = plan_approach(OBJECT, grasp(on_handle()), START, support=TABLE)
    assert plan.found
    assert plan.opening == PANDA_HAND.stroke
    assert np.array_equal(plan.transit.poses[0], START)
    assert np.allclose(plan.transit.poses[-1], plan.straight.poses[0])
    assert np.allclose(plan.straight.poses[-1], on_handle())
    assert np.allclose(plan.straight.poses[-1], plan.lift.poses[0])


def test_the_end_is_straight_along_the_approach_and_the_lift_along_up():
    plan = plan_approach(OBJECT, grasp(on_handle()), START, support=TABLE, straight=0.06, lift=0.12)
    assert np.allclose(plan.straight.poses[1][:3, 3] - plan.straight.poses[0][:3, 3], 0.06 * on_handle()[:3, 2])
    assert np.allclose(plan.lift.poses[1][:3, 3] - plan.lift.poses[0][:3, 3], 0.12 * TABLE.normal)
    assert np.allclose(plan.straight.poses[:, :3, :3], on_handle()[:3, :3])
    assert np.allclose(plan.lift.poses[:, :3, :3], on_handle()[:3, :3])


def test_fingers_open_less_where_the_stroke_does_not_fit():
    # Across the wall from above, one finger in the mug: fully open, the other fingertip or the first is in a wall.
    wall = down([0.0, OBJECT.bounds[1][1] - 0.0015, OBJECT.bounds[1][2] - 0.012])
    plan = plan_approach(OBJECT, grasp(wall, 0.004), START, support=TABLE)
    assert plan.found
    assert plan.opening <= PANDA_HAND.stroke


def test_says_what_is_blocked():
    through = down([0.0, 0.0, 0.01])
    through[:3, :3] = np.diag([1.0, 1.0, 1.0])  # from below the table
    plan = plan_approach(OBJECT, grasp(through), START, support=TABLE)
    assert not plan.found
    assert plan.reason.startswith("the last 8 cm to the grasp are blocked, at openings 80, 36, 26, 21 mm")
    inside = down([0.04, 0.0, 0.05])
    plan = plan_approach(OBJECT, grasp(on_handle()), inside, support=TABLE)
    assert plan.reason.startswith("to the pre-grasp: start in collision")
    assert not plan.straight.found
    assert not plan.lift.found


def test_bad_input():
    with pytest.raises(InputError, match="opening"):
        plan_approach(OBJECT, grasp(on_handle()), START, opening=0.2)
    with pytest.raises(InputError, match="grasp pose"):
        plan_approach(OBJECT, grasp(np.zeros((4, 4))), START)
    for name in ("straight", "lift"):
        with pytest.raises(InputError, match=name):
            plan_approach(OBJECT, grasp(on_handle()), START, **{name: float("nan")})

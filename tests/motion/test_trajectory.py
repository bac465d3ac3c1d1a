import numpy as np
import pytest
from motion_scenes import beside, mug
from scipy.spatial.transform import Rotation

from graft.errors import InputError
from graft.grasp import PANDA_HAND
from graft.motion import Motion, MotionConfig, plan_motion
from graft.motion.trajectory import no_motion, stamp

OBJECT, TABLE = mug()


@pytest.fixture(scope="module")
def motion():
    config = MotionConfig(linear_speed=0.1, angular_speed=0.7)
    start = beside(OBJECT, -1, 0.06) @ np.diag([-1.0, -1.0, 1.0, 1.0])
    return plan_motion(OBJECT, start, beside(OBJECT, 1, 0.06), PANDA_HAND, support=TABLE, config=config)


def test_no_speed_is_exceeded(motion):
    sampled = motion.sampled(0.01)
    steps = np.diff(sampled.times)
    ways = np.linalg.norm(np.diff(sampled.poses[:, :3, 3], axis=0), axis=1)
    turns = np.swapaxes(sampled.poses[:-1, :3, :3], 1, 2) @ sampled.poses[1:, :3, :3]
    assert (ways <= 0.1 * steps + 1e-9).all()
    assert (Rotation.from_matrix(turns).magnitude() <= 0.7 * steps + 1e-6).all()
    # One of the two is at its limit all the time between corners.
    assert np.median(np.maximum(ways / steps / 0.1, Rotation.from_matrix(turns).magnitude() / steps / 0.7)) > 0.999


def test_waypoints_are_passed_on_time(motion):
    assert motion.times[0] == 0.0
    assert np.allclose(motion.at(motion.times), motion.poses, atol=1e-9)
    sampled = motion.sampled(0.03)
    assert sampled.times[-1] == motion.duration
    assert np.allclose(sampled.poses[-1], motion.poses[-1], atol=1e-9)


def test_it_stands_still_before_and_after(motion):
    before, after = motion.at([-1.0, motion.duration + 1.0])
    assert np.allclose(before, motion.poses[0])
    assert np.allclose(after, motion.poses[-1])


def test_waypoints_that_coincide():
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[2, 0, 3] = 0.1
    motion = Motion(poses, stamp(poses, 0.1, 1.0))
    assert motion.duration == pytest.approx(1.0)
    assert motion.at([0.5])[0, 0, 3] == pytest.approx(0.05)
    still = Motion(poses[:2], stamp(poses[:2], 0.1, 1.0))
    assert still.sampled(0.1).poses.shape == (2, 4, 4)
    assert np.allclose(still.at([0.0, 3.0]), np.eye(4))


def test_bad_periods(motion):
    for period in (0.0, -1.0, float("nan")):
        with pytest.raises(InputError, match="period"):
            motion.sampled(period)
    with pytest.raises(InputError, match="blocked"):
        no_motion("blocked").sampled(0.1)

"""Damaged files of grasps and grippers: read or refused in one line, never anything else."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graft.errors import InputError
from graft.grasp import PANDA_HAND, ROBOTIQ_2F85, GraspSet, load_grasps, load_gripper, save_grasps, save_gripper

POSES = np.tile(np.eye(4), (3, 1, 1))
GRASPS = GraspSet(
    POSES,
    np.full(3, 0.02),
    np.arange(3.0),
    np.zeros((3, 2, 3)),
    np.zeros(3),
    ROBOTIQ_2F85,
    {"cone": np.ones(3)},
    {"a": 1},
)

SETTINGS = settings(
    max_examples=150, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
DAMAGE = st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), min_size=1, max_size=6)


def damaged(data, changes, cut):
    broken = bytearray(data)
    for place, value in changes:
        broken[place % len(broken)] = value
    return bytes(broken[: len(broken) - cut % len(broken)])


def read(load, path):
    """Return what is read, or None where it is refused as it should be."""
    try:
        return load(path)
    except InputError as error:
        message = str(error)
    assert str(path) in message
    assert "\n" not in message
    return None


@pytest.mark.parametrize("suffix", [".npz", ".npy", ".json"])
@SETTINGS
@given(DAMAGE, st.just(0) | st.integers(0, 10**6))
def test_damaged_grasps(tmp_path, suffix, changes, cut):
    path = tmp_path / f"g{suffix}"
    save_grasps(path, GRASPS)
    path.write_bytes(damaged(path.read_bytes(), changes, cut))
    grasps = read(load_grasps, path)
    assert grasps is None or (np.isfinite(grasps.poses).all() and np.isfinite(grasps.scores).all())


@SETTINGS
@given(DAMAGE, st.just(0) | st.integers(0, 10**6))
def test_damaged_grippers(tmp_path, changes, cut):
    path = tmp_path / "g.toml"
    save_gripper(path, PANDA_HAND)
    path.write_bytes(damaged(path.read_bytes(), changes, cut))
    gripper = read(load_gripper, path)
    assert gripper is None or gripper.stroke > 0

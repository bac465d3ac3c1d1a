"""Demonstrations by script."""

import numpy as np
import pytest
from generation_scenes import demonstration, shown

pytest.importorskip("mujoco")

from graft.datagen.scripted import LIFT, demonstrate  # noqa: E402
from graft.errors import InputError  # noqa: E402
from graft.grasp import ROBOTIQ_2F85  # noqa: E402
from graft.io import load_demonstration, save_demonstration  # noqa: E402
from graft.trajectory import DEMONSTRATED  # noqa: E402


def test_a_lift_is_recorded_with_its_segments():
    made = demonstration()
    trajectory = made.trajectory
    assert [(s.name, s.anchor, s.signal) for s in trajectory.segments] == [
        ("reach", DEMONSTRATED, "reached"),
        ("grasp", DEMONSTRATED, "grasped"),
        ("lift", DEMONSTRATED, "lifted"),
        ("hold", DEMONSTRATED, None),
    ]
    placed = trajectory.T_world_object[DEMONSTRATED]
    assert placed[-1, 2, 3] - placed[0, 2, 3] == pytest.approx(LIFT, abs=0.01)
    np.testing.assert_allclose(np.diff(trajectory.times), 0.05)
    # What was told and what was reached agree without noise.
    apart = np.linalg.norm((trajectory.T_world_target[:-1] - trajectory.T_world_gripper[1:])[:, :3, 3], axis=1)
    assert apart.max() < 0.01
    closed = trajectory.T_world_target[trajectory.segments[1].end - 1]
    np.testing.assert_allclose(closed, placed[0] @ made.grasp, atol=2e-3)


def test_it_survives_being_saved(tmp_path):
    made = demonstration()
    save_demonstration(tmp_path / "one", made)
    read = load_demonstration(tmp_path / "one")
    assert read.trajectory.T_world_target.tolist() == made.trajectory.T_world_target.tolist()
    assert read.metadata["task"] == "lift"


def test_another_gripper_demonstrates():
    made = demonstrate(shown(), ROBOTIQ_2F85)
    assert made.metadata["gripper"] == "robotiq_2f85"


def test_what_no_gripper_holds_is_one_line():
    with pytest.raises(InputError, match="object 'wide': gripper 'panda_hand' cannot hold it at the contact"):
        demonstrate(shown("wide", 0.2, 0.2, 0.1))

"""Ramps, noise and turns."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from graft.sim import SimulationConfig
from graft.sim.course import RAMP, ramped, reached, turned


@pytest.mark.parametrize("distance", [0.001, 0.02, 0.2, 1.0])
def test_ramps_arrive_smoothly(distance: float) -> None:
    way = np.concatenate([[0.0], ramped(distance, 0.25, 0.002)])
    assert way[-1] == pytest.approx(distance, abs=1e-12)
    speed = np.diff(way) / 0.002
    assert speed.min() >= 0
    assert speed.max() <= 0.25 * (1 + 1e-9)
    assert np.abs(np.diff(speed)).max() <= 0.25 / RAMP * 0.002 * (1 + 1e-6)


def test_without_noise_the_hand_arrives_exactly() -> None:
    wanted = np.eye(4)
    wanted[:3, :3] = turned(np.array([0.0, 0.6, 0.8]), 1.0)
    assert np.array_equal(reached(wanted, SimulationConfig()), wanted)


def test_noise_has_the_size_that_is_asked_for() -> None:
    poses = [reached(np.eye(4), SimulationConfig(position_noise=0.01, seed=seed)) for seed in range(500)]
    places = np.array([pose[:3, 3] for pose in poses])
    assert places.std() == pytest.approx(0.01, rel=0.1)
    assert all(np.array_equal(pose[:3, :3], np.eye(3)) for pose in poses)


def test_turns_are_rotations() -> None:
    rotation = turned(np.array([0.0, 0.0, 1.0]), np.pi / 2)
    assert np.allclose(rotation @ (1, 0, 0), (0, 1, 0))


def test_without_mujoco_one_line_names_the_extra() -> None:
    code = (
        "import sys; sys.modules['mujoco'] = None\n"
        "from graft import errors, sim, zoo\n"
        "try: sim.prepare(zoo.make('phone', 0))\n"
        "except errors.MissingExtraError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "physics needs mujoco: pip install 'graft-robotics[sim]'\n"

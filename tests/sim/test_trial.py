"""Scenes built to cause each outcome, and the numbers behind them."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from sim_scenes import ALONG_X, DOWN, box, channel, grasp, mesh_object

from graft import zoo
from graft.errors import InputError
from graft.sim import Outcome, PreparedObject, SimulationConfig, Trial, prepare, random_poses, simulate_grasp
from graft.sim.trial import run_trial

GRIP = grasp((0, 0, 0.08))


@pytest.fixture(scope="module")
def block() -> PreparedObject:
    return prepare(box(0.05, 0.05, 0.1))


def test_a_box_is_held(block: PreparedObject) -> None:
    trial = simulate_grasp(block, GRIP)
    m = trial.measurements
    assert trial.outcome is Outcome.SUCCESS
    assert trial.succeeded
    assert m.closed_forces == pytest.approx((15, 15), abs=0.1)
    assert m.final_forces == pytest.approx((15, 15), abs=0.1)
    assert m.closed_width == pytest.approx(0.05, abs=5e-4)
    assert m.rise == pytest.approx(0.2, abs=2e-3)
    assert m.slip_distance is not None
    assert m.slip_distance < 1e-3
    assert (m.touched_before_closing, m.table_contact) == (False, False)
    assert trial.warnings == ()


def test_the_force_does_not_depend_on_the_width() -> None:
    for width in (0.01, 0.03, 0.07):
        trial = simulate_grasp(prepare(box(0.05, width, 0.1)), replace(GRIP, width=width), SimulationConfig(force=20))
        assert trial.succeeded
        assert trial.measurements.closed_forces == pytest.approx((20, 20), abs=0.3)
        assert trial.measurements.closed_width == pytest.approx(width, abs=7e-4)


def test_beside_the_object_is_a_grasp_failure(block: PreparedObject) -> None:
    trial = simulate_grasp(block, grasp((0.12, 0, 0.06)))
    assert trial.outcome is Outcome.GRASP_FAILURE
    assert trial.measurements.secured_forces == (0.0, 0.0)
    assert trial.measurements.closed_width == pytest.approx(0.0, abs=1e-3)
    assert trial.measurements.rise is None


def test_wider_than_the_stroke_is_no_success() -> None:
    trial = simulate_grasp(prepare(box(0.1, 0.1, 0.1)), GRIP)
    assert trial.outcome in (Outcome.GRASP_FAILURE, Outcome.SLIPPAGE)
    assert trial.measurements.touched_before_closing


def test_what_is_slippery_and_heavy_slips() -> None:
    # 2 * 0.13 * 15 N just carries 0.39 kg on paper: secured, then lost while it is accelerated and shaken.
    tall = prepare(box(0.05, 0.05, 0.2))
    config = SimulationConfig(friction=0.13, mass=0.42, shake_amplitude=0.03)
    trial = simulate_grasp(tall, grasp((0, 0, 0.18)), config)
    assert trial.outcome is Outcome.SLIPPAGE
    assert trial.measurements.secured_forces is not None
    assert min(trial.measurements.secured_forces) > 0.5


def test_coulomb_decides(block: PreparedObject) -> None:
    outcomes = [
        simulate_grasp(block, GRIP, SimulationConfig(friction=0.5, mass=mass)).succeeded
        for mass in (0.4, 1.2, 1.8, 3.0)
    ]
    # 2 * 0.5 * 15 N carry 1.53 kg at rest.
    assert outcomes == [True, True, False, False]


def test_a_tower_that_topples_is_unstable(block: PreparedObject) -> None:
    tilted = np.array(block.T_world_object)
    angle = np.radians(35)
    tilted[:3, :3] = [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    tilted[2, 3] += 0.025 * np.sin(angle)
    trial = simulate_grasp(block, grasp((0, 0.3, 0.1)), SimulationConfig(settle_time=0.5), pose=tilted)
    assert trial.outcome is Outcome.UNSTABLE
    assert "before it was touched" in trial.reason


def test_an_object_without_a_stable_pose_is_unstable(block: PreparedObject) -> None:
    shaky = replace(block, pose=replace(block.pose, stable=False))
    trial = simulate_grasp(shaky, GRIP)
    assert (trial.outcome, trial.steps) == (Outcome.UNSTABLE, 0)


def test_numbers_that_diverge_are_unstable(
    block: PreparedObject, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    def poison(scene, phase: str) -> None:
        if phase == "close":
            scene.data.qvel[0] = np.nan

    trial = run_trial(block, GRIP, SimulationConfig(), watch=poison)
    assert trial.outcome is Outcome.UNSTABLE
    assert json.dumps(trial.document(), allow_nan=False)
    # MuJoCo keeps its log out of the user's folder, and the next trial knows nothing of it.
    assert os.listdir(tmp_path) == []
    assert simulate_grasp(block, GRIP).succeeded


def test_time_runs_out(block: PreparedObject) -> None:
    trial = simulate_grasp(block, GRIP, SimulationConfig(timeout=1e-6))
    assert trial.outcome is Outcome.UNSTABLE
    assert "timeout" in trial.reason


def test_a_hand_that_starts_in_the_table_fails(block: PreparedObject) -> None:
    trial = simulate_grasp(block, grasp((0, 0, 0.01), ALONG_X))
    assert trial.outcome is Outcome.GRASP_FAILURE
    assert "the table" in trial.reason


def test_no_grasp_is_an_outcome() -> None:
    trial = Trial.no_grasp("wardrobe", "no pair within the stroke")
    assert trial.outcome is Outcome.NO_GRASP
    assert trial.document()["reason"] == "no pair within the stroke"


def test_the_same_trial_gives_the_same_bits(block: PreparedObject) -> None:
    config = SimulationConfig(position_noise=0.002, angle_noise=2, seed=5)
    first, second = (simulate_grasp(block, GRIP, config).document(timing=False) for _ in range(2))
    assert first == second
    again = prepare(box(0.05, 0.05, 0.1))
    assert simulate_grasp(again, GRIP, config).document(timing=False) == first
    other = simulate_grasp(block, GRIP, replace(config, seed=6)).document(timing=False)
    assert other["measurements"] != first["measurements"]


def test_turned_and_moved_objects_are_held_alike(block: PreparedObject) -> None:
    for pose in random_poses(block, 4, 0):
        trial = simulate_grasp(block, GRIP, pose=pose)
        assert trial.succeeded
        assert trial.measurements.slip_distance == pytest.approx(0, abs=1e-3)


def test_shake_and_tilt_are_stricter(block: PreparedObject) -> None:
    strict = SimulationConfig(shake_amplitude=0.02, tilt=45)
    assert simulate_grasp(block, GRIP, strict).succeeded
    loose = SimulationConfig(friction=0.2, mass=0.5)
    hard = replace(loose, shake_amplitude=0.05, shake_frequency=5)
    assert simulate_grasp(block, GRIP, loose).succeeded
    assert not simulate_grasp(block, GRIP, hard).succeeded


def test_a_mug_is_held_by_its_handle_and_its_wall() -> None:
    shown = zoo.demonstration("mug", 0)
    prepared = prepare(shown.object)
    contact = shown.contact
    assert contact.approach is not None
    by_handle = grasp(contact.point + 0.008 * contact.approach, contact.approach)
    assert simulate_grasp(prepared, by_handle).succeeded
    body = prepared.object.parts[prepared.object.part_index("body")].vertices
    rim = np.array((0, body[:, 1].max() - 0.002, body[:, 2].max() - 0.01))
    by_wall = simulate_grasp(prepared, grasp(rim, DOWN))
    assert by_wall.succeeded
    assert by_wall.measurements.closed_width is not None
    assert 0.002 < by_wall.measurements.closed_width < 0.006


def test_any_object_can_be_given() -> None:
    mesh = trimesh.creation.box((0.05, 0.05, 0.1))
    assert simulate_grasp(mesh_object("plain", mesh), grasp((0, 0, 0.03))).succeeded


def test_a_channel_is_held_by_one_wall() -> None:
    pytest.importorskip("coacd")
    trial = simulate_grasp(prepare(channel()), grasp((0.04, 0, 0.06), DOWN, ALONG_X))
    assert trial.measurements.closed_width == pytest.approx(0.02, abs=2e-3)


def test_poses_and_forces_out_of_range(block: PreparedObject) -> None:
    with pytest.raises(InputError, match="gives at most 70 N a finger, got 80"):
        simulate_grasp(block, GRIP, SimulationConfig(force=80))
    with pytest.raises(InputError, match="grasp pose: expected finite numbers"):
        simulate_grasp(block, replace(GRIP, pose=np.full((4, 4), np.nan)))
    with pytest.raises(InputError, match="grasp pose: expected a rotation"):
        simulate_grasp(block, replace(GRIP, pose=2 * np.eye(4)))
    with pytest.raises(InputError, match="pose: expected a rotation"):
        simulate_grasp(block, GRIP, pose=np.zeros((4, 4)))


def test_documents_say_all_settings(block: PreparedObject) -> None:
    document = json.loads(json.dumps(simulate_grasp(block, GRIP).document(), allow_nan=False))
    assert document["config"] == SimulationConfig().document()
    assert set(document["versions"]) == {"graft", "numpy", "python", "mujoco"}
    assert document["steps"] > 500

"""The hand under actions."""

from dataclasses import replace

import numpy as np
import pytest
from generation_scenes import block, library

pytest.importorskip("mujoco")

from graft.datagen.retarget import source_of
from graft.datagen.rollout import Diverged, Rollout, grip_for
from graft.datagen.rotations import rotation_about, rotation_vector
from graft.datagen.scene import episode_scene, scene_from_xml
from graft.datagen.scripted import start_pose
from graft.datagen.selection import Chooser
from graft.errors import InputError
from graft.grasp import PANDA_HAND
from graft.sim import SimulationConfig, prepare
from graft.sim.compiled import CompiledScene


@pytest.fixture(scope="module")
def prepared():
    return prepare(block("one", 0.04, 0.05, 0.1))


def begun(prepared, physics=None, timeout=60.0):
    physics = physics or SimulationConfig()
    _, scene = episode_scene(prepared.body, physics, PANDA_HAND)
    rollout = Rollout(scene, timeout)
    rollout.begin(prepared.T_world_object, start_pose(prepared), 0.1)
    return rollout


def test_the_text_keeps_masses_and_contacts(prepared):
    physics = SimulationConfig(mass=0.3, friction=0.7)
    whole = CompiledScene(prepared.body, physics, PANDA_HAND).model
    text = scene_from_xml(episode_scene(prepared.body, physics, PANDA_HAND)[0]).model
    contacts = ("geom_friction", "geom_solref", "actuator_forcerange", "eq_data")
    for name in ("body_mass", "body_inertia", "body_ipos", *contacts):
        np.testing.assert_allclose(getattr(text, name), getattr(whole, name), rtol=1e-6, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("axis", range(3))
def test_an_action_moves_and_turns_the_hand(prepared, axis):
    rollout = begun(prepared)
    before = rollout.hands[-1]
    action = np.zeros(7)
    action[axis], action[3 + axis], action[6] = 0.4, 0.2, -1
    rollout.act(action)
    after = rollout.hands[-1]
    moved, turned = after[:3, 3] - before[:3, 3], rotation_vector(after[:3, :3] @ before[:3, :3].T)
    # The weld lags by a third of a step, which the next action makes up for.
    for done, told in ((moved, 0.02), (turned, 0.1)):
        assert 0.5 * told < done[axis] < told
        assert np.abs(np.delete(done, axis)).max() < 1e-3
    np.testing.assert_allclose(rollout.targets[-1][:3, 3] - before[:3, 3], 0.02 * np.eye(3)[axis], atol=1e-12)


def test_a_target_is_reached_as_far_as_actions_go(prepared):
    rollout = begun(prepared)
    target = np.array(rollout.hands[-1])
    target[:3, 3] += 0.03, -0.02, 0.01
    target[:3, :3] = rotation_about(np.array([0.1, 0.0, 0.2])) @ target[:3, :3]
    for _ in range(3):
        rollout.toward(target, -1.0)
    np.testing.assert_allclose(rollout.hands[-1], target, atol=2e-3)
    target[0, 3] += 1.0
    rollout.toward(target, -1.0)
    assert rollout.actions[-1][0] == 1.0


@pytest.mark.parametrize("opening", [0.08, 0.05, 0.01])
def test_fingers_open_as_far_as_told(prepared, opening):
    rollout = begun(prepared)
    for _ in range(15):
        rollout.toward(rollout.aim, grip_for(opening, PANDA_HAND.stroke))
    assert rollout.openings[-1] == pytest.approx(opening, abs=1e-3)


def test_a_state_goes_on_to_the_bit(prepared):
    rng = np.random.default_rng(0)
    actions = np.clip(rng.normal(scale=0.3, size=(12, 7)), -1, 1)
    rollout = begun(prepared)
    for action in actions:
        rollout.act(action)
    xml, _ = episode_scene(prepared.body, SimulationConfig(), PANDA_HAND)
    again = Rollout(scene_from_xml(xml), 60.0)
    again.restore(rollout.states[5])
    for action in actions[5:]:
        again.act(action)
    assert np.array(again.states).tolist() == np.array(rollout.states[5:]).tolist()
    assert again.hands[-1].tolist() == rollout.hands[-1].tolist()


def test_time_runs_out(prepared):
    with pytest.raises(Diverged, match="timeout"):
        begun(prepared, timeout=0.0)


def test_other_scenes_are_one_line():
    with pytest.raises(InputError, match="model: "):
        scene_from_xml("<mujoco><worldbody><body name='object'/></worldbody></mujoco>")


def test_nearest_neighbours_are_drawn_from_the_nearest():
    given = library()
    source = source_of(next(iter(given)))
    sources = {}
    for number in range(6):  # the same, shown ever further away along x
        move = np.eye(4)
        move[0, 3] = number
        trajectory = source.trajectory.transformed(move)
        named = replace(source.demonstration, name=f"{number}")
        sources[named.name] = replace(source, trajectory=trajectory, demonstration=named)
    chooser = Chooser(given, sources, given.graph(block("one", 0.04, 0.05, 0.1)))
    placed = source.object_pose(0) + np.array([[0, 0, 0, 5.2], [0] * 4, [0] * 4, [0] * 4])
    drawn = {
        chooser.choose("nearest_neighbor_object", np.random.default_rng(i), placed, np.eye(4)).name for i in range(30)
    }
    assert drawn == {"3", "4", "5"}
    anyone = {chooser.choose("random", np.random.default_rng(i), placed, np.eye(4)).name for i in range(60)}
    assert anyone == set(sources)

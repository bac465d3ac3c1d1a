"""Demonstrations by script."""

from dataclasses import replace

import numpy as np
import pytest
from generation_scenes import demonstration, shown

pytest.importorskip("mujoco")
pytest.importorskip("h5py")

from graft import zoo
from graft.datagen.config import GenerationConfig
from graft.datagen.generate import EPISODES, generate
from graft.datagen.read import read_episodes
from graft.datagen.replay import replay_episode
from graft.datagen.script import LIFT, TILT
from graft.datagen.scripted import TOLERANCE, demonstrate
from graft.errors import InputError
from graft.grasp import ROBOTIQ_2F85
from graft.io import load_demonstration, save_demonstration
from graft.library import Library
from graft.sim import SimulationConfig
from graft.trajectory import DEMONSTRATED


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
    with pytest.raises(
        InputError, match="object 'wide': gripper 'panda_hand' cannot hold its part 'body' as it stands"
    ):
        demonstrate(shown("wide", 0.2, 0.2, 0.1))


@pytest.fixture(scope="module")
def pouring():
    """A mug, taken by its handle with force enough to tilt it."""
    return demonstrate(zoo.demonstration("mug"), task="pour", physics=SimulationConfig(force=40.0))


def test_a_pour_tilts_away_from_the_hand(pouring):
    trajectory = pouring.trajectory
    told = [(s.name, s.signal) for s in trajectory.segments[2:]]
    assert told == [("lift", "lifted"), ("pour", "poured"), ("hold", None)]
    begun, ended = trajectory.T_world_object[DEMONSTRATED][[0, -1]]
    front = begun[:3, 3] - (begun @ pouring.grasp)[:3, 3]
    front[2] = 0
    turned = ended[:3, :3] @ begun[:3, :3].T @ (front / np.linalg.norm(front))
    assert np.degrees(np.arcsin(-turned[2])) > TILT - TOLERANCE - 3


def test_a_pour_is_generated_and_told_from_a_lift(pouring, tmp_path):
    library = Library()
    library.add(pouring)
    config = GenerationConfig(task="pour", physics=SimulationConfig(force=40.0))
    tally = generate(library, [zoo.make("jug")], tmp_path, n=2, config=config)
    assert tally.kept == 2
    for episode in read_episodes(tmp_path / EPISODES):
        assert episode.env_args["env_name"] == "graft/Pour-v0"
        replayed = replay_episode(episode)
        assert (replayed.difference, replayed.outcome) == (0.0, "success")
    # Tilted by 60 degrees it was not tilted by 80.
    (episode, *_) = read_episodes(tmp_path / EPISODES)
    asked = replace(episode, settings={**episode.settings, "bounds": {**episode.settings["bounds"], "tilt": 80.0}})
    assert replay_episode(asked).outcome == "not_poured"
    with pytest.raises(InputError, match="no demonstration has a trajectory of the task 'lift'"):
        generate(library, [zoo.make("jug")], tmp_path / "lift", n=1)

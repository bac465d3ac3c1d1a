"""Episodes run again from their own files."""

from dataclasses import replace

import numpy as np
import pytest
from generation_scenes import library, targets
from sample_episodes import episode

pytest.importorskip("mujoco")
pytest.importorskip("h5py")

from graft.datagen.attempt import Target, run_attempt
from graft.datagen.config import GenerationConfig
from graft.datagen.export import export_episodes, open_writer
from graft.datagen.replay import replay
from graft.datagen.selection import replayable
from graft.errors import InputError
from graft.grasp import PANDA_HAND
from graft.sim import SimulationConfig


@pytest.fixture(scope="module")
def made():
    shown = library()
    target = Target.lay(targets()[0], shown, replayable(shown, "lift"), SimulationConfig())
    return run_attempt(target, PANDA_HAND, GenerationConfig(), run=1, number=0).episode


def written(path, *episodes):
    with open_writer(path) as writer:
        for one in episodes:
            writer.append(one)
    return path


def test_a_file_runs_again_to_the_bit(tmp_path, made):
    (one,) = replay(written(tmp_path / "lift.hdf5", made))
    assert one.same
    assert one.difference == 0.0
    assert (one.recorded, one.outcome, one.steps) == ("success", "success", len(made))


def test_so_does_a_lerobot_dataset(tmp_path, made):
    pytest.importorskip("av"), pytest.importorskip("pyarrow")
    export_episodes(written(tmp_path / "lift.hdf5", made), tmp_path / "lift", "lerobot")
    (one,) = replay(tmp_path / "lift")
    assert one.same
    assert one.difference == 0.0


def test_other_actions_come_out_differently(tmp_path, made):
    actions = np.array(made.actions)
    actions[:, 6] = -1  # never closes
    (one,) = replay(written(tmp_path / "lift.hdf5", replace(made, actions=actions)))
    assert not one.same
    assert one.outcome == "grasp_failure"
    assert one.difference > 0.01


def test_one_of_several(tmp_path, made):
    path = written(tmp_path / "lift.hdf5", made, replace(made, name="again", outcome="slippage"))
    (one,) = replay(path, episode=1)
    assert (one.name, one.same) == ("again", False)
    with pytest.raises(InputError, match="no episode 2: there are 2"):
        list(replay(path, episode=2))


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"settings": {}}, "its settings have no bounds"),
        ({"model_xml": "<mujoco"}, "model: "),
        ({"model_xml": "<mujoco/>"}, "model: "),
    ],
)
def test_what_graft_did_not_generate_is_one_line(tmp_path, made, changes, line):
    path = written(tmp_path / "lift.hdf5", replace(made, **changes))
    with pytest.raises(InputError, match=line) as caught:
        list(replay(path))
    assert "\n" not in str(caught.value)


def test_a_state_of_another_scene_is_one_line(tmp_path, made):
    path = written(tmp_path / "lift.hdf5", replace(made, states=made.states[:, :9]))
    with pytest.raises(InputError, match="states: expected a state of 105 numbers, got 9"):
        list(replay(path))
    with pytest.raises(InputError, match="no bounds"):
        list(replay(written(tmp_path / "noise.hdf5", episode(1))))

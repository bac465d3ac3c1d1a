"""One attempt, by graft's way and by MimicGen's."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from generation_scenes import library, targets

pytest.importorskip("mujoco")

from graft.datagen.attempt import Target, derived_seed, draw_scene, run_attempt
from graft.datagen.config import GenerationConfig, Randomisation, vanilla
from graft.datagen.judge import AttemptOutcome
from graft.datagen.scripted import demonstrate
from graft.datagen.selection import replayable
from graft.errors import InputError
from graft.grasp import PANDA_HAND, ROBOTIQ_2F85
from graft.grasp.conventions import rigid_inverse
from graft.library import Library
from graft.marking import mark_contact
from graft.objects import Part, PartObject
from graft.sim import SimulationConfig
from graft.trajectory import DEMONSTRATED


@pytest.fixture(scope="module")
def laid():
    shown = library()
    sources = replayable(shown, "lift")
    return {obj.name: Target.lay(obj, shown, sources, SimulationConfig()) for obj in targets()}


def test_graft_lifts_and_records(laid):
    made = run_attempt(laid["narrow"], PANDA_HAND, GenerationConfig(), run=0, number=0)
    assert made.outcome is AttemptOutcome.SUCCESS, made.reason
    assert made.any_step
    episode = made.episode
    assert [s.name for s in episode.trajectory.segments] == ["reach", "grasp", "lift", "hold"]
    placed = episode.trajectory.T_world_object[DEMONSTRATED]
    assert placed[-1, 2, 3] - placed[0, 2, 3] > 0.1
    assert np.abs(episode.actions).max() <= 1
    assert np.flatnonzero(episode.rewards).tolist() == [len(episode) - 1]
    for name, rows in episode.observations.items():
        assert len(rows) == len(episode) + 1, name
    np.testing.assert_allclose(episode.observations["eef_pos"][:-1], episode.trajectory.T_world_gripper[:, :3, 3])


def test_the_same_attempt_is_the_same(laid):
    one, two = (run_attempt(laid["narrow"], PANDA_HAND, GenerationConfig(), run=3, number=5) for _ in range(2))
    assert one.episode.states.tolist() == two.episode.states.tolist()
    assert one.document() == two.document()
    other = run_attempt(laid["narrow"], PANDA_HAND, GenerationConfig(), run=3, number=6)
    assert other.seed != one.seed == derived_seed(3, "narrow", "source", 5)


def test_noise_is_in_the_actions_and_can_be_switched_off(laid):
    still = run_attempt(laid["narrow"], PANDA_HAND, GenerationConfig(noise=0), run=0, number=0).episode
    noisy = run_attempt(laid["narrow"], PANDA_HAND, GenerationConfig(), run=0, number=0).episode
    lift = [next(s for s in e.trajectory.segments if s.name == "lift") for e in (still, noisy)]
    # The lift goes straight up: what is sideways is noise, of the size that was asked for.
    sideways = [e.actions[s.start : s.end, :2].std() for e, s in zip((still, noisy), lift, strict=True)]
    assert sideways[0] < 0.015 < 0.03 < sideways[1] < 0.12
    # What the controller was told has the noise, too.
    told = [e.trajectory.T_world_target[s.start : s.end, :2, 3] for e, s in zip((still, noisy), lift, strict=True)]
    assert np.diff(told[0], axis=0).std() < 0.001 < np.diff(told[1], axis=0).std()
    hold = noisy.trajectory.segments[-1]
    assert np.abs(noisy.actions[hold.end - 5 : hold.end, :6]).max() < 0.02


def test_methods_meet_the_same_scenes(laid):
    prepared = laid["tall"].prepared
    seed = derived_seed(0, "tall", 0)
    ours, theirs = (draw_scene(prepared, config, seed) for config in (GenerationConfig(), vanilla()))
    assert ours.placed.tolist() == theirs.placed.tolist()
    assert ours.start.tolist() == theirs.start.tolist()


def test_vanilla_replays_relative_to_the_body(laid):
    shown = library()
    sources = replayable(shown, "lift")
    (source,) = sources.values()
    own = Target.lay(source.demonstration.object, shown, sources, SimulationConfig())
    made = run_attempt(own, PANDA_HAND, vanilla(noise=0), run=0, number=0)
    assert made.outcome is AttemptOutcome.SUCCESS, made.reason
    episode = made.episode
    assert [s.name for s in episode.trajectory.segments] == ["reach", "grasp", "lift", "hold"]
    step = int(np.flatnonzero(episode.trajectory.gripper > 0)[0])
    relative = (
        rigid_inverse(episode.trajectory.T_world_object[DEMONSTRATED][step]) @ episode.trajectory.T_world_target[step]
    )
    np.testing.assert_allclose(relative, source.grasp, atol=3e-3)


@pytest.mark.parametrize("changes", [{"reach": "linear"}, {"anchor": "object"}])
def test_each_switch_works_alone(laid, changes):
    made = run_attempt(laid["narrow"], PANDA_HAND, GenerationConfig(**changes), run=0, number=0)
    assert made.demonstration == "source"
    assert made.outcome in (AttemptOutcome.SUCCESS, AttemptOutcome.GRASP_FAILURE, AttemptOutcome.NO_MOTION)


@pytest.mark.parametrize("select", ["random", "nearest_neighbor_object", "nearest_neighbor_robot_distance"])
def test_mimicgens_selections_lead_to_grasps(laid, select):
    made = run_attempt(laid["narrow"], PANDA_HAND, GenerationConfig(select=select), run=0, number=0)
    assert made.outcome is AttemptOutcome.SUCCESS, made.reason


def test_what_is_too_wide_gives_no_grasp(laid):
    made = run_attempt(laid["wide"], PANDA_HAND, GenerationConfig(), run=0, number=0)
    assert (made.outcome, made.steps) == (AttemptOutcome.NO_GRASP, 0)
    assert made.reason.startswith("no grasp on the contact's part: ")


def test_where_nothing_near_the_contact_holds_its_part_is_taken_elsewhere():
    plate, post = trimesh.creation.box((0.2, 0.2, 0.01)), trimesh.creation.box((0.03, 0.05, 0.12))
    plate.apply_translation((0, 0, 0.005))
    post.apply_translation((0, 0, 0.07))
    both = trimesh.util.concatenate([plate, post])
    obj = PartObject("stand", (Part("all", both.vertices, both.faces),), up=(0, 0, 1), scale_to_metres=1.0)
    edge = mark_contact(obj, 0, (0.1, 0.09, 0.005))
    made = demonstrate(edge)
    assert np.linalg.norm(made.contact.point[:2]) < 0.03 < made.contact.point[2]
    shown = Library()
    shown.add(replace(made, contact=edge.contact))
    target = Target.lay(obj, shown, replayable(shown, "lift"), SimulationConfig())
    assert run_attempt(target, PANDA_HAND, GenerationConfig(), run=0, number=0).outcome is AttemptOutcome.SUCCESS
    strict = run_attempt(target, PANDA_HAND, GenerationConfig(anywhere=False), run=0, number=0)
    assert strict.outcome is AttemptOutcome.NO_GRASP
    assert strict.reason.startswith("no grasp near the contact")


def test_slippery_is_a_failure_with_a_reason(laid):
    config = GenerationConfig(physics=SimulationConfig(friction=0.05))
    made = run_attempt(laid["narrow"], PANDA_HAND, config, run=0, number=0)
    assert made.outcome in (AttemptOutcome.GRASP_FAILURE, AttemptOutcome.SLIPPAGE)
    assert made.episode is None


def test_mass_and_friction_are_drawn_and_told(laid):
    random = Randomisation(mass=(0.1, 0.2), friction=(0.6, 0.9))
    made = run_attempt(laid["narrow"], PANDA_HAND, GenerationConfig(random=random), run=0, number=0)
    assert 0.1 <= made.episode.settings["mass"] <= 0.2
    assert 0.6 <= made.episode.settings["friction"] <= 0.9


def test_a_robotiq_replays_a_pandas_demonstration(laid):
    made = run_attempt(laid["narrow"], ROBOTIQ_2F85, GenerationConfig(), run=0, number=0)
    assert made.outcome is AttemptOutcome.SUCCESS, made.reason
    assert made.episode.env_args["env_kwargs"]["gripper"] == "robotiq_2f85"


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"task": "fly"}, "task: expected one of lift"),
        ({"noise": -1.0}, "noise: expected a number of at least 0"),
        ({"interpolation": 0}, "interpolation: expected at least 1"),
        ({"physics": SimulationConfig(timestep=0.003)}, "timestep: expected a whole number of steps"),
    ],
)
def test_bad_settings_are_one_line(changes, line):
    with pytest.raises(InputError, match=line):
        replace(GenerationConfig(), **changes)


def test_ranges_go_upwards():
    with pytest.raises(InputError, match="randomisation mass: expected 0 < low <= high"):
        Randomisation(mass=(0.5, 0.1))

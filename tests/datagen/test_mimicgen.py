"""Files as MimicGen's prepare_src_dataset leaves them: nothing in them is graft's."""

import json
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose
from sample_episodes import poses

h5py = pytest.importorskip("h5py")

from graft import as_object, load_demonstration, save_demonstration  # noqa: E402
from graft.datagen.mimicgen import import_demonstrations  # noqa: E402
from graft.datagen.read import read_episodes  # noqa: E402
from graft.errors import InputError  # noqa: E402

STEPS, CLOSES = 12, 5


@pytest.fixture
def box():
    """A cube of 10 cm in millimetres, its lid a part of its own."""
    cube = trimesh.creation.box((100, 100, 100))
    labels = np.where(cube.face_normals[:, 2] > 0.5, "lid", "body")
    return replace(as_object((cube.vertices, cube.faces, labels)), scale_to_metres=0.001)


@pytest.fixture
def file(tmp_path):
    """Two demonstrations of a hand that closes 1 cm above the middle of the cube's lid."""
    rng, path = np.random.default_rng(0), tmp_path / "stack.hdf5"
    with h5py.File(path, "w") as file:
        data = file.create_group("data")
        data.attrs["total"] = 2 * STEPS
        data.attrs["env_args"] = json.dumps({"env_name": "Stack", "type": 1, "env_kwargs": {"control_freq": 10}})
        for number in range(2):
            cube, hand = poses(rng, STEPS), poses(rng, STEPS)
            relative = np.diag([1.0, -1.0, -1.0, 1.0])
            relative[2, 3] = 0.06
            hand[CLOSES] = cube[CLOSES] @ relative
            demo = data.create_group(f"demo_{number}")
            demo.attrs["num_samples"] = STEPS
            demo.attrs["model_file"] = "<mujoco/>"
            arrays = {
                "actions": rng.uniform(-1, 1, (STEPS, 7)),
                "states": rng.normal(size=(STEPS, 20)),
                "rewards": np.zeros(STEPS),
                "dones": np.eye(STEPS, dtype=int)[-1],
                "datagen_info/eef_pose": hand.astype(np.float32),
                "datagen_info/target_pose": hand,
                "datagen_info/gripper_action": np.where(np.arange(STEPS) < CLOSES, -1.0, 1.0)[:, None],
                "datagen_info/object_poses/cubeA": cube,
                "datagen_info/object_poses/cubeB": poses(rng, STEPS),
                "datagen_info/subtask_term_signals/grasp": (np.arange(STEPS) >= 6).astype(int),
                "datagen_info/subtask_term_signals/stack": np.zeros(STEPS, int),
            }
            for key, array in arrays.items():
                demo[key] = array
    return path


def test_demonstrations_of_the_object_that_was_taken(file, box, tmp_path):
    first, second = import_demonstrations(file, box, pose="cubeA", anchors={"end": "cubeB"})
    assert (first.name, second.name) == ("stack_demo_0", "stack_demo_1")
    assert_allclose(first.grasp[:3, 3], [0, 0, 0.06], atol=1e-6)
    assert_allclose(first.contact.point, [0, 0, 50], atol=1e-3)  # the object's unit is its own
    assert first.contact.normal.tolist() == [0, 0, 1]
    assert_allclose(first.contact.approach, [0, 0, -1], atol=1e-6)
    assert first.object.part_names[first.contact.part] == "lid"
    moves = first.trajectory
    assert moves.times[1] == pytest.approx(0.1)
    assert list(moves.T_world_object) == ["object", "cubeB"]
    assert [(s.name, s.start, s.end, s.anchor, s.signal) for s in moves.segments] == [
        ("grasp", 0, 7, "object", "grasp"), ("end", 7, 12, "cubeB", None),
    ]  # fmt: skip
    save_demonstration(tmp_path / "saved", first)
    back = load_demonstration(tmp_path / "saved")
    assert back.grasp.tolist() == first.grasp.tolist()
    assert back.trajectory.T_world_target.tolist() == moves.T_world_target.tolist()


def test_another_frame_of_the_hand(file, box):
    quarter = np.array([[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0.02], [0, 0, 0, 1.0]])
    (plain, _), (turned, _) = (
        import_demonstrations(file, box, pose="cubeA", part="body", T_eef_gripper=t) for t in (None, quarter)
    )
    assert_allclose(turned.grasp, plain.grasp @ quarter, atol=1e-6)
    assert plain.object.part_names[plain.contact.part] == "body"


def test_episodes_of_mimicgen_are_read(file):
    episodes = list(read_episodes(file))
    assert [e.name for e in episodes] == ["demo_0", "demo_1"]
    assert (episodes[0].seed, episodes[0].outcome, episodes[0].task) == (0, "success", "Stack")
    assert episodes[0].rate == pytest.approx(10)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        (
            {"pose": "mug"},
            r"stack.hdf5: data/demo_0/datagen_info/object_poses/mug: there is none; there are cubeA, cubeB",
        ),
        ({"pose": "cubeA", "anchors": {"lift": None}}, "no segment 'lift' to anchor; there are grasp, end"),
        ({"pose": "cubeA", "anchors": {"end": "pot"}}, "data/demo_0: segment 'end': no object called 'pot'"),
        ({"pose": "cubeA", "part": "spout"}, "no part called 'spout'"),
    ],
)
def test_what_is_not_there(file, box, options, match):
    with pytest.raises(InputError, match=match):
        list(import_demonstrations(file, box, **options))


def test_hands_that_never_close_and_objects_without_a_scale(file, box):
    with pytest.raises(InputError, match="its scale_to_metres must be known"):
        list(import_demonstrations(file, as_object((box.parts[0].vertices, box.parts[0].faces)), pose="cubeA"))
    with h5py.File(file, "a") as opened:
        opened["data/demo_1/datagen_info/gripper_action"][:] = -1
    with pytest.raises(
        InputError, match=r"stack.hdf5: data/demo_1/datagen_info/gripper_action: expected the gripper to"
    ):
        list(import_demonstrations(file, box, pose="cubeA"))

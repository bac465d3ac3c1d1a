import io
import zipfile

import numpy as np
import pytest

from graft import InputError, as_object, load_demonstration, mark_contact, save_demonstration
from graft.io.trajectories import load_trajectory, save_trajectory
from graft.objects import Demonstration
from graft.trajectory import Segment, Trajectory


def moves(steps=6):
    poses = np.tile(np.eye(4), (steps, 1, 1))
    poses[:, :3, 3] = np.random.default_rng(0).normal(size=(steps, 3))
    segments = (Segment("reach", 0, 2, "object", "reached"), Segment("lift", 2, steps))
    return Trajectory(np.arange(steps) / 3, poses, np.linspace(-1, 1, steps), poses[::-1], {"object": poses}, segments)


def arrays(**changes):
    words = {"times": np.arange(3.0), "T_world_target": np.tile(np.eye(4), (3, 1, 1)), "gripper": np.zeros(3)}
    return {key: value for key, value in (words | changes).items() if value is not None}


def test_every_bit_comes_back_and_the_bytes_are_always_the_same(tmp_path):
    save_trajectory(tmp_path / "a.npz", moves())
    save_trajectory(tmp_path / "b.npz", moves())
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    back = load_trajectory(tmp_path / "a.npz")
    for name in ("times", "T_world_target", "gripper", "T_world_gripper"):
        assert getattr(back, name).tolist() == getattr(moves(), name).tolist()
    assert back.T_world_object["object"].tolist() == moves().T_world_object["object"].tolist()
    assert back.segments == moves().segments
    with pytest.raises(InputError, match=r"cannot write '.json': expected .npz"):
        save_trajectory(tmp_path / "a.json", moves())


def test_a_recorders_positions_and_quaternions(tmp_path):
    half = np.sqrt(0.5)
    plain = arrays(
        T_world_target=None,
        target_position=np.ones((3, 3)),
        target_quaternion=np.tile([half, 0, 0, half], (3, 1)),
        gripper_position=np.zeros((3, 3)),
        gripper_quaternion=np.tile([1.0, 0, 0, 0], (3, 1)),
    )
    np.savez(tmp_path / "t.npz", **plain)
    back = load_trajectory(tmp_path / "t.npz")
    assert np.allclose(back.T_world_target[0], [[0, -1, 0, 1], [1, 0, 0, 1], [0, 0, 1, 1], [0, 0, 0, 1]])
    assert back.T_world_gripper[2].tolist() == np.eye(4).tolist()
    assert [(s.start, s.end) for s in back.segments] == [(0, 3)]


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"times": None}, "array 'times' is missing; found gripper"),
        ({"T_world_target": None}, "array 'T_world_target' is missing; found gripper, times"),
        ({"T_world_target": None, "target_position": np.ones((3, 3))}, "array 'target_quaternion' is missing"),
        ({"speed": np.ones(3)}, "array 'speed' is unknown"),
        ({"gripper": np.full(3, np.nan)}, "trajectory gripper: expected finite numbers"),
        ({"segment_name": np.array(["a"])}, "array 'segment_start' is missing"),
        (
            {"segment_name": np.array(["a"]), "segment_start": np.array([0]), "segment_end": np.array([1, 2])},
            "malformed trajectory",
        ),
    ],
)
def test_bad_files_are_one_line(tmp_path, changes, match):
    np.savez(tmp_path / "t.npz", **arrays(**changes))
    with pytest.raises(InputError, match=f"t.npz: {match}") as error:
        load_trajectory(tmp_path / "t.npz")
    assert "\n" not in str(error.value)


def test_pickles_are_not_loaded(tmp_path):
    inner = io.BytesIO()
    np.save(inner, np.array([print]), allow_pickle=True)
    save_trajectory(tmp_path / "t.npz", moves())
    with zipfile.ZipFile(tmp_path / "t.npz", "a") as archive:
        archive.writestr("extra.npy", inner.getvalue())
    with pytest.raises(InputError, match="holds pickled Python objects"):
        load_trajectory(tmp_path / "t.npz")


@pytest.fixture
def demo(body):
    marked = mark_contact(as_object((body.vertices, body.faces)), 0, name="cup")
    return Demonstration(marked.object, marked.contact, "cup", {}, grasp=np.eye(4), trajectory=moves())


def test_beside_a_demonstration(tmp_path, demo):
    save_demonstration(tmp_path / "cup", demo)
    assert sorted(p.name for p in (tmp_path / "cup").iterdir()) == [
        "demonstration.json", "object.glb", "trajectory.npz",
    ]  # fmt: skip
    back = load_demonstration(tmp_path / "cup")
    assert back.grasp.tolist() == np.eye(4).tolist()
    assert back.trajectory.T_world_target.tolist() == moves().T_world_target.tolist()
    save_demonstration(tmp_path / "cup", Demonstration(demo.object, demo.contact, "cup"))
    again = load_demonstration(tmp_path / "cup")
    assert (again.grasp, again.trajectory) == (None, None)
    assert not (tmp_path / "cup" / "trajectory.npz").exists()


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ('"trajectory.npz"', '"../t.npz"', "leaves the folder"),
        ('"trajectory.npz"', '"gone.npz"', "gone.npz: no such file"),
        ('"trajectory.npz"', "3", "trajectory: expected a string"),
        ('"grasp": [', '"grasp": [[2,0,0,0],', r"grasp: expected shape \(4, 4\), got \(5, 4\)"),
    ],
)
def test_bad_words(tmp_path, demo, old, new, match):
    save_demonstration(tmp_path / "cup", demo)
    words = tmp_path / "cup" / "demonstration.json"
    text = words.read_text()
    assert old in text
    words.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=match):
        load_demonstration(tmp_path / "cup")

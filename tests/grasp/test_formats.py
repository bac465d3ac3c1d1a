"""Files of grasps: round trips, other people's layouts, and what is refused with its file and row."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graft.errors import InputError
from graft.grasp import PANDA_HAND, ROBOTIQ_2F85, GraspSet, load_grasps, save_grasps

FIELDS = ("poses", "widths", "scores", "contacts", "distances")


def some(n=5, gripper=PANDA_HAND, **fields):
    random = np.random.default_rng(3)
    poses = np.tile(np.eye(4), (n, 1, 1))
    poses[:, :3, :3] = Rotation.random(n, rng=random).as_matrix()
    poses[:, :3, 3] = random.uniform(-0.3, 0.3, (n, 3))
    rest = random.uniform(0, 0.08, n), random.normal(size=n), random.normal(size=(n, 2, 3)), random.uniform(size=n)
    return GraspSet(poses, *rest, gripper, **fields)


def row(score=0.7, width=0.06, depth=0.03, rotation=None, position=(0.1, 0.2, 0.3), number=-1):
    rotation = np.eye(3) if rotation is None else rotation
    return np.concatenate([[score, width, 0.02, depth], np.ravel(rotation), position, [number]])


@pytest.mark.parametrize("n", [0, 1, 5])
def test_our_archive_keeps_every_bit(n, tmp_path):
    grasps = some(
        n,
        ROBOTIQ_2F85,
        terms={"cone": np.linspace(0, 1, n)},
        rejected={"the palm hits": 3},
        metadata={"seed": 7, "planner": "antipodal", "mu": 0.5},
    )
    save_grasps(tmp_path / "g.npz", grasps)
    back = load_grasps(tmp_path / "g.npz")
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(back, name), getattr(grasps, name))
    np.testing.assert_array_equal(back.terms["cone"], grasps.terms["cone"])
    assert back.rejected == grasps.rejected
    assert back.metadata.items() >= {"seed": 7, "planner": "antipodal", "mu": 0.5}.items()
    assert "graft" in back.metadata
    assert back.gripper.is_like(ROBOTIQ_2F85)
    assert back.gripper.name == "robotiq_2f85"


@pytest.mark.parametrize("name", ["g.npz", "g.npy", "g.json"])
def test_the_same_grasps_are_the_same_file(name, tmp_path, monkeypatch):
    save_grasps(tmp_path / name, some())
    first = (tmp_path / name).read_bytes()
    monkeypatch.setattr("time.localtime", lambda *_: (2001, 2, 3, 4, 5, 6, 0, 0, 0))
    save_grasps(tmp_path / name, some())
    assert (tmp_path / name).read_bytes() == first


def test_our_archive_is_read_by_numpy_without_pickle(tmp_path):
    save_grasps(tmp_path / "g.npz", some())
    with np.load(tmp_path / "g.npz", allow_pickle=False) as arrays:
        words = json.loads(bytes(arrays["metadata"]))
        assert arrays["poses"].shape == (5, 4, 4)
    assert words["units"]["length"] == "metre"
    assert words["gripper"]["stroke"] == 0.08


@pytest.mark.parametrize("n", [0, 1, 5])
def test_graspnet_rows_come_back(n, tmp_path):
    grasps = some(n)
    save_grasps(tmp_path / "g.npy", grasps)
    assert np.load(tmp_path / "g.npy").shape == (n, 17)
    back = load_grasps(tmp_path / "g.npy")
    for name in ("poses", "widths", "scores"):
        np.testing.assert_array_equal(getattr(back, name), getattr(grasps, name))
    save_grasps(tmp_path / "again.npy", back)
    assert (tmp_path / "again.npy").read_bytes() == (tmp_path / "g.npy").read_bytes()


def test_a_graspnet_row_means_what_graspnet_says(tmp_path):
    turn = Rotation.from_euler("xyz", [0.3, -0.5, 1.1]).as_matrix()
    np.save(tmp_path / "g.npy", [row(rotation=turn, depth=0.03), row(number=12, score=0.1)])
    grasps = load_grasps(tmp_path / "g.npy")
    approach, closing = turn[:, 0], turn[:, 1]
    np.testing.assert_allclose(grasps.poses[0, :3, 2], approach)
    np.testing.assert_allclose(grasps.poses[0, :3, 1], closing)
    # The fingertips are depth beyond t; a Panda's TCP lies 9 mm behind them.
    np.testing.assert_allclose(grasps.poses[0, :3, 3], (0.1, 0.2, 0.3) + (0.03 - 0.009) * approach)
    np.testing.assert_allclose(grasps.contacts[0, 0] - grasps.contacts[0, 1], 0.06 * closing)
    np.testing.assert_array_equal(grasps.terms["object_id"], [-1, 12])
    # Single precision, as AnyGrasp dumps it, is read too.
    np.save(tmp_path / "f.npy", np.float32([row(rotation=turn)]))
    np.testing.assert_allclose(load_grasps(tmp_path / "f.npy").poses[0], grasps.poses[0], atol=1e-6)


@pytest.mark.parametrize("gripper", [PANDA_HAND, ROBOTIQ_2F85], ids=lambda g: g.name)
def test_graspgen_comes_back(gripper, tmp_path):
    grasps = some(5, gripper, metadata={"object": "mug.obj"})
    save_grasps(tmp_path / "g.json", grasps)
    back = load_grasps(tmp_path / "g.json", gripper)
    np.testing.assert_allclose(back.poses, grasps.poses, atol=1e-15)
    for name in FIELDS[1:]:
        np.testing.assert_array_equal(getattr(back, name), getattr(grasps, name))
    assert back.metadata["object"] == "mug.obj"


def test_graspgen_as_its_documentation_has_it(tmp_path):
    transforms = [np.eye(4).tolist(), np.diag([-1.0, -1.0, 1.0, 1.0]).tolist(), np.eye(4).tolist()]
    document = {
        "object": {"file": "a.obj", "scale": 0.5},
        "grasps": {"transforms": transforms, "object_in_gripper": [True, False, True]},
    }
    (tmp_path / "g.json").write_text(json.dumps(document))
    grasps = load_grasps(tmp_path / "g.json")
    assert len(grasps) == 2  # those that held
    np.testing.assert_allclose(grasps.poses[0, :3, 3], (0, 0, 0.1034))
    np.testing.assert_allclose(grasps.poses[0, :3, 1], (1, 0, 0))  # its x closes
    np.testing.assert_array_equal(grasps.widths, 0.08)
    np.testing.assert_array_equal(grasps.scores, 1.0)


def spoiled(place, value):
    rows = np.array([row(), row(), row()])
    rows[place] = value
    return rows


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (np.zeros((3, 16)), r"expected shape \(n, 17\), got \(3, 16\)"),
        (np.zeros(17), r"expected shape \(n, 17\), got \(17,\)"),
        (spoiled((1, 0), np.nan), "row 1: .*finite number, got nan"),
        (spoiled((2, 13), np.inf), "row 2: .*finite number, got inf"),
        (spoiled((2, 14), 1e30), "row 2: .*finite"),
        (spoiled((1, 4), 2.0), "row 1: expected a rotation"),
        (spoiled((slice(None), slice(4, 13)), -np.eye(3).ravel()), "row 0: expected a rotation"),
        (spoiled((0, 1), -0.1), "row 0: width: expected 0 or more, got -0.1"),
        (np.array([["a"] * 17]), "expected numbers"),
    ],
)
def test_graspnet_rows_that_are_none_are_refused(rows, message, tmp_path):
    np.save(tmp_path / "bad.npy", rows)
    with pytest.raises(InputError, match=message) as caught:
        load_grasps(tmp_path / "bad.npy")
    assert str(caught.value).startswith(str(tmp_path / "bad.npy"))


def test_pickles_are_not_loaded(tmp_path):
    np.save(tmp_path / "bad.npy", np.array([{"a": 1}]), allow_pickle=True)
    np.savez(tmp_path / "bad.npz", poses=np.array([None]), allow_pickle=True)
    for name in ("bad.npy", "bad.npz"):
        with pytest.raises(InputError, match="pickled"):
            load_grasps(tmp_path / name)


GOOD = {"transforms": [np.eye(4).tolist()] * 2}


@pytest.mark.parametrize(
    ("grasps", "message"),
    [
        (None, "expected {'grasps'"),
        ({}, "expected {'grasps'"),
        ({"transforms": 3}, "expected a list of 4x4"),
        ({"transforms": [np.eye(4).tolist(), np.eye(3).tolist()]}, r"row 1: transforms: .* got shape \(3, 3\)"),
        ({"transforms": [["a"]]}, "row 0: transforms: expected a 4x4 matrix of numbers"),
        ({"transforms": [np.eye(4).tolist(), np.diag([1.0, 1, 2, 1]).tolist()]}, "row 1: expected a rotation"),
        ({"transforms": [np.full((4, 4), 1e400).tolist()]}, "is not a JSON number"),
        ({**GOOD, "object_in_gripper": [True]}, "expected 2 times true or false"),
        ({**GOOD, "widths": [0.1]}, r"widths: expected shape \(2,\), got \(1,\)"),
        ({**GOOD, "widths": [0.1, -0.2]}, "row 1: width"),
        ({**GOOD, "scores": ["a", "b"]}, "scores: expected 2 rows of numbers"),
        ({**GOOD, "contacts": [[[0, 0, 0]]] * 2}, r"contacts: expected shape \(2, 2, 3\)"),
    ],
)
def test_graspgen_that_is_none_is_refused(grasps, message, tmp_path):
    (tmp_path / "bad.json").write_text(json.dumps({"grasps": grasps}))
    with pytest.raises(InputError, match=message) as caught:
        load_grasps(tmp_path / "bad.json")
    assert str(tmp_path / "bad.json") in str(caught.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda a, w: a.pop("widths"), "no array 'widths'"),
        (lambda a, w: w.update(schema="graft-grasps/9"), "schema: expected 'graft-grasps/1', got 'graft-grasps/9'"),
        (lambda a, w: a.update(scores=a["scores"][:2]), r"scores: expected numbers of shape \(5,\)"),
        (lambda a, w: a.update(scores=a["scores"] * np.nan), "row 0: scores: expected a finite number"),
        (lambda a, w: a.update(poses=2 * a["poses"]), "row 0: expected a rotation"),
        (lambda a, w: w.pop("gripper"), "expected a gripper"),
        (lambda a, w: w["gripper"].update(stroke=0), "stroke: expected a positive number"),
        (lambda a, w: w["gripper"].pop("finger"), "missing 'finger'"),
        (lambda a, w: w.update(metadata=[1]), "metadata: expected strings and numbers by name"),
        (lambda a, w: w.update(rejected={"palm": "many"}), "rejected: expected counts by name"),
    ],
)
def test_an_archive_that_is_none_is_refused(change, message, tmp_path):
    path = tmp_path / "bad.npz"
    save_grasps(path, some())
    with np.load(path) as archive:
        arrays = dict(archive)
    words = json.loads(bytes(arrays["metadata"]))
    change(arrays, words)
    arrays["metadata"] = np.frombuffer(json.dumps(words).encode(), np.uint8)
    np.savez(path, **arrays)
    with pytest.raises(InputError, match=message) as caught:
        load_grasps(path)
    assert str(path) in str(caught.value)


def test_damage_is_named_and_other_suffixes_are_refused(tmp_path):
    path = tmp_path / "cut.npz"
    save_grasps(path, some())
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(InputError, match="not a zip archive"):
        load_grasps(path)
    for call in (load_grasps, lambda p: save_grasps(p, some())):
        with pytest.raises(InputError, match=r"ending in \.npz, \.npy, \.json"):
            call(tmp_path / "g.csv")


def test_an_archive_for_another_gripper_is_refused(tmp_path):
    save_grasps(tmp_path / "g.npz", some())
    assert len(load_grasps(tmp_path / "g.npz", PANDA_HAND)) == 5
    with pytest.raises(InputError, match="for 'panda_hand', not 'robotiq_2f85'"):
        load_grasps(tmp_path / "g.npz", ROBOTIQ_2F85)

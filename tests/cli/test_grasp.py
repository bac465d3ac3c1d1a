"""`graft grasp`: where it grasps, what it prints and writes, how it fails."""

import json

import numpy as np
import pytest

from graft import zoo
from graft.cli import EXIT_BAD_INPUT, EXIT_FAILED, EXIT_OK, EXIT_USAGE, main
from graft.grasp import PANDA_HAND, ROBOTIQ_2F85, GraspSet, load_grasps, save_grasps, save_gripper
from graft.io import save_demonstration, save_object


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A mug on disk, demonstrations beside it, and a file of grasps around its handle."""
    root = tmp_path_factory.mktemp("grasp")
    mug = zoo.make("mug", seed=3)
    save_object(root / "mug.glb", mug)
    for category in ("mug", "kettle"):
        save_demonstration(root / "demos" / category, zoo.demonstration(category))
    handle = mug.parts[mug.part_index("handle")].vertices * (mug.scale_to_metres or 1.0)
    low, high = handle.min(axis=0), handle.max(axis=0)
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, :3, :3] = np.stack([(0, 0, 1.0), (0, 1.0, 0), (-1.0, 0, 0)], axis=1)
    poses[:, :3, 3] = [high[0] - 0.005, 0.0, (low[2] + high[2]) / 2]
    poses[:, 2, 3] += [0.0, 0.012, 0.5]
    grasps = GraspSet(poses, np.full(3, 0.015), [0.9, 0.8, 0.7], np.zeros((3, 2, 3)), np.zeros(3), PANDA_HAND)
    save_grasps(root / "grasps.npz", grasps)
    (root / "contact.txt").write_text(" ".join(map(str, poses[0, :3, 3] + [0.005, 0, 0])))
    return root


def run(folder, *arguments):
    return main(["grasp", str(folder / "mug.glb"), "--planner", str(folder / "grasps.npz"), *map(str, arguments)])


def contact(folder):
    return ["--contact", *(folder / "contact.txt").read_text().split()]


def test_the_help_names_the_ways_to_say_where(capsys):
    assert main(["grasp", "--help"]) == EXIT_OK
    printed = capsys.readouterr().out
    for flag in (
        "--library",
        "--contact",
        "--part",
        "--gripper",
        "--planner",
        "--support",
        "--seed",
        "--json",
        "--out",
    ):
        assert flag in printed


def test_a_table_has_a_row_per_grasp(folder, capsys):
    assert run(folder, *contact(folder)) == EXIT_OK
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].endswith("near a contact on handle, panda_hand")
    assert lines[1].split() == ["score", "width", "mm", "distance", "mm", "TCP", "(m)", "approach", "closing"]
    assert [line.split()[:3] for line in lines[2:]] == [["1", "0.900", "15.0"], ["2", "0.800", "15.0"]]


def test_json_is_one_document_and_nothing_else(folder, capsys):
    assert run(folder, "--json", "--seed", 4, *contact(folder)) == EXIT_OK
    document = json.loads(capsys.readouterr().out)
    assert document["contact"]["part"] == "handle"
    assert document["gripper"] == "panda_hand"
    assert document["metadata"]["seed"] == 4
    assert [grasp["score"] for grasp in document["grasps"]] == [0.9, 0.8]
    assert document["rejected"] == {"far from the contact": 1}
    assert np.shape(document["grasps"][0]["T_object_gripper"]) == (4, 4)
    assert document["grasps"][0]["distance_metres"] <= 0.02


def test_a_library_says_where(folder, capsys):
    assert run(folder, "--library", folder / "demos", "--json") == EXIT_OK
    assert json.loads(capsys.readouterr().out)["contact"]["part"] == "handle"


def test_a_part_says_where(folder, capsys):
    assert run(folder, "--part", "handle", "--json") in (EXIT_OK, EXIT_FAILED)
    document = json.loads(capsys.readouterr().out)
    assert document["contact"] is None
    assert all(grasp["distance_metres"] is None for grasp in document["grasps"])
    assert run(folder, "--part", "spout") == EXIT_BAD_INPUT
    assert "no part called 'spout'" in capsys.readouterr().err


def test_every_kind_of_file_is_written(folder, tmp_path):
    pytest.importorskip("viser")
    names = ["g.npz", "g.npy", "g.json", "g.png", "g.html", "g.glb"]
    outs = [str(tmp_path / name) for name in names]
    assert run(folder, "--k", 2, "--out", *outs, *contact(folder)) == EXIT_OK
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(names)
    for name in names[:3]:
        assert len(load_grasps(tmp_path / name)) == 2
    assert load_grasps(tmp_path / "g.npz").metadata["seed"] == 0


def test_no_grasp_is_a_failure_that_says_why(folder, tmp_path, capsys):
    save_grasps(tmp_path / "far.npz", load_grasps(folder / "grasps.npz")[2:])
    arguments = ["grasp", str(folder / "mug.glb"), "--planner", str(tmp_path / "far.npz"), *contact(folder)]
    assert main([*arguments, "--out", str(tmp_path / "g.npy")]) == EXIT_FAILED
    printed = capsys.readouterr().out
    assert "no grasp" in printed
    assert "1 rejected: far from the contact" in printed
    assert not (tmp_path / "g.npy").exists()
    assert main([*arguments, "--json"]) == EXIT_FAILED
    assert json.loads(capsys.readouterr().out)["grasps"] == []


def test_a_gripper_comes_from_a_file(folder, tmp_path, capsys):
    save_gripper(tmp_path / "hand.toml", PANDA_HAND)
    assert run(folder, "--gripper", tmp_path / "hand.toml", *contact(folder)) == EXIT_OK
    save_gripper(tmp_path / "hand.toml", ROBOTIQ_2F85)
    capsys.readouterr()
    assert run(folder, "--gripper", tmp_path / "hand.toml") == EXIT_BAD_INPUT
    assert "the grasps are for 'panda_hand', not 'robotiq_2f85'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--contact", "1", "1", "1"], "off the surface of"),
        (["--part", "handle", "--contact", "0", "0", "0"], "--contact and --part: expected one of them"),
        (["--gripper", "panda"], "did you mean 'panda_hand'?"),
        (["--gripper", "missing.toml"], "missing.toml: no such file"),
        (["--planner", "anygrasp"], "--planner: expected antipodal"),
        (["--planner", "missing.npz"], "missing.npz: no such file"),
        (["--planner", "missing.tar"], "missing.tar: no such checkpoint"),
        (["-k", "0"], "-k: expected at least 1, got 0"),
        (["--out", "g.txt"], "--out: expected a file ending in .npz, .npy, .json, .png, .html, .glb"),
        (["--scale-to-metres", "1000"], "expected a diagonal of 0.005 to 5 m"),
    ],
)
def test_bad_input_is_one_line(folder, arguments, message, capsys, monkeypatch):
    import sys
    from types import ModuleType

    module = ModuleType("gsnet")
    module.AnyGrasp = object
    monkeypatch.setitem(sys.modules, "gsnet", module)
    assert main(["grasp", str(folder / "mug.glb"), *arguments]) == EXIT_BAD_INPUT
    errors = [line for line in capsys.readouterr().err.splitlines() if not line.startswith("graft: warning")]
    assert len(errors) == 1
    assert message in errors[0]


def test_flags_that_are_none_are_usage_errors(folder):
    assert run(folder, "--contact", "0", "0") == EXIT_USAGE
    assert run(folder, "--support", "table") == EXIT_USAGE

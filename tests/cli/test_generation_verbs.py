"""`graft demonstrate`, `generate` and `replay`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import trimesh

from graft.cli import EXIT_BAD_INPUT, EXIT_FAILED, EXIT_OK, main

pytest.importorskip("mujoco")
pytest.importorskip("h5py")


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("library")
    assert main(["demonstrate", "wine_bottle", "--out", str(folder)]) == EXIT_OK
    return str(folder)


@pytest.fixture
def objects(tmp_path: Path) -> str:
    folder = tmp_path / "objects"
    folder.mkdir()
    trimesh.creation.cylinder(0.025, 0.15).export(folder / "tube.ply")
    return str(folder)


def test_demonstrations_become_a_library(library: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demonstrate", "wine_bottle", "--seed", "1", "--out", library, "--json"]) == EXIT_OK
    (made,) = json.loads(capsys.readouterr().out)["demonstrations"]
    assert made["demonstration"] == "wine_bottle_1"
    assert list(made["segments"]) == ["reach", "grasp", "lift", "hold"]
    assert (Path(library) / "wine_bottle_1" / "trajectory.npz").is_file()


def test_it_generates_resumes_and_replays(
    library: str, objects: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = ["generate", "--library", library, "--objects", objects, "--out", str(tmp_path / "run")]
    assert main([*run, "--n", "2"]) == EXIT_OK
    out = capsys.readouterr().out
    assert "of 2 attempts kept" in out
    assert main([*run, "--n", "3", "--json"]) == EXIT_OK
    told = json.loads(capsys.readouterr().out)
    assert (told["attempts"], told["resumed"]) == (3, 2)
    assert told["kept"] >= 1
    assert main(["replay", str(tmp_path / "run" / "episodes.hdf5"), "--json"]) == EXIT_OK
    replayed = json.loads(capsys.readouterr().out)
    assert replayed["same"] == told["kept"] == len(replayed["episodes"])


def test_switches_override_the_method(
    library: str, objects: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = ["generate", "--library", library, "--objects", objects, "--n", "1", "--json", "--out", str(tmp_path / "run")]
    main([*run, "--method", "vanilla", "--anchor", "grasp", "--mass", "0.2", "0.3"])
    config = json.loads(capsys.readouterr().out)["config"]
    assert (config["select"], config["anchor"], config["reach"]) == ("random", "grasp", "linear")
    assert config["random"]["mass"] == [0.2, 0.3]


def test_an_object_that_no_gripper_holds_is_one_line(
    library: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "objects"
    folder.mkdir()
    trimesh.creation.box((0.3, 0.3, 0.3)).export(folder / "crate.ply")
    run = ["generate", "--library", library, "--objects", str(folder), "--n", "2", "--out", str(tmp_path / "run")]
    assert main(run) == EXIT_FAILED
    assert capsys.readouterr().err == "graft: crate: panda_hand found no way to hold it\n"


@pytest.mark.parametrize(
    ("flags", "line"),
    [
        (["--task", "fly"], "--task: expected one of lift"),
        (["--n", "0"], "n: expected at least 1"),
        (["--noise", "-1"], "noise: expected a number of at least 0"),
        (["--gripper", "claw"], "claw"),
        (["--force", "500"], "force: gripper 'panda_hand' gives at most 70 N"),
        (["--objects", "nowhere"], "nowhere: --objects: expected a folder of objects, zoo or ycb"),
        (["--library", "nowhere"], "nowhere"),
    ],
)
def test_bad_flags_are_one_line_and_nothing_is_written(
    library: str, objects: str, tmp_path: Path, flags: list[str], line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    run = ["generate", "--library", library, "--objects", objects, "--out", str(tmp_path / "run"), *flags]
    assert main(run) == EXIT_BAD_INPUT
    err = capsys.readouterr().err
    assert line in err
    assert err.count("\n") == 1
    assert not (tmp_path / "run").exists()


def test_what_cannot_be_demonstrated_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demonstrate", "teapt", "--out", str(tmp_path)]) == EXIT_BAD_INPUT
    assert "did you mean 'teapot'?" in capsys.readouterr().err
    assert main(["demonstrate", "mug", "--friction", "0.01", "--json", "--out", str(tmp_path)]) == EXIT_FAILED
    (row,) = json.loads(capsys.readouterr().out)["demonstrations"]
    assert row["reason"].startswith("object 'mug_0': none of ")
    assert not list(tmp_path.iterdir())

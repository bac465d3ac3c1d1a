"""`graft simulate`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import trimesh

from graft.cli import EXIT_BAD_INPUT, EXIT_FAILED, EXIT_OK, main

pytest.importorskip("mujoco")


@pytest.fixture
def block(tmp_path: Path) -> str:
    mesh = trimesh.creation.box((0.05, 0.05, 0.1))
    mesh.export(tmp_path / "block.ply")
    return str(tmp_path / "block.ply")


def test_a_block_is_planned_for_and_held(block: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", block, "--json", "-k", "2"]) == EXIT_OK
    document = json.loads(capsys.readouterr().out)
    assert document["successes"] == 2
    assert [trial["outcome"] for trial in document["trials"]] == ["success", "success"]
    assert document["trials"][0]["config"]["friction"] == 0.5


def test_grasps_come_from_a_file(block: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = str(tmp_path / "grasps.npz")
    assert main(["grasp", block, "-k", "3", "--out", file]) == EXIT_OK
    capsys.readouterr()
    trials = str(tmp_path / "trials.jsonl")
    assert main(["simulate", block, "--grasps", file, "-k", "3", "--trials", trials]) == EXIT_OK
    assert capsys.readouterr().out.count("success") == 3
    assert len(Path(trials).read_bytes().splitlines()) == 3


def test_what_is_too_wide_gives_no_grasp(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    trimesh.creation.box((0.2, 0.2, 0.2)).export(tmp_path / "wide.ply")
    assert main(["simulate", str(tmp_path / "wide.ply"), "--json"]) == EXIT_FAILED
    (trial,) = json.loads(capsys.readouterr().out)["trials"]
    assert trial["outcome"] == "no_grasp"
    assert trial["reason"].startswith("no grasp: ")


def test_slippery_and_heavy_fails(block: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", block, "--friction", "0.1", "--mass", "2"]) == EXIT_FAILED
    assert "success" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("flags", "line"),
    [
        (["--friction", "-1"], "simulation friction: expected at least 0"),
        (["--grasps", "a.npz", "--part", "x"], "--grasps and --part: expected one of them"),
        (["--out", "trial.gif"], "--out: expected a file ending in .png, .mp4"),
        (["-k", "0"], "-k: expected at least 1"),
    ],
)
def test_bad_flags_are_one_line(block: str, flags: list[str], line: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", block, *flags]) == EXIT_BAD_INPUT
    err = capsys.readouterr().err
    assert line in err
    assert err.count("\n") == 1

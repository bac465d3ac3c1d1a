import json
import sys
from pathlib import Path

import pytest

from graft.cli import EXIT_BAD_INPUT, EXIT_OK, EXIT_USAGE, main

pytest.importorskip("h5py")
pytest.importorskip("av")

from graft.datagen.export import open_writer

sys.path.insert(0, str(Path(__file__).parents[1] / "datagen"))
from sample_episodes import episode


@pytest.fixture
def source(tmp_path):
    with open_writer(tmp_path / "lift.hdf5") as writer:
        for number in range(3):
            writer.append(episode(number))
    return tmp_path / "lift.hdf5"


def test_export_says_what_it_wrote(source, tmp_path, capsys):
    target = tmp_path / "lift"
    assert main(["export", str(source), str(target)]) == EXIT_OK
    assert capsys.readouterr().out == f"{target}: 3 episodes, 33 steps (lerobot)\n"
    assert main(["export", str(source), str(target), "--format", "lerobot"]) == EXIT_OK
    assert "0 episodes, 0 steps (lerobot), 3 were there already" in capsys.readouterr().out
    assert main(["export", str(target), str(tmp_path / "again.h5"), "--json"]) == EXIT_OK
    assert json.loads(capsys.readouterr().out) == {
        "source": str(target), "target": str(tmp_path / "again.h5"),
        "format": "robomimic", "written": 3, "present": 0, "steps": 33,
    }  # fmt: skip


def test_bad_input_is_one_line(source, tmp_path, capsys):
    bad = tmp_path / "bad.hdf5"
    bad.write_bytes(b"hello")
    for arguments, words in [
        ([str(bad), str(tmp_path / "x")], "bad.hdf5: not an HDF5 file"),
        ([str(tmp_path / "gone"), str(tmp_path / "x")], "gone: no such dataset"),
        ([str(source), str(tmp_path / "x.csv")], "x.csv: expected .hdf5 or .h5"),
        ([str(source), str(tmp_path / "x.hdf5"), "--format", "lerobot"], "a LeRobot dataset is a folder"),
        ([str(source), str(tmp_path)], "the folder holds other files, nothing is written"),
    ]:
        assert main(["export", *arguments]) == EXIT_BAD_INPUT
        printed = capsys.readouterr()
        assert printed.out == ""
        assert printed.err.count("\n") == 1
        assert printed.err.startswith("graft: ")
        assert words in printed.err
    assert main(["export", str(source)]) == EXIT_USAGE
    assert not (tmp_path / "x").exists()

"""What docs/generation.md shows runs as it stands."""

import re
from pathlib import Path

import pytest

pytest.importorskip("mujoco")
pytest.importorskip("h5py")

PAGE = (Path(__file__).parents[2] / "docs" / "generation.md").read_text()


def test_its_python_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for block in re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL):
        exec(compile(block, "generation.md", "exec"), {})
    assert capsys.readouterr().out.startswith("2 Counter({'success': 2})")
    assert (tmp_path / "run" / "episodes.hdf5").exists()


def test_its_outcomes_are_those_there_are():
    from graft.datagen.judge import AttemptOutcome

    told = re.findall(r"^\| `(\w+)` \|", PAGE.split("| outcome |")[1].split("\n\n")[0], flags=re.MULTILINE)
    assert told == [outcome.value for outcome in AttemptOutcome]

"""What docs/grasps.md shows runs as it stands."""

import re
from pathlib import Path

from graft.grasp import PANDA_HAND, load_gripper

PAGE = (Path(__file__).parents[2] / "docs" / "grasps.md").read_text()


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, flags=re.DOTALL)


def test_its_python_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for block in blocks("python"):
        exec(compile(block, "grasps.md", "exec"), {})
    assert (tmp_path / "hand.toml").exists()


def test_its_gripper_is_the_panda(tmp_path):
    (block,) = blocks("toml")
    (tmp_path / "my.toml").write_text(block)
    gripper = load_gripper(tmp_path / "my.toml")
    assert gripper.name == "my_gripper"
    assert gripper.stroke == PANDA_HAND.stroke
    for mine, theirs in zip(gripper.boxes(0.05), PANDA_HAND.boxes(0.05), strict=True):
        assert abs(mine.corners - theirs.corners).max() < 1e-12

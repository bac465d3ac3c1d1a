"""Grippers from TOML: what goes out comes back, and a file that cannot be used is named with its field."""

import numpy as np
import pytest

from graft.errors import InputError
from graft.grasp import PANDA_HAND, ROBOTIQ_2F85, Box, Gripper, find_gripper, load_gripper, save_gripper

SMALL = """
name = "small"
stroke = 0.05
flange = 0.1
palm = []
[[finger]]
center = [0.0, 0.005, 0]
half_extents = [0.01, 0.005, 0.01]
"""


def oblique():
    c, s = np.cos(0.3), np.sin(0.3)
    turn = np.array([[1.0, 0, 0], [0, c, -s], [0, s, c]])
    flange = np.eye(4)
    flange[:3, :3], flange[:3, 3] = turn, (0.01, 0.02, 0.1)
    finger = (Box.spanning((-0.01, 0, -0.01), (0.01, 0.01, 0.01)), Box((0, 0.03, -0.05), (0.01, 0.01, 0.03), turn))
    return Gripper('ein "Greifer"\x7f\\ é', 1 / 30, (), finger, flange, 7.0, 9.0, 0.1)


@pytest.mark.parametrize("gripper", [PANDA_HAND, ROBOTIQ_2F85, oblique()], ids=lambda g: g.name[:5])
def test_a_gripper_comes_back_from_its_file_to_the_last_bit(gripper, tmp_path):
    save_gripper(tmp_path / "g.toml", gripper)
    back = load_gripper(tmp_path / "g.toml")
    assert (back.name, back.force, back.max_force, back.mass) == (
        gripper.name,
        gripper.force,
        gripper.max_force,
        gripper.mass,
    )
    assert back.is_like(gripper)


def test_a_small_file_is_enough(tmp_path):
    (tmp_path / "small.toml").write_text(SMALL)
    gripper = find_gripper(tmp_path / "small.toml")
    assert (gripper.name, gripper.stroke, gripper.reach, gripper.palm) == ("small", 0.05, 0.1, ())


@pytest.mark.parametrize(("line", "force", "most"), [("force = 120", 120, 120), ("max_force = 5", 5, 5)])
def test_one_force_sets_a_bound_for_the_other(line, force, most, tmp_path):
    (tmp_path / "g.toml").write_text(SMALL.replace("palm", f"{line}\npalm"))
    gripper = load_gripper(tmp_path / "g.toml")
    assert (gripper.force, gripper.max_force) == (force, most)


def test_built_in_grippers_are_found_by_name():
    assert find_gripper("panda_hand") is PANDA_HAND
    assert find_gripper("robotiq_2f85") is ROBOTIQ_2F85
    with pytest.raises(InputError, match=r"panda_hand, robotiq_2f85, or a .toml.*did you mean 'panda_hand'"):
        find_gripper("panda_hnad")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "small"', "", "missing 'name'"),
        ("stroke = 0.05", "", "missing 'stroke'"),
        ("flange = 0.1", "", "missing 'flange'"),
        ("stroke = 0.05", "stroke = 0", "stroke: expected a positive number, got 0"),
        ("stroke = 0.05", "stroke = 'wide'", "stroke: expected a number, got 'wide'"),
        ("stroke = 0.05", "stroke = nan", "stroke: expected a number, got nan"),
        ("stroke = 0.05", "stroke = true", "stroke: expected a number, got True"),
        ("stroke", "strok", "unknown key 'strok'; did you mean 'stroke'"),
        ("center", "centre", "finger box 1: unknown key 'centre'; did you mean 'center'"),
        ("half_extents = [0.01, 0.005, 0.01]", "", "finger box 1: missing 'half_extents'"),
        ("[0.01, 0.005, 0.01]", "[0.01, 0.005]", "finger box 1 half_extents: expected three numbers"),
        ("[0.01, 0.005, 0.01]", "[0.01, -0.005, 0.01]", "finger box 1: .*expected positive numbers"),
        ("flange = 0.1", "flange = 'ahead'", "flange: expected a number or a table"),
        ("flange = 0.1", "flange = {position = [0, 0]}", "flange position: expected three numbers"),
        ("flange = 0.1", "flange = {position = [0, 0, 0], rotation = [1]}", "flange rotation: expected three rows"),
        ("palm = []", "palm = 3", "palm: expected boxes"),
        ("palm = []", "palm = [", "not TOML"),
        ('name = "small"', "name = 3", "name: expected a string, got 3"),
    ],
)
def test_a_file_that_cannot_be_used_is_named_with_its_field(old, new, message, tmp_path):
    assert old in SMALL
    path = tmp_path / "bad.toml"
    path.write_text(SMALL.replace(old, new))
    with pytest.raises(InputError, match=message) as caught:
        load_gripper(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_other_files_are_refused(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        load_gripper(tmp_path / "none.toml")
    (tmp_path / "latin.toml").write_bytes(b'name = "\xe9"')
    with pytest.raises(InputError, match="not TOML"):
        load_gripper(tmp_path / "latin.toml")
    with pytest.raises(InputError, match=r"expected \.toml, \.xml or \.urdf, got '\.json'"):
        load_gripper(tmp_path / "hand.json")
    with pytest.raises(InputError, match=r"ending in \.toml"):
        save_gripper(tmp_path / "hand.json", PANDA_HAND)

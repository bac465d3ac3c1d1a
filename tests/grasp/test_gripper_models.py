"""Grippers from the MJCF or URDF of their hands: found where a hand of known sizes was written down."""

import numpy as np
import pytest

from graft.errors import InputError
from graft.grasp import load_gripper

FINGER = """
<body name="{name}" pos="0 {y} 0.05"><joint name="{name}_joint" type="slide" axis="{axis}" range="{range}"/>
  <geom type="box" size="0.01 0.005 0.01" pos="0 {pad} 0.06"/>
  <geom type="box" size="0.012 0.01 0.025" pos="0 {shank} 0.025"/></body>"""


def mjcf(left_axis="0 -1 0", closed=True, left_pad=None, extra=""):
    """A hand 60 mm wide open: pads of 20 x 10 x 20 mm, their middle 110 mm from the flange."""
    y = 0.0 if closed else 0.03
    reach = "0 0.03" if closed else "-0.03 0"
    right = FINGER.format(name="right", y=y, axis="0 1 0", range=reach, pad=0.005, shank=0.02)
    left_range = reach if left_axis == "0 -1 0" else "-0.03 0"
    pad = -0.005 if left_pad is None else left_pad
    left = FINGER.format(name="left", y=-y, axis=left_axis, range=left_range, pad=pad, shank=-0.02)
    return f"""<mujoco><worldbody><body name="hand"><geom type="box" size="0.03 0.08 0.02" pos="0 0 0.02"/>
    {right}{left}{extra}</body></worldbody></mujoco>"""


def urdf(root="", joint="prismatic"):
    def link(name, *boxes):
        shapes = "".join(
            f'<visual><origin xyz="{x}"/><geometry><box size="{s}"/></geometry></visual>' for s, x in boxes
        )
        return f'<link name="{name}">{shapes}</link>'

    def slide(name, child, axis):
        return (
            f'<joint name="{name}" type="{joint}"><parent link="hand"/><child link="{child}"/>'
            f'<origin xyz="0 0 0.05"/><axis xyz="{axis}"/>'
            '<limit lower="0" upper="0.03" effort="9" velocity="1"/></joint>'
        )

    fingers = [
        link(n, ("0.02 0.01 0.02", f"0 {s * 0.005} 0.06"), ("0.024 0.02 0.05", f"0 {s * 0.02} 0.025"))
        for n, s in (("right", 1), ("left", -1))
    ]
    hand = link("hand", ("0.06 0.16 0.04", "0 0 0.02"))
    slides = slide("a", "right", "0 1 0") + slide("b", "left", "0 -1 0")
    return f'<robot name="hand">{root}{hand}{"".join(fingers)}{slides}</robot>'


ARM = """<link name="base"/><joint name="wrist" type="revolute"><parent link="base"/><child link="hand"/>
<origin xyz="0.3 0 0.5" rpy="3.14159265358979 0 0.785398163397448"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""


THIRD = '<body><joint type="slide" axis="0 1 0"/><geom size="0.01"/></body>'

LIFT = """<link name="base"/><joint name="lift" type="prismatic"><parent link="base"/><child link="hand"/>
<origin xyz="0 0 1"/><axis xyz="0 1 0"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint>"""


def check(gripper):
    assert gripper.stroke == pytest.approx(0.06, abs=1e-6)
    assert gripper.reach == pytest.approx(0.11, abs=1e-3)
    low, high = gripper.pad.corners.min(axis=0), gripper.pad.corners.max(axis=0)
    # The pad ends where the slab that its lower edge cuts ends.
    np.testing.assert_allclose((low[1], high[2], high[0]), (0.0, 0.01, 0.01), atol=2.3e-3)
    corners = np.concatenate([box.corners for box in gripper.finger])
    np.testing.assert_allclose(corners[:, :2].min(axis=0), (-0.012, 0.0), atol=1e-6)
    np.testing.assert_allclose(corners[:, :2].max(axis=0), (0.012, 0.03), atol=1e-6)
    assert np.ptp(corners[:, 2]) == pytest.approx(0.07, abs=1e-6)
    palm = np.concatenate([box.corners for box in gripper.palm])
    np.testing.assert_allclose(np.ptp(palm, axis=0), (0.06, 0.16, 0.04), atol=1e-6)
    assert palm[:, 2].min() == pytest.approx(-gripper.reach, abs=1e-6)


@pytest.mark.parametrize("options", [{}, {"closed": False}, {"left_axis": "0 1 0"}], ids=["shut", "open", "one axis"])
def test_a_hand_is_found_in_mjcf(options, tmp_path):
    pytest.importorskip("mujoco")
    (tmp_path / "hand.xml").write_text(mjcf(**options))
    check(load_gripper(tmp_path / "hand.xml"))


@pytest.mark.parametrize("root", ["", ARM, LIFT], ids=["alone", "on an arm that points down", "on a lift"])
def test_a_hand_is_found_in_urdf(root, tmp_path):
    (tmp_path / "hand.urdf").write_text(urdf(root))
    check(load_gripper(tmp_path / "hand.urdf"))


def test_a_finger_turned_by_half_is_as_good_as_a_mirrored_one(tmp_path):
    """Both fingers have a knob of 4 mm on the side that is +x of the right one and, turned, -x of the left one."""
    knob = '<visual><origin xyz="{x} {y} 0.06"/><geometry><box size="0.008 0.006 0.02"/></geometry></visual></link>'
    text = urdf()
    for link, sign in (("right", 1), ("left", -1)):
        head, tail = text.split(f'<link name="{link}">')
        body, rest = tail.split("</link>", 1)
        text = f'{head}<link name="{link}">{body}{knob.format(x=sign * 0.01, y=sign * 0.005)}{rest}'
    (tmp_path / "hand.urdf").write_text(text)
    gripper = load_gripper(tmp_path / "hand.urdf")
    assert gripper.stroke == pytest.approx(0.06)
    np.testing.assert_allclose(gripper.pad.corners[:, 0].min(), -0.014)
    np.testing.assert_allclose(gripper.pad.corners[:, 0].max(), 0.014)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            lambda: urdf(joint="revolute"),
            "found 0 such pairs among 0 slide joints and 2 hinges; describe .* in a .toml",
        ),
        (lambda: mjcf(left_axis="0 0 1"), "found 0 such pairs among 2 slide joints .right_joint, left_joint. and 0"),
        (lambda: mjcf(left_pad=0.002), "no mirror images"),
        (lambda: mjcf().replace(' range="0 0.03"', ""), "'right_joint': expected limits"),
        (lambda: urdf().replace('upper="0.03"', 'upper="0"'), "expected limits"),
        (lambda: mjcf(extra=THIRD), "found 3 such pairs among 3 slide joints"),
        (lambda: urdf().replace("prismatic", "fixed"), "found 0 such pairs among 0 slide joints and 0 hinges"),
    ],
)
def test_a_model_without_such_a_gripper_says_why(text, message, tmp_path):
    content = text()
    path = tmp_path / ("hand.urdf" if content.startswith("<robot") else "hand.xml")
    if path.suffix == ".xml":
        pytest.importorskip("mujoco")
    path.write_text(content)
    with pytest.raises(InputError, match=message) as caught:
        load_gripper(path)
    assert str(path) in str(caught.value)

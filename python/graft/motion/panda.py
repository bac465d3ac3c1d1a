"""A Franka Panda as MJCF built from primitives: nothing is fetched, and the same text plans and simulates."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from graft.checks import Floats
from graft.grasp import PANDA_HAND, Box, Gripper

HOME = (0.0, -0.785398, 0.0, -2.356194, 0.0, 1.570796, 0.785398)
"""Franka's ready position, radians."""

TCP_SITE = "tcp"
"""Name of the site whose frame is the gripper frame of `graft.grasp.gripper`."""

QUARTER = float(np.sqrt(0.5))

# Body offset, quaternion wxyz (turns about x), joint limits, capsules (from, to, radius) in the link's frame.
# Offsets and limits: Franka's data sheet (the Denavit-Hartenberg parameters of the control interface). Capsules: the
# shape of the coarse collision model that Franka publishes for its arm.
LINKS = (
    ((0, 0, 0.333), (1, 0, 0, 0), (-2.8973, 2.8973), (((0, 0, -0.2), (0, 0, -0.05), 0.06),)),
    ((0, 0, 0), (QUARTER, -QUARTER, 0, 0), (-1.7628, 1.7628), (((0, 0, -0.06), (0, 0, 0.06), 0.06),)),
    ((0, -0.316, 0), (QUARTER, QUARTER, 0, 0), (-2.8973, 2.8973), (((0, 0, -0.22), (0, 0, -0.07), 0.06),)),
    ((0.0825, 0, 0), (QUARTER, QUARTER, 0, 0), (-3.0718, -0.0698), (((0, 0, -0.06), (0, 0, 0.06), 0.06),)),
    (
        (-0.0825, 0.384, 0),
        (QUARTER, -QUARTER, 0, 0),
        (-2.8973, 2.8973),
        (((0, 0, -0.31), (0, 0, -0.21), 0.06), ((0, 0.08, -0.2), (0, 0.08, -0.06), 0.025)),
    ),
    (
        (0, 0, 0),
        (QUARTER, QUARTER, 0, 0),
        (-0.0175, 3.7525),
        (((0, 0, -0.07), (0, 0, 0.01), 0.05),),
    ),
    ((0.088, 0, 0), (QUARTER, QUARTER, 0, 0), (-2.8973, 2.8973), (((0, 0, -0.06), (0, 0, 0.08), 0.04),)),
)

BASE = (((-0.09, 0, 0.06), (0, 0, 0.06), 0.06),)
"""Capsules of the link that stands on the table."""

OVERLAPPING = (("link0", "link1"), ("link1", "link3"))
"""Links that cannot touch for their joints, though the capsules around them do."""

FLANGE = 0.107
"""From the last joint to the flange, metres; the hand is mounted there, turned by -45 degrees about z."""


def panda_mjcf(gripper: Gripper = PANDA_HAND) -> str:
    """Return an MJCF of the arm with a gripper at its flange.

    Joints: joint1 to joint7, finger_right (at +y) and finger_left, each at half the opening. Site `tcp`: the gripper
    frame. Position actuators hold all of them; the arm's gravity is compensated, as Franka's controller does.
    """
    arm = _hand(gripper)
    for k in range(len(LINKS), 0, -1):
        offset, quaternion, limits, capsules = LINKS[k - 1]
        arm = (
            f'<body name="link{k}" pos="{_text(offset)}" quat="{_text(quaternion)}" gravcomp="1">'
            f'<joint name="joint{k}" range="{_text(limits)}"/>{_capsules(capsules)}{arm}</body>'
        )
    joints = [f'<position name="joint{k}" joint="joint{k}" kp="2000" kv="200"/>' for k in range(1, len(LINKS) + 1)]
    fingers = [
        f'<position name="{name}" joint="{name}" kp="2000" kv="40" '
        f'forcerange="{-gripper.max_force:g} {gripper.max_force:g}"/>'
        for name in ("finger_right", "finger_left")
    ]
    excludes = [f'<exclude body1="{one}" body2="{other}"/>' for one, other in OVERLAPPING]
    return (
        '<mujoco model="panda"><compiler angle="radian" autolimits="true"/><option integrator="implicitfast"/>'
        '<default><joint axis="0 0 1" armature="0.1" damping="1"/><geom rgba="0.85 0.85 0.87 1"/></default>'
        f'<worldbody><body name="link0">{_capsules(BASE)}{arm}</body></worldbody>'
        f"<contact>{''.join(excludes)}</contact>"
        f"<actuator>{''.join(joints + fingers)}</actuator></mujoco>"
    )


def _hand(gripper: Gripper) -> str:
    turn = Rotation.from_euler("z", -45, degrees=True).as_quat(scalar_first=True)
    tcp = _pose(gripper.flange[:3, 3], gripper.flange[:3, :3])
    share = gripper.mass / (len(gripper.palm) + 2 * len(gripper.finger))
    palm = "".join(_box(box, share) for box in gripper.palm)
    right = "".join(_box(box, share) for box in gripper.finger)
    left = "".join(_box(box.mirrored(), share) for box in gripper.finger)
    limits = f"0 {gripper.stroke / 2:g}"

    def finger(name: str, side: int, boxes: str) -> str:
        joint = f'<joint name="{name}" type="slide" axis="0 {side} 0" range="{limits}" armature="0.05" damping="5"/>'
        return f'<body name="{name}" gravcomp="1">{joint}{boxes}</body>'

    return (
        f'<body name="hand" pos="0 0 {FLANGE}" quat="{_text(turn)}" gravcomp="1">'
        f'<body name="gripper" {tcp} gravcomp="1"><site name="{TCP_SITE}"/>{palm}'
        f"{finger('finger_right', 1, right)}{finger('finger_left', -1, left)}</body></body>"
    )


def _box(box: Box, mass: float) -> str:
    pose = _pose(box.center, box.rotation)
    return f'<geom type="box" {pose} size="{_text(box.half_extents)}" mass="{mass:.6g}"/>'


def _capsules(capsules: tuple[tuple[tuple[float, ...], tuple[float, ...], float], ...]) -> str:
    return "".join(
        f'<geom type="capsule" fromto="{_text(a)} {_text(b)}" size="{radius:g}"/>' for a, b, radius in capsules
    )


def _pose(position: Floats, rotation: Floats) -> str:
    quaternion = Rotation.from_matrix(rotation).as_quat(scalar_first=True)
    return f'pos="{_text(position)}" quat="{_text(quaternion)}"'


def _text(values: Floats | tuple[float, ...]) -> str:
    return " ".join(f"{float(v):.12g}" for v in values)

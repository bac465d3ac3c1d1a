"""Gripper frames of other people, by name.

A pose here is T_object_gripper (4, 4) in metres with the frame of `graft.grasp.gripper`. The others:

* `panda`: ours, and the frame of Franka's hand moved to the TCP. z approach, y closing.
* `graspnet`: at the TCP, x approach, y closing (GraspNet-1Billion, AnyGrasp, graspnetAPI).
* `graspgen`: at the gripper's base, `Gripper.reach` behind the TCP, z approach, x closing (GraspGen, ACRONYM's kin).
* `flange`: where the gripper is mounted, as a robot's driver wants it: T_object_flange.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from graft.checks import Floats, checked_array
from graft.errors import InputError
from graft.grasp.gripper import Gripper

Convention = Literal["panda", "graspnet", "graspgen", "flange"]
CONVENTIONS: tuple[str, ...] = get_args(Convention)

GRASPNET_AXES = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
"""GraspNet's axes as columns in our frame: its x is our z, its y ours, its z our -x."""

GRASPGEN_AXES = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""GraspGen's axes as columns in our frame: its x is our y, its y our -x, its z ours."""


def to_convention(poses: ArrayLike, convention: Convention, gripper: Gripper) -> Floats:
    """Return our poses as another convention has them.

    Args:
        poses: (..., 4, 4) T_object_gripper, metres.
        convention: One of `CONVENTIONS`.
        gripper: Where its flange and its base are.

    Returns:
        (..., 4, 4).

    Raises:
        InputError: No such convention, or not poses.
    """
    converted: Floats = _poses(poses) @ T_gripper_other(convention, gripper)
    return converted


def from_convention(poses: ArrayLike, convention: Convention, gripper: Gripper) -> Floats:
    """Return poses of another convention as ours; the inverse of `to_convention`."""
    converted: Floats = _poses(poses) @ rigid_inverse(T_gripper_other(convention, gripper))
    return converted


def T_gripper_other(convention: Convention, gripper: Gripper) -> Floats:
    """Return (4, 4) the other convention's frame in ours.

    Raises:
        InputError: No such convention.
    """
    frame = np.eye(4)
    if convention == "graspnet":
        frame[:3, :3] = GRASPNET_AXES
    elif convention == "graspgen":
        frame[:3, :3] = GRASPGEN_AXES
        frame[2, 3] = -gripper.reach
    elif convention == "flange":
        frame = rigid_inverse(gripper.flange)
    elif convention != "panda":
        raise InputError(f"convention: expected one of {', '.join(CONVENTIONS)}, got {convention!r}")
    return frame


def rigid_inverse(transform: Floats) -> Floats:
    """Return the inverse of a rotation and a translation (4, 4)."""
    inverse = np.eye(4)
    inverse[:3, :3] = transform[:3, :3].T
    inverse[:3, 3] = -transform[:3, :3].T @ transform[:3, 3]
    return inverse


def _poses(poses: ArrayLike) -> Floats:
    array = np.asarray(poses)
    if array.shape[-2:] != (4, 4):
        raise InputError(f"poses: expected shape (..., 4, 4), got {array.shape}")
    checked: Floats = checked_array("poses", array, array.shape)
    return checked

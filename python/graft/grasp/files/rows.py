"""What is checked of grasps from files, row by row."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from graft.checks import Floats
from graft.errors import InputError
from graft.grasp.grasps import not_rigid
from graft.grasp.gripper import Gripper

LARGEST = 1e6
"""Metres that no grasp is away: a thousand kilometres; larger numbers are damage."""


def check_finite(path: Path, what: str, values: Floats) -> None:
    """Raise `InputError` naming the first row of (n, ...) that is not finite or beyond `LARGEST`."""
    wrong = ~(np.abs(values) <= LARGEST)
    if wrong.any():
        place = tuple(np.argwhere(wrong)[0])
        raise InputError(f"row {place[0]}: {what}: expected a finite number, got {values[place]}", path=path)


def check_poses(path: Path, poses: Floats) -> None:
    """Raise `InputError` naming the first of (n, 4, 4) that is no rotation and translation."""
    wrong = not_rigid(poses)
    if len(wrong):
        rows = np.round(poses[wrong[0], :3, :3], 4).tolist()
        raise InputError(f"row {wrong[0]}: expected a rotation, got {rows}", path=path)


def check_widths(path: Path, widths: Floats) -> None:
    """Raise `InputError` naming the first of (n,) that is negative."""
    if (widths < 0).any():
        row = int(np.argmax(widths < 0))
        raise InputError(f"row {row}: width: expected 0 or more, got {widths[row]:g}", path=path)


def pad_contacts(poses: Floats, widths: Floats) -> Floats:
    """Return (n, 2, 3) the middles of the pads, where a file does not say where they touch."""
    aside = 0.5 * widths[:, None] * poses[:, :3, 1]
    return np.stack([poses[:, :3, 3] + aside, poses[:, :3, 3] - aside], axis=1)


def columns(
    path: Path, values: Mapping[str, object], count: int, shapes: Mapping[str, tuple[int, ...]]
) -> dict[str, Floats]:
    """Return the lists of numbers called as in `shapes`, one row for each of `count` grasps; absent ones are left out.

    Raises:
        InputError: One has another shape or holds something else.
    """
    found: dict[str, Floats] = {}
    for name, shape in shapes.items():
        if values.get(name) is None:
            continue
        try:
            array = np.array(values[name], np.float64)
        except (TypeError, ValueError, OverflowError):
            raise InputError(f"{name}: expected {count} rows of numbers", path=path) from None
        if count == 0 and array.size == 0:
            array = array.reshape(0, *shape)
        if array.shape != (count, *shape):
            raise InputError(f"{name}: expected shape {(count, *shape)}, got {array.shape}", path=path)
        check_finite(path, name, array)
        found[name] = array
    return found


def default_width(gripper: Gripper, count: int) -> Floats:
    """Return (n,) the stroke, where a file does not say how wide the object is."""
    return np.full(count, gripper.stroke)

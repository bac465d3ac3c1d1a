"""GraspNet's rows of 17 numbers (graspnetAPI, AnyGrasp): score, width, height, depth, R row-major, t, object id.

R has x along the approach and y along the closing; the fingertips are `depth` beyond t. So our TCP lies
`depth - Gripper.tip` beyond t, and what we write has the TCP as t and the tips' distance as depth.
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from graft.checks import Floats
from graft.errors import InputError
from graft.grasp.conventions import GRASPNET_AXES
from graft.grasp.files.rows import check_finite, check_poses, check_widths, pad_contacts
from graft.grasp.grasps import GraspSet
from graft.grasp.gripper import Gripper
from graft.io.arrays import read_npy
from graft.io.atomic import write_whole

COLUMNS = 17
"""score, width, height, depth, nine of R, three of t, object id."""

NO_OBJECT = -1.0
"""The object id of a grasp that belongs to no numbered object."""

OBJECT_ID = "object_id"
"""The term that keeps a file's object ids."""


def write_graspnet(path: Path, grasps: GraspSet) -> None:
    """Write grasps as GraspNet rows (n, 17) float64."""
    buffer = io.BytesIO()
    np.save(buffer, graspnet_rows(grasps), allow_pickle=False)
    write_whole(path, buffer.getvalue())


def read_graspnet(path: Path, gripper: Gripper) -> GraspSet:
    """Read GraspNet rows.

    Raises:
        InputError: Not (n, 17) finite numbers with rotations in them; the message names the row.
    """
    rows = read_npy(path)
    if rows.dtype.kind not in "fiu":
        raise InputError(f"expected numbers, got {rows.dtype}", path=path)
    return from_graspnet_rows(rows.astype(np.float64), gripper, path=path)


def graspnet_rows(grasps: GraspSet) -> Floats:
    """Return grasps as (n, 17) rows; height is the width of the pad."""
    rows = np.empty((len(grasps), COLUMNS))
    rows[:, 0], rows[:, 1] = grasps.scores, grasps.widths
    rows[:, 2], rows[:, 3] = 2.0 * grasps.gripper.pad.half_extents[0], grasps.gripper.tip
    rows[:, 4:13] = (grasps.poses[:, :3, :3] @ GRASPNET_AXES).reshape(-1, 9)
    rows[:, 13:16] = grasps.poses[:, :3, 3]
    rows[:, 16] = grasps.terms.get(OBJECT_ID, NO_OBJECT)
    return rows


def from_graspnet_rows(rows: Floats, gripper: Gripper, *, path: Path) -> GraspSet:
    """Return the grasps in (n, 17) rows; contacts are the middles of the pads.

    Args:
        rows: What the file holds.
        gripper: What closes.
        path: The file, for messages.

    Raises:
        InputError: Another shape, numbers that are not finite, or no rotation; the message names the row.
    """
    if rows.ndim != 2 or rows.shape[1] != COLUMNS:
        raise InputError(f"expected shape (n, {COLUMNS}), got {rows.shape}", path=path)
    check_finite(path, "GraspNet row", rows)
    poses = np.tile(np.eye(4), (len(rows), 1, 1))
    poses[:, :3, :3] = rows[:, 4:13].reshape(-1, 3, 3) @ GRASPNET_AXES.T
    check_poses(path, poses)
    check_widths(path, rows[:, 1])
    poses[:, :3, 3] = rows[:, 13:16] + (rows[:, 3:4] - gripper.tip) * poses[:, :3, 2]
    terms = {} if (rows[:, 16] == NO_OBJECT).all() else {OBJECT_ID: rows[:, 16]}
    contacts = pad_contacts(poses, rows[:, 1])
    return GraspSet(poses, rows[:, 1], rows[:, 0], contacts, np.zeros(len(rows)), gripper, terms)

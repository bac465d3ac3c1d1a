"""GraspGen's JSON: {"object": {"file", "scale"}, "grasps": {"transforms", "object_in_gripper"}}.

`transforms` are 4x4 matrices of the gripper's base (z approach, x closing), metres, in the frame of the mesh at that
scale; `object_in_gripper` tells which grasps held. We add widths, scores, contacts and distances beside them, and the
gripper's name; its readers leave other keys alone.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graft.errors import InputError
from graft.grasp.conventions import from_convention, to_convention
from graft.grasp.files.rows import check_finite, check_poses, check_widths, columns, default_width, pad_contacts
from graft.grasp.grasps import GraspSet
from graft.grasp.gripper import Gripper
from graft.io.atomic import write_whole
from graft.io.guards import read_json

OBJECT = "object"
"""The key of `GraspSet.metadata` that names the object's file."""


def write_graspgen(path: Path, grasps: GraspSet) -> None:
    """Write grasps as GraspGen JSON."""
    poses = to_convention(grasps.poses, "graspgen", grasps.gripper)
    document = {
        "object": {"file": str(grasps.metadata.get(OBJECT, "")), "scale": 1.0},
        "gripper": {"name": grasps.gripper.name},
        "grasps": {
            "transforms": poses.tolist(),
            "object_in_gripper": [True] * len(grasps),
            "scores": grasps.scores.tolist(),
            "widths": grasps.widths.tolist(),
            "contacts": grasps.contacts.tolist(),
            "distances": grasps.distances.tolist(),
        },
    }
    write_whole(path, (json.dumps(document, allow_nan=False) + "\n").encode())


def read_graspgen(path: Path, gripper: Gripper) -> GraspSet:
    """Read the grasps that hold, `object_in_gripper`, from GraspGen JSON.

    Without widths, the opening is the gripper's stroke; without scores, they are 1; without contacts, they are the
    middles of the pads.

    Raises:
        InputError: It is not of this layout, or a matrix is no rotation and translation; the message names the row.
    """
    document = read_json(path)
    grasps: Any = document.get("grasps")
    if not isinstance(grasps, dict) or "transforms" not in grasps:
        raise InputError("expected {'grasps': {'transforms': [...]}}", path=path)
    transforms = _matrices(path, grasps["transforms"])
    count = len(transforms)
    check_finite(path, "transforms", transforms)
    check_poses(path, transforms)
    found = columns(path, grasps, count, {"scores": (), "widths": (), "contacts": (2, 3), "distances": ()})
    poses = from_convention(transforms, "graspgen", gripper)
    widths = found.get("widths", default_width(gripper, count))
    check_widths(path, widths)
    words = document.get("object")
    name = words.get("file") if isinstance(words, dict) else None
    every = GraspSet(
        poses,
        widths,
        found.get("scores", np.ones(count)),
        found.get("contacts", pad_contacts(poses, widths)),
        found.get("distances", np.zeros(count)),
        gripper,
        metadata={OBJECT: name} if isinstance(name, str) and name else {},
    )
    return every[_held(path, grasps.get("object_in_gripper"), count)]


def _matrices(path: Path, value: Any) -> Any:
    if not isinstance(value, list):
        raise InputError(f"transforms: expected a list of 4x4 matrices, got {type(value).__name__}", path=path)
    matrices = np.empty((len(value), 4, 4))
    for row, matrix in enumerate(value):
        try:
            array = np.array(matrix, np.float64)
        except (TypeError, ValueError, OverflowError):
            raise InputError(f"row {row}: transforms: expected a 4x4 matrix of numbers", path=path) from None
        if array.shape != (4, 4):
            raise InputError(f"row {row}: transforms: expected a 4x4 matrix, got shape {array.shape}", path=path)
        matrices[row] = array
    return matrices


def _held(path: Path, value: Any, count: int) -> NDArray[np.bool_]:
    """Return the mask (n,) of grasps that held; all did where the file does not say."""
    if value is None:
        return np.ones(count, bool)
    if not isinstance(value, list) or len(value) != count or not all(v in (0, 1) for v in value):
        raise InputError(f"object_in_gripper: expected {count} times true or false", path=path)
    return np.array(value, bool)

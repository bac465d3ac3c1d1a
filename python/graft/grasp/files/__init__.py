"""Files of grasps: `save_grasps` and `load_grasps` choose the format by suffix.

| suffix | format | keeps |
|---|---|---|
| `.npz` | ours | everything, to the last bit, with the gripper, metadata, units and versions |
| `.npy` | GraspNet, 17 columns | poses, widths, scores |
| `.json` | GraspGen | poses; widths, scores, contacts and distances as keys that its readers leave alone |
"""

from __future__ import annotations

from pathlib import Path

from graft.errors import InputError
from graft.grasp.files.archive import read_archive, write_archive
from graft.grasp.files.graspgen import read_graspgen, write_graspgen
from graft.grasp.files.graspnet import read_graspnet, write_graspnet
from graft.grasp.grasps import GraspSet
from graft.grasp.gripper import PANDA_HAND, Gripper

GRASP_SUFFIXES = (".npz", ".npy", ".json")
"""Of the formats, ours first."""


def save_grasps(path: str | Path, grasps: GraspSet) -> None:
    """Write grasps to a file that is complete or not there at all; see this module for what the formats keep.

    Args:
        path: Ends in .npz, .npy or .json; folders on the way are made.
        grasps: What to write, in the order they have.

    Raises:
        InputError: Another suffix, or the file cannot be written.
    """
    file = _known(path)
    file.parent.mkdir(parents=True, exist_ok=True)
    {".npz": write_archive, ".npy": write_graspnet, ".json": write_graspgen}[file.suffix.lower()](file, grasps)


def load_grasps(path: str | Path, gripper: Gripper | None = None) -> GraspSet:
    """Read grasps.

    Args:
        path: Ends in .npz, .npy or .json.
        gripper: What the grasps are for, where the file does not say: Franka's hand by default. Of an .npz it must be
            the gripper that the file holds.

    Returns:
        The grasps in the order of the file.

    Raises:
        InputError: The file holds something else; the message names the row.
    """
    file = _known(path)
    if file.suffix.lower() == ".npz":
        grasps = read_archive(file)
        if gripper is not None and not gripper.is_like(grasps.gripper):
            raise InputError(f"gripper: the grasps are for {grasps.gripper.name!r}, not {gripper.name!r}", path=file)
        return grasps
    reader = read_graspnet if file.suffix.lower() == ".npy" else read_graspgen
    return reader(file, PANDA_HAND if gripper is None else gripper)


def _known(path: str | Path) -> Path:
    file = Path(path)
    if file.suffix.lower() not in GRASP_SUFFIXES:
        raise InputError(f"grasps: expected a file ending in {', '.join(GRASP_SUFFIXES)}", path=file)
    return file

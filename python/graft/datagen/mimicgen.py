"""Demonstrations from files with MimicGen's `datagen_info`, which have poses but no meshes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from graft.checks import Floats
from graft.datagen.hdf5 import opened
from graft.datagen.layout import DEFAULT_RATE, read_trajectory
from graft.datagen.writers.robomimic import demo_keys
from graft.errors import InputError
from graft.io.guards import parse_json
from graft.marking import closest_surface_point, mark_contact
from graft.objects import Demonstration, PartObject
from graft.trajectory import CLOSE, DEMONSTRATED, OPEN, Trajectory, checked_poses

CLOSING = (OPEN + CLOSE) / 2
"""An action above this closes the gripper."""


def import_demonstrations(
    path: str | Path,
    obj: PartObject,
    *,
    pose: str,
    part: int | str | None = None,
    anchors: Mapping[str, str | None] | None = None,
    T_eef_gripper: ArrayLike | None = None,
) -> Iterator[Demonstration]:
    """Give a demonstration for each episode of a file of robomimic with MimicGen's `datagen_info`.

    The grasp is where the gripper was, relative to the object, when the first close action was given; the contact is
    the place on the surface that is closest to the TCP then.

    Args:
        path: The HDF5 file.
        obj: The object that was taken, in the frame of the poses; its `scale_to_metres` must be known.
        pose: Name of its poses in `datagen_info/object_poses`; in the trajectories it is called `DEMONSTRATED`.
        part: On which the contact is; by default the nearest.
        anchors: Term signal ("end" after the last) -> object that the segment is relative to; by default all are
            relative to the object that was taken. The file does not say.
        T_eef_gripper: (4, 4) graft's gripper frame in the file's end effector frame; the identity by default, which
            suits robosuite's Panda.

    Raises:
        InputError: Another layout, no such pose, no close action, an object of unknown scale; file and key are named.
    """
    path = Path(path)
    scale = obj.scale_to_metres
    if scale is None:
        raise InputError(f"object {obj.name!r}: its scale_to_metres must be known to take poses in metres from {path}")
    turn = np.eye(4) if T_eef_gripper is None else checked_poses("T_eef_gripper", np.asarray(T_eef_gripper)[None])[0]
    with opened(path) as file:
        if "data" not in file or not demo_keys(file["data"]):
            raise InputError("no episodes data/demo_0, …: not a file of robomimic", path=path)
        env_args = parse_json(file["data"].attrs.get("env_args", "{}"), path=path)
        rate = env_args.get("env_kwargs", {}).get("control_freq", DEFAULT_RATE)
        for key in demo_keys(file["data"]):
            trajectory = read_trajectory(file["data"][key], path, rate=float(rate))
            where = f"data/{key}"
            trajectory = _renamed(trajectory, pose, anchors, where, path)
            trajectory = replace(
                trajectory,
                T_world_target=trajectory.T_world_target @ turn,
                T_world_gripper=_reached(trajectory) @ turn,
            )
            grasp = grasp_pose(trajectory, where, path)
            marked = mark_contact(
                obj, _nearest_part(obj, grasp[:3, 3] / scale) if part is None else part, grasp[:3, 3] / scale,
                approach=grasp[:3, 2], name=f"{path.stem}_{key}",
                metadata={"file": path.name, "episode": key, "env_name": env_args.get("env_name", "")},
            )  # fmt: skip
            yield replace(marked, grasp=grasp, trajectory=trajectory)


def grasp_pose(trajectory: Trajectory, where: str, path: Path) -> Floats:
    """Return (4, 4) T_object_gripper when the gripper is first told to close.

    Raises:
        InputError: It never is.
    """
    closing = np.flatnonzero(trajectory.gripper > CLOSING)
    opening = np.flatnonzero(trajectory.gripper <= CLOSING)
    if len(closing) == 0 or len(opening) == 0 or closing[-1] < opening[0]:
        raise InputError(f"{where}/datagen_info/gripper_action: expected the gripper to close (-1 to 1)", path=path)
    step = int(closing[closing > opening[0]][0])
    inverse = np.linalg.inv(trajectory.T_world_object[DEMONSTRATED][step])
    grasp: Floats = inverse @ _reached(trajectory)[step]
    return grasp


def _reached(trajectory: Trajectory) -> Floats:
    assert trajectory.T_world_gripper is not None  # read_trajectory requires eef_pose
    return trajectory.T_world_gripper


def _renamed(
    trajectory: Trajectory, pose: str, anchors: Mapping[str, str | None] | None, where: str, path: Path
) -> Trajectory:
    """Call the object's poses `DEMONSTRATED`, and anchor the segments."""
    poses = dict(trajectory.T_world_object)
    if pose not in poses:
        found = ", ".join(poses) or "none"
        raise InputError(f"{where}/datagen_info/object_poses/{pose}: there is none; there are {found}", path=path)
    if pose != DEMONSTRATED and DEMONSTRATED in poses:
        raise InputError(f"{where}/datagen_info/object_poses: {DEMONSTRATED!r} must be the object taken", path=path)
    own = poses.pop(pose)
    names = [segment.name for segment in trajectory.segments]
    unknown = sorted(set(anchors or {}) - set(names))
    if unknown:
        raise InputError(f"{where}: no segment {unknown[0]!r} to anchor; there are {', '.join(names)}", path=path)

    def anchor(name: str) -> str | None:
        given = pose if anchors is None else anchors.get(name, pose)
        return DEMONSTRATED if given == pose else given

    segments = tuple(replace(segment, anchor=anchor(segment.name)) for segment in trajectory.segments)
    try:
        return replace(trajectory, T_world_object={DEMONSTRATED: own, **poses}, segments=segments)
    except InputError as error:
        raise InputError(f"{where}: {error}", path=path) from None


def _nearest_part(obj: PartObject, point: Floats) -> int:
    return min(range(len(obj.parts)), key=lambda i: (closest_surface_point(obj.parts[i], point)[2], i))

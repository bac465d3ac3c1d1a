"""Trajectories as .npz files: what graft writes beside a demonstration, and what a user's own recorder can write."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from graft.checks import Floats
from graft.errors import InputError
from graft.io.arrays import read_npz
from graft.io.atomic import write_whole
from graft.io.guards import malformed_is_input_error
from graft.trajectory import Segment, Trajectory, poses_from_quaternions

OBJECT_PREFIX = "T_world_object/"
_SEGMENT_KEYS = ("segment_name", "segment_start", "segment_end")


def save_trajectory(path: str | Path, trajectory: Trajectory) -> None:
    """Write a trajectory as a .npz file, whole or absent; `load_trajectory` gives every bit of it back.

    Args:
        path: Ends in .npz; folders on the way are made.
        trajectory: What to write.

    Raises:
        InputError: Another suffix, or the system refuses.
    """
    path = Path(path)
    if path.suffix.lower() != ".npz":
        raise InputError(f"cannot write {path.suffix!r}: expected .npz", path=path)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, packed_trajectory(trajectory))


def packed_trajectory(trajectory: Trajectory) -> bytes:
    """Return the bytes of a trajectory's .npz file."""
    arrays: dict[str, Any] = {
        "times": trajectory.times,
        "T_world_target": trajectory.T_world_target,
        "gripper": trajectory.gripper,
    }
    if trajectory.T_world_gripper is not None:
        arrays["T_world_gripper"] = trajectory.T_world_gripper
    arrays |= {OBJECT_PREFIX + name: poses for name, poses in trajectory.T_world_object.items()}
    segments = trajectory.segments
    arrays |= {
        "segment_name": np.array([s.name for s in segments]),
        "segment_start": np.array([s.start for s in segments]),
        "segment_end": np.array([s.end for s in segments]),
        "segment_anchor": np.array([s.anchor or "" for s in segments]),
        "segment_signal": np.array([s.signal or "" for s in segments]),
    }
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def load_trajectory(path: str | Path) -> Trajectory:
    """Read a trajectory from a .npz file.

    Needed are `times` (t,), `gripper` (t,) and `T_world_target` (t, 4, 4), or in its place `target_position` (t, 3) and
    `target_quaternion` (t, 4), wxyz. There may be `T_world_gripper`, or `gripper_position` and `gripper_quaternion`;
    `T_world_object/<name>` (t, 4, 4) for each object; and for the segments `segment_name` (s,), `segment_start`,
    `segment_end`, `segment_anchor` and `segment_signal` ("" for none). Metres, seconds, the gripper frame of
    `graft.grasp.gripper`.

    Raises:
        InputError: An array is missing, unknown or wrong; the message has the file and the array.
    """
    return trajectory_of(read_npz(Path(path)), Path(path))


def trajectory_of(arrays: dict[str, Any], path: Path) -> Trajectory:
    """Return the trajectory that a .npz file's arrays tell; takes them out of `arrays`.

    Raises:
        InputError: See `load_trajectory`.
    """
    with malformed_is_input_error(path, "trajectory"):
        target = _poses(arrays, "target")
        if target is None:
            raise InputError(f"array 'T_world_target' is missing; found {_listed(arrays)}")
        trajectory = Trajectory(
            times=_needed(arrays, "times"),
            T_world_target=target,
            gripper=_needed(arrays, "gripper"),
            T_world_gripper=_poses(arrays, "gripper"),
            T_world_object={
                key.removeprefix(OBJECT_PREFIX): arrays.pop(key)
                for key in sorted(arrays)
                if key.startswith(OBJECT_PREFIX)
            },
            segments=_segments(arrays),
        )
        if arrays:
            raise InputError(f"array {sorted(arrays)[0]!r} is unknown")
    return trajectory


def _listed(arrays: dict[str, Any]) -> str:
    return ", ".join(sorted(arrays)[:8]) or "nothing"


def _needed(arrays: dict[str, Any], key: str) -> Any:
    if key not in arrays:
        raise InputError(f"array {key!r} is missing; found {_listed(arrays)}")
    return arrays.pop(key)


def _poses(arrays: dict[str, Any], what: str) -> Floats | None:
    """Return poses that are written as matrices, or as positions and quaternions."""
    if f"T_world_{what}" in arrays:
        poses: Floats = arrays.pop(f"T_world_{what}")
        return poses
    if f"{what}_position" not in arrays:
        return None
    position = arrays.pop(f"{what}_position")
    return poses_from_quaternions(what, position, _needed(arrays, f"{what}_quaternion"))


def _segments(arrays: dict[str, Any]) -> tuple[Segment, ...]:
    if not any(key in arrays for key in _SEGMENT_KEYS):
        return ()
    names, starts, ends = (_needed(arrays, key) for key in _SEGMENT_KEYS)
    anchors = arrays.pop("segment_anchor", [""] * len(names))
    signals = arrays.pop("segment_signal", [""] * len(names))
    return tuple(
        Segment(str(name), int(start), int(end), str(anchor) or None, str(signal) or None)
        for name, start, end, anchor, signal in zip(names, starts, ends, anchors, signals, strict=True)
    )

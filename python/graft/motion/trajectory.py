"""Paths of poses in time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation, Slerp

from graft.checks import Floats, checked_array, is_rotation
from graft.errors import InputError


def checked_pose(name: str, value: ArrayLike) -> Floats:
    """Return `value` (4, 4) as a read-only rigid motion, or raise `InputError` naming it."""
    pose: Floats = checked_array(name, value, (4, 4))
    if not is_rotation(pose[:3, :3]) or not np.allclose(pose[3], (0.0, 0.0, 0.0, 1.0)):
        raise InputError(f"{name}: expected a rotation and a translation with last row 0 0 0 1")
    return pose


@dataclass(frozen=True, eq=False)
class Motion:
    """How a gripper gets from one pose to another, or why it does not.

    Attributes:
        poses: (n, 4, 4) waypoints T_object_gripper, metres; between them the TCP moves straight and the gripper turns
            evenly about one axis. Empty where there is no motion.
        times: (n,) when the gripper is there, seconds from 0.
        reason: "" when found, else why not.
        iterations: Growths of the planner's trees; 0 where the direct motion is free.
        nodes: Poses in the trees.
        checks: Poses that were tested for collisions.
    """

    poses: Floats
    times: Floats
    reason: str = ""
    iterations: int = 0
    nodes: int = 0
    checks: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "poses", checked_array("poses", self.poses, (None, 4, 4)))
        object.__setattr__(self, "times", checked_array("times", self.times, (len(self.poses),)))

    @property
    def found(self) -> bool:
        """Whether there is a motion."""
        return not self.reason

    @property
    def duration(self) -> float:
        """Seconds from first to last pose; 0 where there is no motion."""
        return float(self.times[-1]) if len(self.times) else 0.0

    def sampled(self, period: float) -> Motion:
        """Return the motion with poses every `period` seconds, and at its end.

        Raises:
            InputError: `period` is not positive, or there is no motion.
        """
        if not (np.isfinite(period) and period > 0):
            raise InputError(f"period: expected seconds above 0, got {period}")
        if not self.found:
            raise InputError(f"motion: there is none to sample: {self.reason}")
        if self.duration == 0.0:
            return self
        times = np.append(np.arange(0.0, self.duration, period), self.duration)
        return replace(self, poses=self.at(times), times=times)

    def at(self, times: ArrayLike) -> Floats:
        """Return the poses (k, 4, 4) at `times` (k,) seconds; before its begin and after its end it stands still.

        Raises:
            InputError: There is no motion, or a time is not finite.
        """
        if not self.found:
            raise InputError(f"motion: there is none: {self.reason}")
        moments = np.clip(checked_array("times", times, (None,)), 0.0, self.duration)
        kept = np.append(True, np.diff(self.times) > 0)  # waypoints that coincide
        stamps, poses = self.times[kept], self.poses[kept]
        if len(poses) == 1:
            return np.repeat(poses, len(moments), axis=0)
        result = np.tile(np.eye(4), (len(moments), 1, 1))
        result[:, :3, :3] = Slerp(stamps, Rotation.from_matrix(poses[:, :3, :3]))(moments).as_matrix()
        for axis in range(3):
            result[:, axis, 3] = np.interp(moments, stamps, poses[:, axis, 3])
        return result


def no_motion(reason: str, iterations: int = 0, nodes: int = 0, checks: int = 0) -> Motion:
    """Return that there is no motion and why."""
    return Motion(np.empty((0, 4, 4)), np.empty(0), reason, iterations, nodes, checks)


def stamp(poses: Floats, linear_speed: float, angular_speed: float) -> Floats:
    """Return times (n,) at which waypoints (n, 4, 4) are passed when neither speed is exceeded, seconds from 0.

    The speed between waypoints is constant and jumps at them; a controller rounds the corners.
    """
    ways = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
    turns = np.swapaxes(poses[:-1, :3, :3], 1, 2) @ poses[1:, :3, :3]
    angles = Rotation.from_matrix(turns).magnitude() if len(turns) else np.empty(0)
    times: Floats = np.concatenate([[0.0], np.cumsum(np.maximum(ways / linear_speed, angles / angular_speed))])
    return times

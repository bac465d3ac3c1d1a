"""Trajectories of a gripper: what it was told, where it went, where the objects were, and the segments of the task.

Metres, seconds, 4x4 poses, the gripper frame of `graft.grasp.gripper` (origin TCP, z approach, y closing). A segment is
MimicGen's subtask: a stretch that is replayed relative to one object, and that ends when its signal rises.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from graft.checks import ROTATION_TOLERANCE, Floats, Ints, checked_array
from graft.errors import InputError

DEMONSTRATED = "object"
"""What the object of a `Demonstration` is called among the objects of its trajectory."""

OPEN, CLOSE = -1.0, 1.0
"""Gripper actions that open and close it, as robosuite has them; in between is a share of the way."""

QUATERNION_TOLERANCE = 1e-3
"""A quaternion's length may be off 1 by this, and is then normalised; files print three digits and more."""


def checked_poses(name: str, value: ArrayLike, length: int | None = None) -> Floats:
    """Return (t, 4, 4) rigid poses, read-only.

    Raises:
        InputError: Another shape or length, a number that is not finite, a pose that is no rotation and translation;
            the message has the first bad row.
    """
    poses: Floats = checked_array(name, value, (length, 4, 4))
    linear = poses[:, :3, :3]
    skewed = np.abs(linear.transpose(0, 2, 1) @ linear - np.eye(3)).max(axis=(1, 2), initial=0.0) > ROTATION_TOLERANCE
    mirrored = np.linalg.det(linear) <= 0
    bottom = (poses[:, 3] != (0.0, 0.0, 0.0, 1.0)).any(axis=1)
    bad = np.flatnonzero(skewed | mirrored | bottom)
    if len(bad):
        raise InputError(f"{name}: expected rotations and translations, row {bad[0]} is none")
    return poses


def poses_from_quaternions(name: str, positions: ArrayLike, quaternions: ArrayLike) -> Floats:
    """Return (t, 4, 4) poses of positions (t, 3) and quaternions (t, 4), wxyz.

    Raises:
        InputError: A quaternion's length is further from 1 than `QUATERNION_TOLERANCE`.
    """
    from scipy.spatial.transform import Rotation

    places: Floats = checked_array(f"{name} positions", positions, (None, 3))
    turns: Floats = checked_array(f"{name} quaternions", quaternions, (len(places), 4))
    lengths = np.linalg.norm(turns, axis=1)
    bad = np.flatnonzero(np.abs(lengths - 1) > QUATERNION_TOLERANCE)
    if len(bad):
        raise InputError(f"{name} quaternions: expected unit length, row {bad[0]} has {lengths[bad[0]]:.4g}")
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, :3, 3] = places
    if len(places):
        poses[:, :3, :3] = Rotation.from_quat(turns, scalar_first=True).as_matrix()
    return poses


@dataclass(frozen=True)
class Segment:
    """A stretch of a trajectory that is replayed relative to one object.

    Attributes:
        name: Unique within its trajectory.
        start: Index of its first step.
        end: Index after its last step.
        anchor: Name of the object that it is relative to; None for the world.
        signal: Name of the signal that rises in its last step; None where the end of the trajectory ends it.
    """

    name: str
    start: int
    end: int
    anchor: str | None = None
    signal: str | None = None

    def __post_init__(self) -> None:
        if not self.name:
            raise InputError("segment name: expected a name, got an empty string")
        if not 0 <= self.start < self.end:
            raise InputError(
                f"segment {self.name!r}: expected 0 <= start < end, got start {self.start}, end {self.end}"
            )

    def __len__(self) -> int:
        return self.end - self.start


def segments_from_signals(
    signals: Mapping[str, ArrayLike], length: int, *, anchors: Mapping[str, str | None] | None = None
) -> tuple[Segment, ...]:
    """Return the segments that term signals mark, in the order in which they rise.

    A segment ends with the first step in which its signal is on, as in MimicGen; what comes after the last signal is
    one more segment, called "end". Signals that never rise, or rise in the first step, end nothing. Of signals that
    rise in the same step the first by name counts.

    Args:
        signals: Name -> (t,) zeros, and ones from the step on in which the subtask is done.
        length: Number of steps t.
        anchors: Segment name (a signal's, or "end") -> object that it is relative to; None for the world.
    """
    anchors = anchors or {}
    ends: dict[int, str] = {}
    for name in sorted(signals):
        signal: Floats = checked_array(f"term signal {name!r}", np.asarray(signals[name], np.float64), (length,))
        on = np.flatnonzero(signal > 0.5)
        if len(on) and on[0] > 0:
            ends.setdefault(int(on[0]) + 1, name)
    found, start = [], 0
    for end, name in sorted(ends.items()):
        found.append(Segment(name, start, end, anchors.get(name), name))
        start = end
    if start < length:
        rest = "end"
        while rest in signals:
            rest += "_"
        found.append(Segment(rest, start, length, anchors.get(rest)))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """What a gripper was told at each of t steps, and what came of it.

    Attributes:
        times: (t,) seconds, increasing.
        T_world_target: (t, 4, 4) poses that the controller was told to reach, metres.
        gripper: (t,) actions in [-1, 1]: -1 opens, 1 closes.
        T_world_gripper: (t, 4, 4) poses that were reached; None where only the targets are known.
        T_world_object: Name -> (t, 4, 4) poses of the objects; a demonstration's own is called `DEMONSTRATED`.
        segments: They follow each other and cover all steps; one for everything by default.
    """

    times: Floats
    T_world_target: Floats
    gripper: Floats
    T_world_gripper: Floats | None = None
    T_world_object: Mapping[str, Floats] = field(default_factory=dict)
    segments: tuple[Segment, ...] = ()

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "times", checked_array("trajectory times", self.times, (None,)))
        n = len(self.times)
        if n == 0:
            raise InputError("trajectory: expected at least one step, got none")
        late = np.flatnonzero(np.diff(self.times) <= 0)
        if len(late):
            i = int(late[0])
            raise InputError(
                f"trajectory times: expected increasing, "
                f"got {self.times[i]:g} then {self.times[i + 1]:g} at step {i + 1}"
            )
        put(self, "T_world_target", checked_poses("T_world_target", self.T_world_target, n))
        put(self, "gripper", checked_array("trajectory gripper", self.gripper, (n,)))
        if np.abs(self.gripper).max() > 1:
            i = int(np.argmax(np.abs(self.gripper) > 1))
            raise InputError(f"trajectory gripper: expected actions in [-1, 1], got {self.gripper[i]:g} at step {i}")
        if self.T_world_gripper is not None:
            put(self, "T_world_gripper", checked_poses("T_world_gripper", self.T_world_gripper, n))
        objects = {
            name: checked_poses(f"T_world_object {name!r}", poses, n) for name, poses in self.T_world_object.items()
        }
        put(self, "T_world_object", objects)
        put(self, "segments", tuple(self.segments) or (Segment("all", 0, n),))
        self._check_segments()

    def _check_segments(self) -> None:
        expected = 0
        for segment in self.segments:
            where = f"segment {segment.name!r}"
            if segment.start != expected:
                raise InputError(f"{where}: expected it to start at step {expected}, it starts at {segment.start}")
            if segment.anchor is not None and segment.anchor not in self.T_world_object:
                known = ", ".join(self.T_world_object) or "none"
                raise InputError(f"{where}: no object called {segment.anchor!r}; the objects are {known}")
            expected = segment.end
        if expected != len(self):
            raise InputError(f"segments: expected them to cover {len(self)} steps, they end at {expected}")
        for what in ("name", "signal"):
            given = [getattr(s, what) for s in self.segments if getattr(s, what) is not None]
            if len(set(given)) != len(given):
                twice = next(name for name in given if given.count(name) > 1)
                raise InputError(f"segments: {what} {twice!r} is there twice")

    def __len__(self) -> int:
        return len(self.times)

    @property
    def duration(self) -> float:
        """Seconds from the first step to the last."""
        return float(self.times[-1] - self.times[0])

    @property
    def term_signals(self) -> dict[str, Ints]:
        """Signal -> (t,) 0 before the last step of its segment, 1 from there on, as MimicGen has them."""
        steps = np.arange(len(self))
        return {s.signal: (steps >= s.end - 1).astype(np.int64) for s in self.segments if s.signal is not None}

    def transformed(self, transform: ArrayLike) -> Trajectory:
        """Return the trajectory, its objects too, in another world frame.

        Args:
            transform: (4, 4) T_new_world, a rotation and a translation in metres.
        """
        move = checked_poses("transform", checked_array("transform", transform, (4, 4))[None])[0]
        return replace(
            self,
            T_world_target=move @ self.T_world_target,
            T_world_gripper=None if self.T_world_gripper is None else move @ self.T_world_gripper,
            T_world_object={name: move @ poses for name, poses in self.T_world_object.items()},
        )

    def subset(self, start: int, end: int) -> Trajectory:
        """Return steps `start` to `end` (exclusive), with the segments, or what is left of them, that lie there."""
        if not 0 <= start < end <= len(self):
            raise InputError(f"subset: expected 0 <= start < end <= {len(self)}, got start {start}, end {end}")
        segments = tuple(
            replace(
                s,
                start=max(s.start, start) - start,
                end=min(s.end, end) - start,
                signal=s.signal if s.end <= end else None,  # its end is cut off, and with it what ends it
            )
            for s in self.segments
            if s.start < end and s.end > start
        )
        steps = slice(start, end)
        return replace(
            self,
            times=self.times[steps],
            T_world_target=self.T_world_target[steps],
            gripper=self.gripper[steps],
            T_world_gripper=None if self.T_world_gripper is None else self.T_world_gripper[steps],
            T_world_object={name: poses[steps] for name, poses in self.T_world_object.items()},
            segments=segments,
        )

    def resampled(self, times: ArrayLike) -> Trajectory:
        """Return the trajectory at other times.

        Positions are interpolated linearly, orientations along the shortest turn. A gripper action is a command: it
        holds until the next. A segment keeps the steps up to the time of its last one.

        Args:
            times: (s,) seconds, increasing, from the first time to the last at most.

        Raises:
            InputError: A time outside the trajectory, or a segment that no time falls into.
        """
        at: Floats = checked_array("resampled times", times, (None,))
        if len(at) == 0 or at[0] < self.times[0] or at[-1] > self.times[-1]:
            got = "none" if len(at) == 0 else f"{at[0]:g} to {at[-1]:g}"
            raise InputError(f"resampled times: expected {self.times[0]:g} to {self.times[-1]:g} s, got {got}")
        ends = [int(np.searchsorted(at, self.times[s.end - 1], side="right")) for s in self.segments]
        segments = []
        for segment, start, end in zip(self.segments, [0, *ends], ends, strict=False):
            if start >= end:
                raise InputError(f"resampled times: none falls into segment {segment.name!r}")
            segments.append(replace(segment, start=start, end=end))
        held = np.searchsorted(self.times, at, side="right") - 1
        return replace(
            self,
            times=at,
            T_world_target=_interpolated(self.times, self.T_world_target, at),
            gripper=self.gripper[held],
            T_world_gripper=(
                None if self.T_world_gripper is None else _interpolated(self.times, self.T_world_gripper, at)
            ),
            T_world_object={name: _interpolated(self.times, p, at) for name, p in self.T_world_object.items()},
            segments=tuple(segments),
        )


def _interpolated(times: Floats, poses: Floats, at: Floats) -> Floats:
    from scipy.spatial.transform import Rotation, Slerp

    if len(times) == 1:
        return np.repeat(poses, len(at), axis=0)
    result = np.tile(np.eye(4), (len(at), 1, 1))
    result[:, :3, :3] = Slerp(times, Rotation.from_matrix(poses[:, :3, :3]))(at).as_matrix()
    result[:, :3, 3] = np.stack([np.interp(at, times, poses[:, i, 3]) for i in range(3)], axis=1)
    return result

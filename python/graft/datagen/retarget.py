"""MimicGen's formula: a source's motion relative to a frame, replayed relative to the same frame on another object.

T_new(t) = T_frame_new inv(T_frame_source at the segment's start) T_target_source(t)

(Mandlekar et al. 2023, section IV), with controller targets, not reached poses. MimicGen's frame is the object's body
frame. Graft's is the grasp: the gripper's pose in which the source was, and the new object will be, taken. Once the
object is held what matters is how it moves, and up is up however it was taken: from there on the source's displacement
is replayed about the upright frame at the grasp.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from graft.checks import Floats
from graft.errors import InputError
from graft.grasp.conventions import rigid_inverse
from graft.objects import Demonstration, PartObject
from graft.trajectory import CLOSE, DEMONSTRATED, OPEN, Segment, Trajectory

HOLD = "hold"
"""Segment at the end of scripted demonstrations that is not replayed: every attempt holds for its own time."""

STRAIGHT = 0.08
"""Metres from the grasp at which an interaction begins where the source's segments do not say; see
`graft.motion.approach.STRAIGHT`."""

CLOSING = (OPEN + CLOSE) / 2
"""An action above this closes the gripper."""

SPOUT = "spout"
"""What the part is called that an object pours from."""

LEVEL = 1e-3
"""Metres: a grasp straight above or below the centre of mass has no heading."""


def retargeted(targets: Floats, T_frame_source: Floats, T_frame_new: Floats) -> Floats:
    """Return (t, 4, 4) targets moved from a source's frame (4, 4) to the new one (4, 4)."""
    moved: Floats = T_frame_new @ rigid_inverse(T_frame_source) @ targets
    return moved


def carried(targets: Floats, T_upright_source: Floats, T_upright_new: Floats, T_start_new: Floats) -> Floats:
    """Return (t, 4, 4) targets that displace what is held as the source did, beginning at `T_start_new` (4, 4).

    With C = T_upright_new inv(T_upright_source), the displacement D(t) = T_source(t) inv(T_source(0)) becomes
    C D inv(C).
    """
    change = T_upright_new @ rigid_inverse(T_upright_source)
    moved: Floats = change @ targets @ rigid_inverse(targets[0]) @ rigid_inverse(change) @ T_start_new
    return moved


def spout_of(obj: PartObject, center: Floats) -> Floats | None:
    """Return where an object pours, from `center` (3,) to the middle of its spout's box (3,); None without a spout."""
    for part in obj.parts:
        if SPOUT in (part.name, part.label):
            middle: Floats = part.vertices.min(axis=0) / 2 + part.vertices.max(axis=0) / 2 - center
            return middle
    return None


def upright_frame(place: Floats, center: Floats, front: Floats | None = None) -> Floats:
    """Return the frame (4, 4) at `place` (3,) with z up and x along `front` (3,); all in world axes.

    Without a front, x points towards `center` (3,): what is taken by a handle on a side faces the other. World x where
    that is straight above or below.
    """
    heading = center[:2] - place[:2] if front is None else front[:2]
    length = float(np.linalg.norm(heading))
    cos, sin = heading / length if length > LEVEL else (1.0, 0.0)
    frame = np.eye(4)
    frame[:2, :2] = (cos, -sin), (sin, cos)
    frame[:3, 3] = place
    return frame


@dataclass(frozen=True, eq=False)
class Source:
    """A demonstration as it is replayed.

    Attributes:
        demonstration: With a trajectory.
        trajectory: Without what is not replayed, and with the reach a segment of its own.
        reach: Index of the segment in which the gripper closes; those before it are the reach.
        closing: Step in which the gripper is first told to close.
        grasp: (4, 4) T_object_gripper in which the object was taken, metres.
        center: (3,) of the object's box; object frame, metres.
        spout: (3,) from there to its spout; None without one.
    """

    demonstration: Demonstration
    trajectory: Trajectory
    reach: int
    closing: int
    grasp: Floats
    center: Floats
    spout: Floats | None = None

    @property
    def name(self) -> str:
        """Of the demonstration."""
        return self.demonstration.name

    def targets(self, index: int) -> Floats:
        """(t, 4, 4) of a segment."""
        segment = self.trajectory.segments[index]
        return self.trajectory.T_world_target[segment.start : segment.end]

    def object_pose(self, index: int) -> Floats:
        """(4, 4) of the object at the start of a segment."""
        pose: Floats = self.trajectory.T_world_object[DEMONSTRATED][self.trajectory.segments[index].start]
        return pose

    def upright(self, index: int) -> Floats:
        """(4, 4) upright frame at the grasp at the start of a segment."""
        pose = self.object_pose(index)
        front = None if self.spout is None else pose[:3, :3] @ self.spout
        return upright_frame((pose @ self.grasp)[:3, 3], pose[:3, :3] @ self.center + pose[:3, 3], front)


def source_of(demonstration: Demonstration) -> Source:
    """Return a demonstration ready to be replayed.

    Raises:
        InputError: It has no trajectory, its gripper never closes, or nothing is left to replay.
    """
    where = f"demonstration {demonstration.name!r}"
    given = demonstration.trajectory
    if given is None:
        raise InputError(f"{where}: it has no trajectory to replay; graft demonstrate makes such, files bring them")
    if DEMONSTRATED not in given.T_world_object:
        raise InputError(f"{where}: its trajectory has no poses of {DEMONSTRATED!r}")
    kept = given.segments[:-1] if given.segments[-1].name == HOLD else given.segments
    elsewhere = next((i for i, s in enumerate(kept) if s.anchor not in (None, DEMONSTRATED)), len(kept))
    kept = kept[:elsewhere]
    if not kept:
        raise InputError(f"{where}: its trajectory has no segment of the object that is taken, beside {HOLD!r}")
    trajectory = given.subset(0, kept[-1].end)
    closing = np.flatnonzero(trajectory.gripper > CLOSING)
    opening = np.flatnonzero(trajectory.gripper <= CLOSING)
    after = closing[closing > opening[0]] if len(opening) else closing[:0]
    if len(after) == 0:
        raise InputError(f"{where}: its gripper never closes")
    step = int(after[0])
    grasp = demonstration.grasp
    if grasp is None:
        reached = trajectory.T_world_target if trajectory.T_world_gripper is None else trajectory.T_world_gripper
        grasp = rigid_inverse(trajectory.T_world_object[DEMONSTRATED][step]) @ reached[step]
    trajectory = _with_reach(trajectory, step)
    index = next(i for i, s in enumerate(trajectory.segments) if s.start <= step < s.end)
    obj = demonstration.object
    middle, scale = obj.bounds.mean(axis=0), obj.scale_to_metres or 1.0
    spout = spout_of(obj, middle)
    return Source(
        demonstration, trajectory, index, step, grasp, scale * middle, None if spout is None else scale * spout,
    )  # fmt: skip


def _with_reach(trajectory: Trajectory, closing: int) -> Trajectory:
    """Cut the first segment where the hand comes within `STRAIGHT` of the grasp, if the gripper closes in it."""
    first = trajectory.segments[0]
    if closing >= first.end:
        return trajectory
    places = trajectory.T_world_target[:closing, :3, 3]
    away = np.flatnonzero(
        np.linalg.norm(places - trajectory.T_world_target[closing, :3, 3], axis=1) >= STRAIGHT - LEVEL
    )
    cut = int(away[-1]) if len(away) else 0
    if cut == 0:
        return trajectory
    name = "reach" if first.name != "reach" else "approach"
    pieces = (Segment(name, 0, cut, first.anchor), replace(first, start=cut))
    return replace(trajectory, segments=(*pieces, *trajectory.segments[1:]))

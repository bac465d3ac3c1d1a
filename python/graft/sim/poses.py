"""How an object can stand: candidates from its hull, settled in physics."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from graft.objects import Floats
from graft.sim.config import SimulationConfig
from graft.sim.engine import load_mujoco
from graft.sim.scene import Body, scene_spec

SAME_PLANE = 1e-5
"""Faces of the hull whose normals and offsets (metres) differ by less belong to one flat face."""

DROP = 0.0005
"""Metres above the table at which a candidate is let go."""

SETTLE_SECONDS = 1.5
"""Simulated seconds that a candidate is given to come to rest."""

CHECK_SECONDS = 1.0
"""Simulated seconds over which it must then stay where it is."""

TIPPED = 20.0
"""Degrees: a candidate that turned by more while it settled fell into another pose."""

REST_DISTANCE, REST_ANGLE = 0.001, 1.0
"""Metres and degrees that a resting object may move over `CHECK_SECONDS`."""


@dataclass(frozen=True, eq=False)
class RestingPose:
    """A pose in which an object stands on the table z = 0.

    Attributes:
        T_world_object: (4, 4) metres; the centre of mass is above the world's origin.
        upright: Whether the object's up axis (z where it has none) points up.
        stable: Whether it came to rest near the candidate and stayed.
        barrier: Metres by which the centre of mass must be raised to topple it over its nearest edge.
        height: Of the centre of mass, metres.
        settled_angle: Degrees that it turned while it settled.
        drift_distance: Metres that it moved over the second after that.
        drift_angle: Degrees, likewise.
    """

    T_world_object: Floats
    upright: bool
    stable: bool
    barrier: float
    height: float
    settled_angle: float
    drift_distance: float
    drift_angle: float


def find_resting_poses(body: Body, up: Floats, config: SimulationConfig, count: int) -> tuple[RestingPose, ...]:
    """Return up to `count` poses: upright if it is stable, then the others, the hardest to topple first.

    Args:
        body: The object's physics.
        up: (3,) direction against gravity in which it is drawn, object frame.
        config: The settings.
        count: At most so many.

    Returns:
        Stable poses; when there is none, the upright candidate, not stable.
    """
    mj = load_mujoco()
    # Hull and table only: what the hand would touch has no say here.
    model = scene_spec(replace(body, pieces=()), config, None).compile()
    data = mj.MjData(model)
    found = [_settled(mj, model, data, body, up, upright=True)]
    first = found[0]
    found = found if first.stable else []
    for normal in _faces_under_the_center(body):
        if len(found) >= count:
            break
        pose = _settled(mj, model, data, body, -normal, upright=False)
        if pose.stable and not any(_same(pose, other) for other in found):
            found.append(pose)
    return tuple(found) if found else (first,)


def rotation_angle(rotation: Floats) -> float:
    """Return the angle of a rotation (3, 3), degrees; exact for small angles, too."""
    skew = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    return float(np.degrees(np.arctan2(np.linalg.norm(skew), np.trace(rotation) - 1.0)))


def turning(a: Floats, b: Floats) -> Floats:
    """Return the smallest rotation (3, 3) that carries unit vector a (3,) to b."""
    cross, dot = np.cross(a, b), float(a @ b)
    if dot < -1 + 1e-9:
        axis = np.cross(a, np.eye(3)[int(np.abs(a).argmin())])
        axis /= np.linalg.norm(axis)
        half_turn: Floats = 2 * np.outer(axis, axis) - np.eye(3)
        return half_turn
    k = np.array([[0, -cross[2], cross[1]], [cross[2], 0, -cross[0]], [-cross[1], cross[0], 0]])
    rotation: Floats = np.eye(3) + k + k @ k / (1 + dot)
    return rotation


def _faces_under_the_center(body: Body) -> list[Floats]:
    """Return outward normals of the hull's flat faces with the centre of mass above them, best barrier first."""
    hull = ConvexHull(body.hull)
    normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
    height = -(normals @ body.center_of_mass + offsets)
    foot = body.center_of_mass + height[:, None] * normals
    corners = body.hull[hull.simplices]
    inside = np.ones(len(corners), bool)
    for i in range(3):
        edge, third = corners[:, (i + 1) % 3] - corners[:, i], corners[:, (i + 2) % 3] - corners[:, i]
        side = np.cross(normals, edge)
        toward = np.einsum("ij,ij->i", side, third)
        inside &= np.einsum("ij,ij->i", side, foot - corners[:, i]) * np.sign(toward) >= -1e-12
    ranked = []
    for face in np.flatnonzero(inside):
        barrier = _barrier(body, normals[face], float(height[face]))
        if barrier is not None and not any(np.abs(normals[face] - n).max() < SAME_PLANE for _, _, n in ranked):
            ranked.append((-barrier, int(face), normals[face]))
    ranked.sort(key=lambda entry: entry[:2])
    return [normal for _, _, normal in ranked]


def _barrier(body: Body, normal: Floats, height: float) -> float | None:
    """Return how far the centre of mass must rise to go over the nearest edge of its foot; None without a foot."""
    levels = body.hull @ normal
    foot = body.hull[levels > levels.max() - SAME_PLANE]
    frame = turning(normal, np.array([0.0, 0.0, 1.0]))
    flat = (foot @ frame.T)[:, :2]
    center = (frame @ body.center_of_mass)[:2]
    if len(flat) < 3 or np.linalg.matrix_rank(flat - flat[0], tol=1e-6) < 2:
        return None
    edges = ConvexHull(flat).equations
    margin = float(-(edges[:, :2] @ center + edges[:, 2]).max())
    return float(np.hypot(height, margin) - height) if margin > 0 else None


def _settled(mj: Any, model: Any, data: Any, body: Body, up: Floats, *, upright: bool) -> RestingPose:
    """Let the object go with `up` (3,) pointing up and see where it comes to rest."""
    rotation = turning(up, np.array([0.0, 0.0, 1.0]))
    lowest = float((body.hull @ rotation.T)[:, 2].min())
    start = np.eye(4)
    start[:3, :3] = rotation
    start[:2, 3] = -(rotation @ body.center_of_mass)[:2]
    start[2, 3] = DROP - lowest
    mj.mj_resetData(model, data)
    set_pose(mj, data, start)
    mj.mj_step(model, data, round(SETTLE_SECONDS / model.opt.timestep))
    rest = get_pose(mj, data)
    data.qvel[:] = 0
    mj.mj_step(model, data, round(CHECK_SECONDS / model.opt.timestep))
    later = get_pose(mj, data)
    settled_angle = rotation_angle(rest[:3, :3] @ rotation.T)
    distance, angle = displacement(rest, later, body.center_of_mass)
    broken = any(warning.number for warning in data.warning) or not np.isfinite(data.qpos).all()
    stable = not broken and settled_angle < TIPPED and distance < REST_DISTANCE and angle < REST_ANGLE
    pose = later if not broken else start
    center = pose[:3, :3] @ body.center_of_mass + pose[:3, 3]
    pose[:2, 3] -= center[:2]
    barrier = _standing_barrier(body, pose)
    return RestingPose(pose, upright, stable, barrier, float(center[2]), settled_angle, distance, angle)


NEAR_TABLE = 0.0005
"""Corners of the hull this close to the table, metres, count as feet."""


def _standing_barrier(body: Body, pose: Floats) -> float:
    """Return the barrier of a pose from the feet that it stands on; 0 when they do not enclose the centre."""
    world = body.hull @ pose[:3, :3].T + pose[:3, 3]
    feet = world[world[:, 2] < world[:, 2].min() + NEAR_TABLE][:, :2]
    center = pose[:3, :3] @ body.center_of_mass + pose[:3, 3]
    if len(feet) < 3 or np.linalg.matrix_rank(feet - feet[0], tol=1e-6) < 2:
        return 0.0
    edges = ConvexHull(feet).equations
    margin = max(0.0, float(-(edges[:, :2] @ center[:2] + edges[:, 2]).max()))
    return float(np.hypot(center[2], margin) - center[2])


def _same(a: RestingPose, b: RestingPose) -> bool:
    """Whether two poses differ only by a turn about the vertical."""
    return bool((a.T_world_object[2, :3] @ b.T_world_object[2, :3]) > np.cos(np.radians(REST_ANGLE * 3)))


def displacement(before: Floats, after: Floats, point: Floats) -> tuple[float, float]:
    """Return how far `point` (3,) of a body moved between two poses (4, 4), metres, and by how many degrees it turned."""
    moved = (after[:3, :3] - before[:3, :3]) @ point + after[:3, 3] - before[:3, 3]
    return float(np.linalg.norm(moved)), rotation_angle(after[:3, :3] @ before[:3, :3].T)


def set_pose(mj: Any, data: Any, pose: Floats, start: int = 0) -> None:
    """Write a pose (4, 4) to the free joint whose position begins at `start`."""
    data.qpos[start : start + 3] = pose[:3, 3]
    mj.mju_mat2Quat(data.qpos[start + 3 : start + 7], np.ascontiguousarray(pose[:3, :3]).ravel())


def get_pose(mj: Any, data: Any, start: int = 0) -> Floats:
    """Return the pose (4, 4) of the free joint whose position begins at `start`."""
    pose = np.eye(4)
    rotation = np.empty(9)
    mj.mju_quat2Mat(rotation, np.ascontiguousarray(data.qpos[start + 3 : start + 7]))
    pose[:3, :3] = rotation.reshape(3, 3)
    pose[:3, 3] = data.qpos[start : start + 3]
    return pose

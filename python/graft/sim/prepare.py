"""An object made ready for physics: in metres, in pieces, standing. Done once for many trials."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from graft.errors import InputError
from graft.grasp import Support, in_metres
from graft.objects import Floats, PartObject
from graft.sim.config import SimulationConfig
from graft.sim.decompose import DecompositionConfig
from graft.sim.pieces import FLAT, collision_pieces, hull_corners, mass_properties
from graft.sim.poses import RestingPose, find_resting_poses
from graft.sim.scene import Body

XY_RANGE = 0.1
"""Random poses lie within this of the world's origin along x and y, metres."""


@dataclass(frozen=True, eq=False)
class PreparedObject:
    """An object on the table z = 0, before the hand comes. Plans are made on `object` above `support`.

    Attributes:
        object: In metres, in its own frame.
        body: Its physics.
        pose: How it stands.
    """

    object: PartObject
    body: Body
    pose: RestingPose

    @property
    def T_world_object(self) -> Floats:
        """(4, 4) where it stands, metres."""
        return self.pose.T_world_object

    @property
    def support(self) -> Support:
        """The table in the object's frame."""
        pose = self.pose.T_world_object
        return Support(pose[2, :3], -float(pose[2, 3]))


def prepare(
    obj: PartObject,
    config: SimulationConfig | None = None,
    *,
    decomposition: DecompositionConfig | None = None,
    cache: Path | None = None,
) -> PreparedObject:
    """Return the object standing as it is drawn if that is stable, else in the pose that is hardest to topple.

    Args:
        obj: In any unit.
        config: Settings of the physics.
        decomposition: How concave parts are cut into convex pieces.
        cache: Folder of decompositions; the user's cache folder when None.

    Returns:
        The object; `pose.stable` is False when no pose held, and its trials then end as UNSTABLE.

    Raises:
        InputError: It has no volume, or its size is not that of something to grasp.
        MissingExtraError: mujoco is not installed, or coacd is needed and is not.
    """
    return resting_poses(obj, config, count=1, decomposition=decomposition, cache=cache)[0]


def resting_poses(
    obj: PartObject,
    config: SimulationConfig | None = None,
    *,
    count: int = 8,
    decomposition: DecompositionConfig | None = None,
    cache: Path | None = None,
) -> tuple[PreparedObject, ...]:
    """Return the object in up to `count` stable poses, the default of `prepare` first, then by what topples them last.

    Arguments and errors are those of `prepare`.
    """
    if count < 1:
        raise InputError(f"count: expected at least 1, got {count}")
    metric = in_metres(obj)
    body = body_of(metric, decomposition, cache=cache)
    up = np.array([0.0, 0.0, 1.0]) if metric.up is None else metric.up
    poses = find_resting_poses(body, up, config or SimulationConfig(), count)
    return tuple(PreparedObject(metric, body, pose) for pose in poses)


def body_of(metric: PartObject, decomposition: DecompositionConfig | None = None, *, cache: Path | None = None) -> Body:
    """Return the physics of an object in metres.

    Raises:
        InputError: It has no volume.
    """
    pieces = collision_pieces(metric, decomposition, cache=cache)
    hull = hull_corners(np.vstack([part.vertices for part in metric.parts])) if pieces else None
    volume, center, inertia = mass_properties(metric, pieces) if pieces else (0.0, np.zeros(3), np.zeros((3, 3)))
    if hull is None or volume <= FLAT:
        raise InputError(f"object {metric.name!r}: it has no volume, physics needs a solid")
    return Body(pieces, hull, center, _realisable(inertia))


def _realisable(inertia: Floats) -> Floats:
    """Return a symmetric inertia whose principal moments are positive and obey the triangle inequality.

    Thin or slightly overlapping parts can miss it by rounding; MuJoCo refuses such a body.
    """
    moments, axes = np.linalg.eigh((inertia + inertia.T) / 2)
    spread = np.maximum(moments.sum() / 2 - moments, 1e-4 * moments.sum())
    mended: Floats = axes @ np.diag(spread.sum() - spread) @ axes.T
    return mended


def random_poses(prepared: PreparedObject, count: int, seed: int) -> Floats:
    """Return (count, 4, 4) T_world_object: the resting pose turned about the vertical and moved over the table.

    The same seed gives the same poses, and the first of a longer list are those of a shorter one.
    """
    if count < 0 or seed < 0:
        raise InputError(f"random poses: expected a count and a seed of at least 0, got {count} and {seed}")
    draws = np.random.default_rng(seed).random((count, 3))
    poses = np.tile(np.eye(4), (count, 1, 1))
    cos, sin = np.cos(2 * np.pi * draws[:, 0]), np.sin(2 * np.pi * draws[:, 0])
    poses[:, 0, 0], poses[:, 0, 1], poses[:, 1, 0], poses[:, 1, 1] = cos, -sin, sin, cos
    poses[:, :2, 3] = XY_RANGE * (2 * draws[:, 1:] - 1)
    placed: Floats = poses @ prepared.T_world_object
    return placed

"""Which grasps of somebody else are for what was asked: near the contact, on the part, clear of support and object."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from graft.checks import Floats, Ints
from graft.graph import build_graph
from graft.grasp.collision import gripper_collisions
from graft.grasp.grasps import GraspSet
from graft.grasp.gripper import Gripper
from graft.grasp.metric import Support
from graft.objects import Contact, PartObject

NEAR = 0.02
"""Metres from the contact within which a grasp still takes the object there: about the size of a pad."""

CLEARANCE = 0.005
"""Metres that each pad stays away from what it will close on, as the gripper arrives."""


def selected(
    grasps: GraspSet,
    obj: PartObject,
    contact: Contact | None,
    *,
    part: int | str | None,
    support: Support | None,
    k: int,
    radius: float = NEAR,
    check_collisions: bool = True,
) -> GraspSet:
    """Return the k best grasps that are for what was asked, without near repeats; `rejected` counts the others.

    Args:
        grasps: Object frame, metres.
        obj: In metres.
        contact: Grasps farther than `radius` from it are left out; None for anywhere.
        part: Grasps whose TCP is nearer to another part are left out; None for any.
        support: Grasps in which the open gripper goes below it are left out.
        k: How many at most.
        radius: Metres.
        check_collisions: Whether grasps in which the gripper, open by `CLEARANCE` on either side, touches the object
            are left out.
    """
    rejected = dict(grasps.rejected)
    if contact is not None:
        grasps = replace(grasps, distances=distances_to(grasps, contact.point))

    def keep(wanted: NDArray[np.bool_], reason: str) -> None:
        nonlocal grasps
        if not wanted.all():
            rejected[reason] = rejected.get(reason, 0) + int((~wanted).sum())
            grasps = grasps[wanted]

    keep(grasps.widths <= grasps.gripper.stroke, "wider than the stroke")
    if contact is not None:
        keep(grasps.distances <= radius, "far from the contact")
    if part is not None and len(grasps):
        keep(_nearest_part(obj, grasps.poses[:, :3, 3]) == obj.part_index(part), "on another part")
    if support is not None and len(grasps):
        keep(_lowest(grasps, grasps.gripper, support) >= 0.0, "below the support")
    if check_collisions and len(grasps):
        opening = np.minimum(grasps.widths + 2.0 * CLEARANCE, grasps.gripper.stroke)
        keep(~gripper_collisions(obj, grasps.gripper, grasps.poses, opening), "the gripper hits the object")
    kept = grasps.nms()
    if len(kept) < len(grasps):
        rejected["like a better one"] = len(grasps) - len(kept)
    return replace(kept[:k], rejected=rejected)


def distances_to(grasps: GraspSet, point: Floats) -> Floats:
    """Return (n,) metres from a point (3,) to the box between the pads of each grasp."""
    pad = grasps.gripper.pad
    seen = np.einsum("nji,nj->ni", grasps.poses[:, :3, :3], point - grasps.poses[:, :3, 3])
    seen -= [pad.center[0], 0.0, pad.center[2]]
    half = np.tile(pad.half_extents, (len(grasps), 1))
    half[:, 1] = grasps.widths / 2.0
    distances: Floats = np.linalg.norm(np.maximum(np.abs(seen) - half, 0.0), axis=1)
    return distances


def _nearest_part(obj: PartObject, points: Floats) -> Ints:
    """Return (n,) the parts whose surface samples come closest."""
    samples = build_graph(obj, descriptor=None).points
    away = np.stack([cKDTree(cloud).query(points)[0] for cloud in samples])
    nearest: Ints = np.argmin(away, axis=0)
    return nearest


def _lowest(grasps: GraspSet, gripper: Gripper, support: Support) -> Floats:
    """Return (n,) how far the lowest corner of the open gripper lies above the support, metres."""
    corners = np.concatenate([box.corners for box in gripper.boxes(gripper.stroke)])
    placed = corners @ grasps.poses[:, :3, :3].transpose(0, 2, 1) + grasps.poses[:, None, :3, 3]
    lowest: Floats = support.height(placed.reshape(-1, 3)).reshape(len(grasps), -1).min(axis=1)
    return lowest

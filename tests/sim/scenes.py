"""Objects and grasps whose outcome is plain."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from graft.grasp import PANDA_HAND, Grasp
from graft.objects import Part, PartObject

DOWN, ALONG_X, ALONG_Y = (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


def mesh_object(name: str, *meshes: trimesh.Trimesh) -> PartObject:
    parts = tuple(Part(f"part_{i}", mesh.vertices, mesh.faces) for i, mesh in enumerate(meshes))
    return PartObject(name, parts, scale_to_metres=1.0)


def box(x: float, y: float, z: float) -> PartObject:
    mesh = trimesh.creation.box((x, y, z))
    mesh.apply_translation((0, 0, z / 2))
    return mesh_object("box", mesh)


def grasp(place: ArrayLike, approach: ArrayLike = DOWN, closing: ArrayLike = ALONG_Y) -> Grasp:
    z, y = np.asarray(approach, float), np.asarray(closing, float)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([np.cross(y, z), y, z], axis=1)
    pose[:3, 3] = place
    return Grasp(pose, 0.05, 1.0, np.zeros((2, 3)), 0.0, PANDA_HAND)


def tube(outer: float, inner: float, height: float) -> PartObject:
    """Return an upright pipe: closed, concave, without sweeps."""
    mesh = trimesh.creation.annulus(r_min=inner, r_max=outer, height=height)
    mesh.apply_translation((0, 0, height / 2))
    return mesh_object("pipe", mesh)

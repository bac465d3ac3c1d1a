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


def channel(wide: float = 0.1, tall: float = 0.08, wall: float = 0.02, deep: float = 0.05) -> PartObject:
    """Return a U of walls, open upwards: closed, concave, without sweeps."""
    w, h, t = wide / 2, tall, wall
    outline = [(-w, 0), (w, 0), (w, h), (w - t, h), (w - t, t), (t - w, t), (t - w, h), (-w, h)]
    front = np.array([(x, -deep / 2, z) for x, z in outline])
    cap = np.array([(0, 5, 7), (5, 6, 7), (0, 1, 4), (0, 4, 5), (1, 2, 4), (2, 3, 4)])
    i, j = np.arange(8), (np.arange(8) + 1) % 8
    sides = np.vstack([np.stack([i, i + 8, j], axis=1), np.stack([j, i + 8, j + 8], axis=1)])
    mesh = trimesh.Trimesh(
        np.vstack([front, front + np.array((0, deep, 0))]), np.vstack([cap, cap[:, ::-1] + 8, sides])
    )
    return mesh_object("channel", mesh)

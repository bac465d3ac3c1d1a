"""Shapes as the meshes that pages and models are written from."""

from __future__ import annotations

import numpy as np
import trimesh
from trimesh.visual.material import PBRMaterial

from graft.objects import Floats
from graft.viz.shapes import Shape

CREASE = np.radians(40.0)
"""Faces that bend by more have a sharp edge between them."""


def surface(shape: Shape, opacity: float = 1.0) -> trimesh.Trimesh | trimesh.PointCloud:
    """Return a shape as a mesh with its colour, vertices doubled along creases; clouds stay clouds."""
    if not len(shape.faces):
        return trimesh.PointCloud(shape.vertices, colors=np.tile((*shape.color, 255), (len(shape.vertices), 1)))
    mesh = trimesh.Trimesh(shape.vertices, shape.faces, process=False)
    if len(mesh.faces) > 1 and mesh.area > 0:
        mesh = trimesh.graph.smooth_shade(mesh, angle=CREASE)
    material = PBRMaterial(
        baseColorFactor=(*linear(shape.color), opacity),
        alphaMode="OPAQUE" if opacity >= 1.0 else "BLEND",
        metallicFactor=0.0,
        roughnessFactor=0.65,
        doubleSided=True,
    )
    # Only normals that are given are exported; without them viewers show facets.
    return trimesh.Trimesh(
        mesh.vertices,
        mesh.faces,
        vertex_normals=mesh.vertex_normals,
        visual=trimesh.visual.TextureVisuals(material=material),
        process=False,
    )


def linear(color: tuple[int, int, int]) -> tuple[float, ...]:
    """Return an sRGB colour in linear light, 0 to 1, as glTF's factors are (IEC 61966-2-1)."""
    srgb = np.array(color) / 255.0
    light = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    return tuple(float(x) for x in light)


def quaternion(pose: Floats) -> Floats:
    """Return (4,) wxyz of a rigid motion (4, 4)."""
    wxyz: Floats = trimesh.transformations.quaternion_from_matrix(pose)
    return wxyz

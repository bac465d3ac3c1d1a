"""Objects whose grasps can be told beforehand. Metres."""

from __future__ import annotations

import numpy as np
import trimesh

from graft.grasp import Support
from graft.objects import Contact, Part, PartObject

UP = (0.0, 0.0, 1.0)


def named(name: str, *meshes: trimesh.Trimesh) -> PartObject:
    """Make an object of meshes, one part each."""
    parts = tuple(Part(f"{name}_{i}", mesh.vertices, mesh.faces) for i, mesh in enumerate(meshes))
    return PartObject(name, parts, up=np.array(UP), scale_to_metres=1.0)


def block(x: float = 0.04, y: float = 0.12, z: float = 0.10) -> PartObject:
    """Make a block about the origin, x to be grasped across."""
    return named("block", trimesh.creation.box((x, y, z)).subdivide().subdivide().subdivide())


def ball(radius: float = 0.03) -> PartObject:
    """Make a ball about the origin."""
    return named("ball", trimesh.creation.icosphere(subdivisions=4, radius=radius))


def cup(radius: float = 0.06, height: float = 0.1) -> PartObject:
    """Make a cup of one sheet, open above, wider than a Panda's stroke."""
    tube = trimesh.creation.cylinder(radius=radius, height=height, sections=96)
    keep = tube.triangles_center[:, 2] < height / 2 - 1e-6
    tube.update_faces(keep)
    sheet = tube.subdivide().subdivide()
    return named("cup", sheet)


def ring() -> PartObject:
    """Make an upright ring, 5 cm to the middle of a tube of 8 mm: a handle and its loop."""
    torus = trimesh.creation.torus(0.05, 0.008, major_sections=96, minor_sections=32)
    torus.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0)))
    return named("ring", torus)


def below(obj: PartObject) -> Support:
    """Return the plane that an object stands on."""
    return Support(np.array(UP), float(min(part.vertices[:, 2].min() for part in obj.parts)))


def contact(point: tuple[float, float, float], normal: tuple[float, float, float], part: int = 0) -> Contact:
    """Make a contact without a demonstrated approach."""
    return Contact(np.array(point), np.array(normal), part)

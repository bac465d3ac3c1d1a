"""`save_glb`, `save_grasp_glb`: scenes as GLB files with named nodes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import trimesh

from graft.io.atomic import write_whole
from graft.objects import Contact, Floats, PartObject
from graft.viz.files import check_output
from graft.viz.grippers import BEST, BOX_OPACITY
from graft.viz.layout import Cell, Placed, lay_out, place_grasps
from graft.viz.meshes import surface
from graft.viz.shapes import Shape, contact_shapes, rod
from graft.viz.transfers import as_sequence

if TYPE_CHECKING:
    from graft.contact.transfer import TransferredContact
    from graft.grasp.grasps import GraspSet

LINK_RADIUS = 0.008
"""Radius of the strongest line, in diagonals of an object."""

Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, -1.0, 0, 0], [0, 0, 0, 1.0]])
"""T_gltf_world: glTF has y up."""


def save_glb(path: str | Path, transfers: TransferredContact | Sequence[TransferredContact]) -> None:
    """Write transfers as one GLB file, in the layout and colours of `save_scene`.

    Nodes are called <number>_<target>/source/<part>, <number>_<target>/target/<part>; beside the parts stand
    marks/contact and marks/normal; lines are <number>_<target>/link_<number>.

    Args:
        path: Ends in .glb.
        transfers: One or several.

    Raises:
        InputError: No transfer, or the file cannot be written.
        MissingExtraError: Large meshes have to be thinned, and fast-simplification is not installed.
    """
    path = check_output(path, ".glb")
    scene = trimesh.Scene()
    for cell in lay_out(as_sequence(transfers)):
        for placed in (cell.source, cell.target):
            _add_object(scene, placed)
        _add_links(scene, cell)
    write_whole(path, bytes(scene.export(file_type="glb")))


def save_grasp_glb(path: str | Path, obj: PartObject, grasps: GraspSet, contact: Contact | None = None) -> None:
    """Write an object and grasps on it as one GLB file, in the layout and colours of `save_grasp_scene`.

    Nodes are called object/<part>, object/marks/contact, object/grasps/best/<box> and object/grasps/grasp_<number>.

    Args:
        path: Ends in .glb.
        obj: The object, in its own unit.
        grasps: In metres, best first.
        contact: Where the object was to be taken, object units.

    Raises:
        InputError: There is no grasp, the object has no size in metres, or the file cannot be written.
        MissingExtraError: Large meshes have to be thinned, and fast-simplification is not installed.
    """
    path = check_output(path, ".glb")
    placed, shapes = place_grasps(obj, grasps, contact)
    scene = trimesh.Scene()
    _add_object(scene, placed)
    for shape in shapes:
        opacity = BOX_OPACITY if shape.name.startswith(BEST) else 1.0
        _add(scene, f"{placed.name}/grasps/{shape.name}", shape, placed.pose, opacity)
    write_whole(path, bytes(scene.export(file_type="glb")))


def _add(scene: trimesh.Scene, name: str, shape: Shape, pose: Floats, opacity: float = 1.0) -> None:
    scene.add_geometry(surface(shape, opacity), node_name=name, geom_name=name, transform=Y_UP @ pose)


def _add_object(scene: trimesh.Scene, placed: Placed) -> None:
    """Add an object's parts and the marks of its contact."""
    for shape in placed.shapes:
        _add(scene, f"{placed.name}/{shape.name}", shape, placed.pose)
    if placed.contact is not None:
        for shape in contact_shapes(placed.contact, 1.0):
            _add(scene, f"{placed.name}/marks/{shape.name}", shape, placed.pose)


def _add_links(scene: trimesh.Scene, cell: Cell) -> None:
    """Add the lines as thin rods, fainter and thinner where less mass goes."""
    for i, link in enumerate(cell.links):
        vertices, faces = rod(link.start, link.end, LINK_RADIUS * (0.3 + 0.7 * link.strength))
        shape = Shape(f"link_{i}", vertices, faces, link.color)
        _add(scene, f"{cell.name}/{shape.name}", shape, np.eye(4), opacity=0.3 + 0.6 * link.strength)

"""URDF: links or visuals become parts and joints edges, all joints at zero, in the root link's frame.

Visual geometry is read; collision geometry only when no link has any visual.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from graft.errors import InputError, InputWarning
from graft.io import primitives
from graft.io.guards import malformed_is_input_error
from graft.io.mesh_file import read_raw
from graft.io.packages import AssetPaths, Lookup
from graft.io.pieces import cleaned, merged
from graft.io.robot_parts import Body, Freedom, RigidPiece, check_choice, parts_and_joints
from graft.io.robot_xml import at_line, read_description
from graft.io.urdf_file import Link, Robot, Visual, parse_robot
from graft.objects import Floats, Ints, PartObject

Surface = tuple[Floats, Ints, tuple[str, ...]]
"""Vertices (v, 3), faces (f, 3), and what was dropped."""

Missing = Literal["error", "skip"]
MISSING_CHOICES: tuple[str, ...] = ("error", "skip")
PARTS_CHOICES: Mapping[str, bool | None] = {"auto": None, "links": True, "visuals": False}

LISTED = 3
"""So many missing meshes are named in a message; the rest are counted."""

UP = (0.0, 0.0, 1.0)
"""REP 103: z points up in a robot's base frame."""


def load_urdf(
    path: str | Path,
    *,
    parts: Literal["auto", "links", "visuals"] = "auto",
    packages: Mapping[str, Path] | None = None,
    missing: Missing = "error",
) -> PartObject:
    """Load a URDF file.

    Args:
        path: The file; xacro must have been run before.
        parts: What becomes a part: every link with geometry, every visual, or ("auto") links when several
            have geometry and visuals when only one has.
        packages: Folders of package:// names, tried before the folder that encloses the file and before the
            ROS environment variables.
        missing: Whether a mesh that is not found is an error, or is left out with one `InputWarning`.

    Returns:
        The object in metres in the root link's frame, z up, all joints at zero.

    Raises:
        InputError: The file or one of its meshes cannot be used; the message has the line.
    """
    path = Path(path)
    check_choice("parts", parts, tuple(PARTS_CHOICES))
    check_choice("missing", missing, MISSING_CHOICES)
    robot = parse_robot(path, read_description(path))
    scene = read_scene(path, robot, packages=packages or {}, missing=missing)
    try:
        made, joints = parts_and_joints(scene.bodies, whole=PARTS_CHOICES[parts])
    except InputError as error:
        raise InputError(str(error), path=path) from None
    return PartObject(
        name=path.stem,
        parts=made,
        joints=joints,
        up=np.array(UP),
        scale_to_metres=1.0,
        notes=tuple(scene.notes),
        source=str(path),
    )


@dataclass(frozen=True, eq=False)
class Scene:
    """A robot's links as bodies, in the root link's frame, and what was noticed."""

    bodies: list[Body] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def read_scene(path: Path, robot: Robot, *, packages: Mapping[str, Path], missing: Missing) -> Scene:
    """Read the geometry of `robot` and put it where the zero configuration has it.

    Raises:
        InputError: A mesh is missing (unless `missing` is "skip") or cannot be read.
    """
    scene = Scene()
    use_collisions = not any(link.visuals for link in robot.links)
    if use_collisions and any(link.collisions for link in robot.links):
        scene.notes.append("no link has a visual: collision geometry was read")
    chosen = {link.name: link.collisions if use_collisions else link.visuals for link in robot.links}
    lookups = _find_meshes(path, chosen, packages)
    _report_missing(path, lookups, missing, scene.notes)

    frames: dict[str, Floats] = {}
    indices: dict[str, int] = {}
    meshes: dict[Path, Surface] = {}
    for link in robot.links:
        joint = robot.joint_above.get(link.name)
        parent = None if joint is None else indices[joint.parent]
        frame = np.eye(4) if joint is None else frames[joint.parent] @ joint.T_parent_child
        frames[link.name], indices[link.name] = frame, len(scene.bodies)
        freedoms: tuple[Freedom, ...] = ()
        if joint is not None:
            scene.notes.extend(joint.notes)
            if joint.kind != "fixed":
                axis = None if joint.axis is None else frame[:3, :3] @ joint.axis
                freedoms = (Freedom(joint.kind, joint.name, frame[:3, 3], axis, joint.limits),)
        pieces = tuple(_pieces(path, link, chosen[link.name], frame, lookups, meshes))
        fixed_name = "" if joint is None else joint.name
        scene.bodies.append(Body(link.name, parent, frame[:3, 3], freedoms, pieces, fixed_name))
    return scene


def _find_meshes(
    path: Path, chosen: Mapping[str, tuple[Visual, ...]], packages: Mapping[str, Path]
) -> dict[str, tuple[Visual, Lookup]]:
    """Look every mesh address up once."""
    paths = AssetPaths(path, packages)
    lookups: dict[str, tuple[Visual, Lookup]] = {}
    for visual in (visual for visuals in chosen.values() for visual in visuals if visual.shape == "mesh"):
        if visual.mesh not in lookups:
            try:
                lookups[visual.mesh] = (visual, paths.find(visual.mesh))
            except InputError as error:
                raise at_line(path, visual.element, str(error)) from None
    return lookups


def _report_missing(
    path: Path, lookups: Mapping[str, tuple[Visual, Lookup]], missing: Missing, notes: list[str]
) -> None:
    absent = [(address, *found) for address, found in lookups.items() if found[1].file is None]
    if not absent:
        return
    count = "1 mesh is" if len(absent) == 1 else f"{len(absent)} meshes are"
    more = f"; and {len(absent) - LISTED} more" if len(absent) > LISTED else ""
    if missing == "skip":
        named = ", ".join(address for address, _, _ in absent[:LISTED])
        note = f"{count} missing and left out: {named}{more.replace('; and', ' and')}"
        notes.append(note)
        warnings.warn(f"{path}: {note}", InputWarning, stacklevel=4)
        return
    named = "; ".join(f"{address} (tried {_tried(lookup)})" for address, _, lookup in absent[:LISTED])
    raise at_line(path, absent[0][1].element, f"{count} missing: {named}{more}")


def _tried(lookup: Lookup) -> str:
    return ", ".join(str(path) for path in lookup.tried) or "nothing: no folder is known for it"


def _pieces(
    path: Path,
    link: Link,
    visuals: tuple[Visual, ...],
    frame: Floats,
    lookups: Mapping[str, tuple[Visual, Lookup]],
    meshes: dict[Path, Surface],
) -> Iterator[RigidPiece]:
    """Yield the geometry of `link` in the object frame; missing meshes are left out."""
    for visual in visuals:
        notes: tuple[str, ...] = ()
        if visual.shape == "mesh":
            file = lookups[visual.mesh][1].file
            if file is None:
                continue
            if file not in meshes:
                meshes[file] = _surface(file)
            vertices, faces, notes = meshes[file]
            name = visual.name or file.stem
        else:
            vertices, faces = _primitive(visual)
            name = visual.name or f"{link.name}_{visual.shape}"
        if np.prod(np.sign(visual.scale)) < 0:
            faces = faces[:, ::-1]
        T_object_visual = frame @ visual.T_link_visual
        with np.errstate(over="ignore", invalid="ignore"):
            vertices = (vertices * visual.scale) @ T_object_visual[:3, :3].T + T_object_visual[:3, 3]
        if not np.isfinite(vertices).all():
            raise at_line(path, visual.element, f"visual {name!r} of link {link.name!r}: its coordinates overflow")
        yield RigidPiece(name, vertices, faces, notes=notes, named=bool(visual.name))


def _surface(file: Path) -> Surface:
    """Read a mesh file as one surface: a visual is one piece whatever groups its file has."""
    raw = read_raw(file)
    with malformed_is_input_error(file, "mesh"):
        piece = cleaned(merged(file.stem, raw))
    if not len(piece.faces):
        raise InputError("expected faces, found points only", path=file)
    return piece.vertices, piece.faces, piece.notes


def _primitive(visual: Visual) -> primitives.Triangles:
    if visual.shape == "box":
        return primitives.box(np.array(visual.size) / 2)
    if visual.shape == "sphere":
        return primitives.sphere(visual.size[0])
    radius, length = visual.size
    return (primitives.cylinder if visual.shape == "cylinder" else primitives.capsule)(radius, length / 2)

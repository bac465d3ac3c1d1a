"""MJCF: bodies or geoms become parts and joints edges, in the world frame at the reference pose qpos0.

MuJoCo itself compiles the model, so defaults, classes, includes, frames, fromto, mesh scales and angle units
mean here what they mean there.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from graft.errors import InputError, MissingExtraError
from graft.io import primitives
from graft.io.guards import existing_file
from graft.io.mjcf_files import check_model
from graft.io.robot_parts import Body, Freedom, RigidPiece, check_choice, parts_and_joints
from graft.objects import Floats, JointType, PartObject

PARTS_CHOICES: Mapping[str, bool | None] = {"auto": None, "bodies": True, "geoms": False}

HIDDEN_GROUP = 3
"""MuJoCo's viewer does not draw geom groups from 3 on by default: the place for collision shapes."""

JOINT_KINDS: tuple[JointType, ...] = ("free", "ball", "slide", "hinge")
"""In the order of MuJoCo's mjtJoint."""


def load_mjcf(
    path: str | Path,
    *,
    parts: Literal["auto", "bodies", "geoms"] = "auto",
    packages: Mapping[str, Path] | None = None,
) -> PartObject:
    """Load an MJCF file.

    Where a body has geoms in groups 0 to 2, those in the hidden groups 3 to 5 are left out. Of what remains,
    where a body has geoms that cannot collide (contype and conaffinity 0: visuals), the colliding ones in
    other groups are left out. Planes and height fields have no bounded surface and are left out too. Notes
    count what was left out.

    Args:
        path: The file.
        parts: What becomes a part: every body with geometry, every geom, or ("auto") bodies when several have
            geometry and geoms when only one has.
        packages: Folders, by any name, that the model may name files in beside its asset root, which is
            `packages.asset_root`.

    Returns:
        The object in metres in the world frame at qpos0; up is against gravity, or z where there is none.

    Raises:
        InputError: The model or a file that it names cannot be used.
        MissingExtraError: MuJoCo is not installed.
    """
    path = existing_file(path)
    check_choice("parts", parts, tuple(PARTS_CHOICES))
    scene = read_bodies(path, packages=packages)
    try:
        made, joints = parts_and_joints(scene.bodies, whole=PARTS_CHOICES[parts])
    except InputError as error:
        raise InputError(str(error), path=path) from None
    strength = float(np.linalg.norm(scene.gravity))
    return PartObject(
        name=path.stem,
        parts=made,
        joints=joints,
        up=0.0 - scene.gravity / strength if strength > 0 else np.array([0.0, 0.0, 1.0]),
        scale_to_metres=1.0,
        notes=tuple(scene.notes),
        source=str(path),
    )


@dataclass(frozen=True, eq=False)
class Scene:
    """A model's bodies in the world frame at qpos0, gravity (3,) in m/s^2, and what was noticed."""

    bodies: list[Body]
    gravity: Floats
    notes: list[str]


def read_bodies(path: Path, *, packages: Mapping[str, Path] | None = None) -> Scene:
    """Read the bodies of an MJCF file with the geoms that `load_mjcf` keeps; see there."""
    check_model(path, tuple(Path(folder) for folder in (packages or {}).values()))
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError(f"reading the MJCF file {path}", package="mujoco", extra="sim") from None

    notes: list[str] = []
    model = _compiled(mujoco, path, notes)
    data = mujoco.MjData(model)  # its qpos is qpos0
    mujoco.mj_kinematics(model, data)
    bodies = [_body(mujoco, model, data, body, geoms) for body, geoms in enumerate(_kept_geoms(mujoco, model, notes))]
    return Scene(bodies, np.array(model.opt.gravity), notes)


def _compiled(mujoco: Any, path: Path, notes: list[str]) -> Any:
    """Return the compiled model, with all geoms and bodies, and without textures, which no part needs.

    MuJoCo's warnings become `notes`; left alone it appends them to a file in the current folder.
    """

    def warn(message: str) -> None:
        notes.append(f"MuJoCo warns: {' '.join(message.split())}")

    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(warn)
    try:
        with warnings.catch_warnings(record=True) as deprecations:
            warnings.simplefilter("always")
            spec = mujoco.MjSpec.from_file(str(path))
            for material in spec.materials:
                material.textures = [""] * len(material.textures)
            for texture in list(spec.textures):
                spec.delete(texture)
            spec.compiler.discardvisual = False
            spec.compiler.fusestatic = False
            spec.memory = -1  # what it needs, not what the file reserves
            model = spec.compile()
        for deprecation in deprecations:
            warn(str(deprecation.message))
        return model
    except (ValueError, TypeError, RuntimeError, MemoryError, mujoco.FatalError) as error:
        raise InputError(f"MuJoCo refuses it: {error}", path=path) from None
    finally:
        mujoco.set_mju_user_warning(before)


def _kept_geoms(mujoco: Any, model: Any, notes: list[str]) -> list[list[int]]:
    """Return the geoms of every body that show its surface; `notes` get the count of the others."""
    unbounded = (int(mujoco.mjtGeom.mjGEOM_PLANE), int(mujoco.mjtGeom.mjGEOM_HFIELD))
    kept: list[list[int]] = []
    planes, fields, collisions = 0, 0, 0
    for body in range(model.nbody):
        first = int(model.body_geomadr[body])
        geoms = list(range(first, first + int(model.body_geomnum[body])))
        planes += sum(model.geom_type[geom] == unbounded[0] for geom in geoms)
        fields += sum(model.geom_type[geom] == unbounded[1] for geom in geoms)
        surface = [geom for geom in geoms if model.geom_type[geom] not in unbounded]
        shown = _shown(model, surface)
        collisions += len(surface) - len(shown)
        kept.append(shown)
    for count, what in (
        (planes, "planes left out: they have no bounded surface"),
        (fields, "height fields left out: they are terrain"),
        (collisions, "collision geoms left out: their bodies have visual ones"),
    ):
        if count:
            notes.append(f"{count} {what}")
    return kept


def _shown(model: Any, geoms: list[int]) -> list[int]:
    """Return those of one body's geoms that are its visual surface; see `load_mjcf` for the rule."""
    drawn = [geom for geom in geoms if model.geom_group[geom] < HIDDEN_GROUP] or geoms
    visual_groups = {
        int(model.geom_group[geom])
        for geom in drawn
        if model.geom_contype[geom] == 0 and model.geom_conaffinity[geom] == 0
    }
    return [geom for geom in drawn if not visual_groups or int(model.geom_group[geom]) in visual_groups]


def _body(mujoco: Any, model: Any, data: Any, body: int, geoms: list[int]) -> Body:
    name = model.body(body).name or f"body_{body}"
    first = int(model.body_jntadr[body])
    joints = range(first, first + int(model.body_jntnum[body]))
    return Body(
        name=name,
        parent=int(model.body_parentid[body]) if body else None,
        origin=np.array(data.xpos[body]),
        freedoms=tuple(_freedom(model, data, name, joint) for joint in joints),
        pieces=tuple(_piece(mujoco, model, data, name, geom) for geom in geoms),
    )


def _freedom(model: Any, data: Any, body_name: str, joint: int) -> Freedom:
    kind = JOINT_KINDS[int(model.jnt_type[joint])]
    turns_or_slides = kind in ("hinge", "slide")
    limited = turns_or_slides and bool(model.jnt_limited[joint])
    return Freedom(
        kind=kind,
        name=model.joint(joint).name or f"{body_name}_{kind}",
        origin=np.array(data.xanchor[joint]),
        axis=np.array(data.xaxis[joint]) if turns_or_slides else None,
        limits=(float(model.jnt_range[joint][0]), float(model.jnt_range[joint][1])) if limited else None,
    )


def _piece(mujoco: Any, model: Any, data: Any, body_name: str, geom: int) -> RigidPiece:
    kind = mujoco.mjtGeom(int(model.geom_type[geom]))
    shape = kind.name.removeprefix("mjGEOM_").lower()
    name = model.geom(geom).name
    mesh = int(model.geom_dataid[geom])
    if shape in ("mesh", "sdf"):
        vertices, faces = _mesh(model, mesh)
        name = name or model.mesh(mesh).name
    else:
        vertices, faces = _primitive(shape, np.array(model.geom_size[geom], np.float64))
    rotation = np.array(data.geom_xmat[geom]).reshape(3, 3)
    vertices = vertices @ rotation.T + np.array(data.geom_xpos[geom])
    return RigidPiece(name or f"{body_name}_{shape}", vertices, faces)


def _mesh(model: Any, mesh: int) -> primitives.Triangles:
    """Return a mesh as MuJoCo keeps it: single precision, in its inertial frame."""
    vertex, face = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
    vertices = model.mesh_vert[vertex : vertex + int(model.mesh_vertnum[mesh])].astype(np.float64)
    faces = model.mesh_face[face : face + int(model.mesh_facenum[mesh])].astype(np.int64)
    return vertices, faces


def _primitive(shape: str, size: Floats) -> primitives.Triangles:
    if shape == "box":
        return primitives.box(size)
    if shape == "sphere":
        return primitives.sphere(size[0])
    if shape == "ellipsoid":
        return primitives.ellipsoid(size)
    return (primitives.cylinder if shape == "cylinder" else primitives.capsule)(size[0], size[1])

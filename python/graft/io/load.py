"""`load_object` and `as_object`: from a path or from arrays to an object made of parts."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, Union

import numpy as np

from graft.errors import InputError, InputWarning
from graft.io.file import KNOWN_SUFFIXES, ROBOT_SUFFIXES, load_mesh_file, load_robot_file
from graft.io.folder import load_folder
from graft.io.pieces import RawMesh, check_range, cleaned
from graft.io.splitting import split_by_labels
from graft.objects import Part, PartObject, unique_names
from graft.parts import cut_object

if TYPE_CHECKING:
    import trimesh

PathLike: TypeAlias = str | os.PathLike[str]
ObjectLike: TypeAlias = Union[PathLike, PartObject, "trimesh.Trimesh", "trimesh.Scene", Sequence[Any]]
"""What names an object: a path, a `PartObject`, a `trimesh.Trimesh` or `Scene`, `(vertices, faces)`, or
`(vertices, faces, labels)` with a number or name per face. `(points, None, labels)` is a labelled cloud."""

Parts: TypeAlias = Literal["auto", "segment", "bodies", "geoms", "links", "visuals"]
Missing: TypeAlias = Literal["error", "skip"]

SMALLEST_METRES, LARGEST_METRES = 0.005, 5.0
"""Diagonals between which a household object lies: a screw, a wardrobe."""

MILLIMETRE_DIAGONAL = 20.0
"""In a file without a unit, a diagonal above this was hardly meant as metres."""


def load_object(
    path: PathLike,
    *,
    parts: Parts = "auto",
    packages: Mapping[str, PathLike] | None = None,
    missing: Missing = "error",
    up: Sequence[float] | None = None,
    scale_to_metres: float | None = None,
) -> PartObject:
    """Read an object and its parts.

    What is read, and what the parts are (docs/formats.md has more):

    * GLB and glTF: every node with a mesh. By its specification glTF is in metres with +Y up, so that `up` is
      (0, 1, 0) and `scale_to_metres` 1, unless graft wrote the file, which then keeps the object's own frame.
    * COLLADA: every node with a geometry, in metres, up as the file says.
    * OBJ: every object and group. STL: every solid. PLY, OFF: one part, or one per label.
    * A mesh with face labels next to it (`<stem>.seg`, `.npy`, `.npz`, or `parts.*`) and an `object.json`.
    * Point clouds `x y z [nx ny nz] label` as text, PLY with a label property, `.npz`.
    * MJCF (.xml), URDF (.urdf, .xml), PartNet-Mobility folders.
    * A folder with one mesh per part, or with one of the above, or a demonstration's folder.

    Args:
        path: A file or a folder.
        parts: "auto" takes the parts that the file has. "segment" does, too, and where that is one fused part, or a
            soup of more than 32 without joints, it is cut as `graft.segment` cuts it. For MJCF also "bodies" or
            "geoms", for URDF "links" or "visuals".
        packages: Name -> folder of ROS packages, for `package://` in URDF.
        missing: "error", or "skip" to leave out meshes that a URDF or PartNet folder refers to in vain.
        up: (3,) direction against gravity in the object frame; overrides the file.
        scale_to_metres: Metres per object unit; overrides the file.

    Returns:
        The object. What was dropped or noticed stands in its `notes` and its parts', and is warned of.

    Raises:
        InputError: The file cannot be used; one line that names it and the culprit in it.

    Warns:
        InputWarning: Faces were dropped, or the size is implausible for the unit. Nothing is rescaled.
    """
    path = Path(path)
    try:
        obj = _read(path, parts="auto" if parts == "segment" else parts, packages=packages, missing=missing)
        obj = cut_object(obj) if parts == "segment" else obj
        obj = replace(
            obj,
            source=str(path),
            up=obj.up if up is None else np.asarray(up, np.float64),
            scale_to_metres=obj.scale_to_metres if scale_to_metres is None else float(scale_to_metres),
        )
    except InputError as error:
        if error.path is not None:
            raise
        raise InputError(str(error), path=path) from None
    return _with_size_note(obj, path)


def _read(
    path: Path,
    *,
    parts: Literal["auto", "bodies", "geoms", "links", "visuals"],
    packages: Mapping[str, PathLike] | None,
    missing: Missing,
) -> PartObject:
    """Find out what is meant, and read it."""
    folders = {name: Path(folder) for name, folder in (packages or {}).items()}
    if not path.exists():
        raise InputError("no such file or folder", path=path)
    if path.is_dir():
        return load_folder(path, parts=parts, packages=folders, missing=missing)
    if path.suffix.lower() in ROBOT_SUFFIXES:
        return load_robot_file(path, parts=parts, packages=folders, missing=missing)
    if path.suffix.lower() in KNOWN_SUFFIXES:
        if parts != "auto":
            raise InputError(f"parts: {parts!r} is a choice for MJCF and URDF, not for meshes", path=path)
        return load_mesh_file(path)
    raise InputError(f"unknown suffix {path.suffix!r}: the known ones are {', '.join(KNOWN_SUFFIXES)}", path=path)


def _with_size_note(obj: PartObject, path: Path) -> PartObject:
    """Notice a size that no household object has, as when millimetres are taken for metres."""
    diagonal = float(np.linalg.norm(np.ptp(obj.bounds, axis=0)))
    scale = obj.scale_to_metres
    if scale is not None and not SMALLEST_METRES <= diagonal * scale <= LARGEST_METRES:
        likely = 0.001 if SMALLEST_METRES <= diagonal * 0.001 <= LARGEST_METRES else None
        hint = f"millimetres? then pass scale_to_metres={likely}" if likely else "check scale_to_metres"
        note = f"{diagonal * scale:.4g} m across at {scale:g} metres per unit: {hint}"
    elif scale is None and diagonal > MILLIMETRE_DIAGONAL:
        note = f"{diagonal:.4g} units across and no unit is given: millimetres? then pass scale_to_metres=0.001"
    else:
        return obj
    if note in obj.notes:
        return obj
    warnings.warn(f"{path}: {note}", InputWarning, stacklevel=3)
    return replace(obj, notes=(*obj.notes, note))


def as_object(value: ObjectLike) -> PartObject:
    """Return the object that `value` names.

    Args:
        value: See `ObjectLike`. Paths are read with `load_object`. Every geometry of a `trimesh.Scene` is a
            part, as often as the scene graph places it, in the scene's frame.

    Raises:
        InputError: It is something else, or cannot be used.
    """
    if isinstance(value, PartObject):
        return value
    if isinstance(value, str | os.PathLike):
        return load_object(value)
    library = sys.modules.get("trimesh")  # a value of its types cannot exist before it is imported
    if library is not None and isinstance(value, library.Scene):
        return _from_scene(value)
    if library is not None and isinstance(value, library.Trimesh | library.PointCloud):
        name = str(value.metadata.get("name") or "object")
        return _from_meshes(name, [_raw(name, value, np.eye(4))])
    if isinstance(value, tuple | list) and len(value) in (2, 3):
        return _from_arrays(*value)
    raise InputError(
        "object: expected a path, a PartObject, a trimesh.Trimesh or Scene, or (vertices, faces[, labels]), "
        f"got {type(value).__name__}"
    )


def _from_scene(scene: Any) -> PartObject:
    rank = {name: i for i, name in enumerate(scene.geometry)}
    placed = [(node, *scene.graph[node]) for node in scene.graph.nodes_geometry]
    placed.sort(key=lambda row: (rank[row[2]], row[0]))
    counts = [geometry for _, _, geometry in placed]
    meshes = [
        _raw(geometry if counts.count(geometry) == 1 else node, scene.geometry[geometry], transform)
        for node, transform, geometry in placed
        if hasattr(scene.geometry[geometry], "vertices") and not hasattr(scene.geometry[geometry], "entities")
    ]
    if not meshes:
        raise InputError("scene: expected at least one mesh or point cloud, got none")
    return _from_meshes(str(scene.metadata.get("name") or "object"), meshes)


def _raw(name: str, mesh: Any, transform: Any) -> RawMesh:
    linear = np.asarray(transform)[:3, :3]
    vertices = np.asarray(mesh.vertices, np.float64) @ linear.T + np.asarray(transform)[:3, 3]
    faces = np.asarray(getattr(mesh, "faces", np.empty((0, 3))), np.int64).reshape(-1, 3)
    return RawMesh(str(name), vertices, faces[:, ::-1] if np.linalg.det(linear) < 0 else faces)


def _from_arrays(vertices: Any, faces: Any, labels: Any = None) -> PartObject:
    # Part checks shapes and finiteness of what it is given; here NaN corners are dropped with a note instead.
    try:
        points = np.asarray(vertices, np.float64)
        triangles = np.asarray(np.empty((0, 3), np.int64) if faces is None else faces)
    except (TypeError, ValueError) as error:
        raise InputError(f"vertices, faces: expected arrays of numbers ({error})") from None
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"vertices: expected shape (v, 3), got {points.shape}")
    triangles = triangles.reshape(0, 3).astype(np.int64) if triangles.size == 0 else triangles
    if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu":
        raise InputError(f"faces: expected integers of shape (f, 3), got {triangles.shape} of {triangles.dtype}")
    mesh = RawMesh("object", points, triangles.astype(np.int64))
    check_range(mesh.faces, len(points))
    if labels is None:
        return _from_meshes("object", [mesh])
    given = np.asarray(labels)
    if given.ndim != 1 or given.dtype.kind not in "iuUO":
        raise InputError(f"labels: expected a number or a name for each face, got {given.shape} of {given.dtype}")
    names = None
    if given.dtype.kind in "UO":
        words, given = np.unique(given.astype(str), return_inverse=True)
        names = tuple(words.tolist())
    pieces, _ = split_by_labels(mesh, given.astype(np.int64), names, path="labels")
    return _from_meshes("object", pieces)


def _from_meshes(name: str, meshes: list[RawMesh]) -> PartObject:
    names = unique_names(mesh.name for mesh in meshes)
    parts = []
    for unique, mesh in zip(names, meshes, strict=True):
        piece = cleaned(mesh)
        parts.append(Part(unique, piece.vertices, piece.faces, piece.normals, piece.name, piece.notes))
        for note in piece.notes:
            warnings.warn(f"{name}: part {unique!r}: {note}", InputWarning, stacklevel=3)
    return PartObject(name, tuple(parts))

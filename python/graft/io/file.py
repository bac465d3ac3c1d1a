"""One file as an object: meshes with what stands next to them, and robot descriptions."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from graft.errors import InputError, InputWarning
from graft.io.cloud import TEXT_SUFFIXES, read_npz_mesh, read_text_cloud
from graft.io.dae import read_dae
from graft.io.gltf import GRAFT_SCHEMA, UP, read_gltf
from graft.io.guards import malformed_is_input_error
from graft.io.mesh_file import MESH_SUFFIXES, read_raw
from graft.io.pieces import Piece, RawMesh, cleaned, merged
from graft.io.robot_xml import read_description
from graft.io.sidecar import LABEL_SUFFIXES, ObjectWords, find_beside, read_labels, read_object_words
from graft.io.splitting import split_by_labels
from graft.objects import Joint, Part, PartObject, unique_names

ROBOT_SUFFIXES = (".urdf", ".xml")
"""Of URDF and MJCF; the root element tells which of them a file is."""

KNOWN_SUFFIXES = (*MESH_SUFFIXES, ".npz", *TEXT_SUFFIXES, *ROBOT_SUFFIXES)
"""Of every file that `load_object` reads."""


def load_robot_file(
    path: Path,
    *,
    parts: Literal["auto", "bodies", "geoms", "links", "visuals"],
    packages: Mapping[str, Path],
    missing: Literal["error", "skip"],
) -> PartObject:
    """Read an MJCF or URDF file; the root element tells which."""
    root = read_description(path)
    if root.tag == "mujoco":
        if parts not in ("auto", "bodies", "geoms"):
            raise InputError(f"parts: MJCF has bodies or geoms, got {parts!r}", path=path)
        from graft.io.mjcf import load_mjcf

        mjcf: PartObject = load_mjcf(path, parts=parts, packages=packages)
        return mjcf
    if root.tag == "robot":
        if parts not in ("auto", "links", "visuals"):
            raise InputError(f"parts: URDF has links or visuals, got {parts!r}", path=path)
        from graft.io.urdf import load_urdf

        urdf: PartObject = load_urdf(path, parts=parts, packages=dict(packages), missing=missing)
        return urdf
    raise InputError(f"expected <mujoco> or <robot>, got <{root.tag}>", path=path)


def load_mesh_file(path: Path, *, alone: bool | None = None) -> PartObject:
    """Read a mesh or point cloud with the labels and the object.json next to it.

    Args:
        path: One of `KNOWN_SUFFIXES` but the robot descriptions.
        alone: Whether it is the only mesh of its folder, so that `parts.*` and `object.json` are about it;
            found out when None.
    """
    if alone is None:
        others = [p for p in path.parent.iterdir() if p.suffix.lower() in MESH_SUFFIXES and p != path]
        alone = not others
    stems = (path.stem, "parts") if alone else (path.stem,)
    label_file = find_beside(path, stems, LABEL_SUFFIXES)
    words_file = find_beside(path, (path.stem, "object") if alone else (path.stem,), (".json",))
    words = ObjectWords() if words_file is None else read_object_words(words_file)
    if path.suffix.lower() in (".glb", ".gltf") and label_file is None:
        return _with_words(_load_gltf(path), words, path)

    up: tuple[float, float, float] | None = None
    if path.suffix.lower() == ".dae":
        with malformed_is_input_error(path, "COLLADA"):
            meshes, up = read_dae(path)
    else:
        meshes = _read(path)
    whole = meshes[0] if len(meshes) == 1 else merged(path.stem, meshes)
    labels = whole.vertex_labels if whole.face_labels is None else whole.face_labels
    if label_file is not None:
        labels = read_labels(label_file)
    numbers: list[int] | None = None
    if labels is not None:
        meshes, numbers = split_by_labels(whole, labels, words.part_names, path=label_file or path)
    obj = assemble(path.stem, meshes, path=path)
    if path.suffix.lower() in (".glb", ".gltf", ".dae"):
        obj = replace(obj, up=np.array(UP if up is None else up), scale_to_metres=1.0)
    if numbers is None and len(meshes) == 1 and words.part_names is not None and len(words.part_names) == 1:
        obj = replace(obj, parts=(replace(obj.parts[0], name=words.part_names[0], label=words.part_names[0]),))
    return _with_words(obj, words, path, numbers)


def _read(path: Path) -> list[RawMesh]:
    suffix = path.suffix.lower()
    if suffix in MESH_SUFFIXES:
        return read_raw(path)
    with malformed_is_input_error(path, "point cloud"):
        return read_npz_mesh(path) if suffix == ".npz" else read_text_cloud(path)


def assemble(name: str, meshes: list[RawMesh], *, path: Path, notes: tuple[str, ...] = ()) -> PartObject:
    """Make an object of meshes, one part each; says what was dropped."""
    names = unique_names(mesh.name for mesh in meshes)
    parts = []
    with malformed_is_input_error(path, "mesh"):
        for unique, mesh in zip(names, meshes, strict=True):
            piece: Piece = cleaned(mesh)
            parts.append(Part(unique, piece.vertices, piece.faces, piece.normals, piece.name, piece.notes))
        said = [f"part {part.name!r}: {note}" for part in parts for note in part.notes]
        obj = PartObject(name, tuple(parts), notes=(*notes, *said))
    for note in obj.notes:
        warnings.warn(f"{path}: {note}", InputWarning, stacklevel=2)
    return obj


def _with_words(obj: PartObject, words: ObjectWords, path: Path, numbers: list[int] | None = None) -> PartObject:
    """Add what object.json says; `numbers` are the label numbers of the parts, their own order when None."""
    places = {number: i for i, number in enumerate(range(len(obj.parts)) if numbers is None else numbers)}
    notes = list(obj.notes)
    if numbers is not None and words.part_names is not None:
        empty = [name for i, name in enumerate(words.part_names) if i not in places]
        if empty:
            notes.append(f"no face or point is labelled {', '.join(map(repr, empty))}")
            warnings.warn(f"{path}: {notes[-1]}", InputWarning, stacklevel=2)
    graspable = obj.graspable
    if words.graspable:
        if words.part_names is None and any(g not in places for g in words.graspable):
            raise InputError(f"object.json graspable_parts {list(words.graspable)}: no such part", path=path)
        graspable = tuple(places[g] for g in words.graspable if g in places)
    return replace(
        obj,
        name=words.name or obj.name,
        category=words.category or obj.category,
        up=obj.up if words.up is None else np.array(words.up),
        scale_to_metres=obj.scale_to_metres if words.scale_to_metres is None else words.scale_to_metres,
        graspable=graspable,
        notes=tuple(notes),
    )


def _load_gltf(path: Path) -> PartObject:
    with malformed_is_input_error(path, "glTF"):
        scene = read_gltf(path)
    meshes = scene.meshes
    if scene.extras is None:
        obj = assemble(path.stem, meshes, path=path, notes=tuple(dict.fromkeys(scene.notes)))
        return replace(obj, up=np.array(UP), scale_to_metres=1.0)
    with malformed_is_input_error(path, "graft extras"):
        return _own(assemble(path.stem, meshes, path=path), scene.extras, scene.mesh_extras, path)


def _own(obj: PartObject, extras: dict[str, Any], parts: list[dict[str, Any]], path: Path) -> PartObject:
    """Give an object read from graft's own GLB back what the extras keep."""
    if extras["schema"] != GRAFT_SCHEMA:
        raise InputError(f"graft schema {extras['schema']!r} is not read, {GRAFT_SCHEMA} is: a newer graft wrote it")
    up = extras.get("up")
    named = tuple(
        replace(
            part,
            name=_text(words, "name") or part.name,
            label=_text(words, "label") or part.label,
            notes=(*_texts(words, "notes"), *part.notes),
        )
        for part, words in zip(obj.parts, parts, strict=True)
    )
    joints = tuple(
        Joint(
            j["parent"],
            j["child"],
            j["kind"],
            j["name"],
            None if j["axis"] is None else np.array(j["axis"]),
            None if j["origin"] is None else np.array(j["origin"]),
            None if j["limits"] is None else _limits(*j["limits"]),
        )
        for j in extras.get("joints", [])
    )
    return PartObject(
        _text(extras, "name") or obj.name,
        named,
        joints,
        _text(extras, "category"),
        None if up is None else np.array(up, np.float64),
        extras.get("scale_to_metres"),
        tuple(extras.get("graspable", ())),
        (*_texts(extras, "notes"), *obj.notes),
        source=str(path),
    )


def _text(words: dict[str, Any], key: str) -> str | None:
    value = words.get(key)
    if value is not None and not isinstance(value, str):
        raise InputError(f"graft extras {key}: expected a string, got {value!r}")
    return value


def _texts(words: dict[str, Any], key: str) -> list[str]:
    values = words.get(key, [])
    if not isinstance(values, list) or not all(isinstance(v, str) for v in values):
        raise InputError(f"graft extras {key}: expected a list of strings, got {values!r}")
    return values


def _limits(lower: float | None, upper: float | None) -> tuple[float, float]:
    """Return joint limits; JSON has no infinity, null stands for it."""
    return (-np.inf if lower is None else float(lower), np.inf if upper is None else float(upper))

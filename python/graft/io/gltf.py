"""glTF and GLB: every node that holds a mesh is a part, its transform applied.

By its specification glTF is in metres with +Y up. Files that graft wrote have more to say: a root node whose
`extras` hold the key "graft" keeps the object's own frame, up axis, scale and names (`graft.io.save`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from graft.errors import InputError
from graft.io.gltf_buffers import GltfFile
from graft.io.pieces import RawMesh, check_range, merged
from graft.objects import Floats, Ints

UP = (0.0, 1.0, 0.0)
"""Of glTF (specification, section 3.4)."""

POINTS, TRIANGLES, STRIP, FAN = 0, 4, 5, 6
"""Primitive modes that have a surface or points; lines and loops (1, 2, 3) have neither."""

EXTRAS_KEY = "graft"
"""Under which graft's own words stand in a node's extras."""

GRAFT_SCHEMA = 1
"""Version of graft's words; a file with another is refused rather than misread."""

MAX_DEPTH = 256
"""Nesting of nodes; exporters stay under twenty."""


@dataclass(frozen=True, eq=False)
class Scene:
    """What a glTF file holds.

    Attributes:
        meshes: One per node with a mesh, in the order of the scene graph; in the frame of the node with
            graft's extras when there is one, else the scene's.
        extras: graft's words about the object, None in files of others.
        mesh_extras: graft's words about each mesh; {} where there are none.
        notes: What was not read.
    """

    meshes: list[RawMesh]
    extras: dict[str, Any] | None
    mesh_extras: list[dict[str, Any]]
    notes: list[str]


def read_gltf(path: Path) -> Scene:
    """Read a .gltf or .glb file."""
    file = GltfFile(path)
    nodes = file.document.get("nodes", [])
    scenes = file.document.get("scenes", [])
    if scenes:
        roots = file.item("scenes", file.document.get("scene", 0)).get("nodes", [])
    else:
        children = {c for node in nodes for c in node.get("children", [])}
        roots = [i for i in range(len(nodes)) if i not in children]
    found = Scene([], None, [], [])
    seen: set[int] = set()
    for root in roots:
        found = _visit(file, root, np.eye(4), found, seen, 0)
    if not found.meshes:
        raise InputError("no node of the scene holds a mesh", path=path)
    return found


def _visit(file: GltfFile, index: Any, parent: Floats, found: Scene, seen: set[int], depth: int) -> Scene:
    node = file.item("nodes", index)
    if index in seen or depth > MAX_DEPTH:
        raise InputError(f"node {index}: the scene graph is not a tree", path=file.path)
    seen.add(index)
    world = parent @ _transform(node, index, file.path)
    words = node.get("extras")
    words = words.get(EXTRAS_KEY) if isinstance(words, dict) else None
    words = words if isinstance(words, dict) else None
    if words is not None and "schema" in words and found.extras is None and not found.meshes:
        found = Scene(found.meshes, words, found.mesh_extras, found.notes)
        world = np.eye(4)  # what hangs below is wanted in the object's own frame
    if "mesh" in node:
        mesh = _mesh(file, node, world, found.notes)
        if mesh is not None:
            found.meshes.append(mesh)
            found.mesh_extras.append(words or {})
    for child in node.get("children", []):
        found = _visit(file, child, world, found, seen, depth + 1)
    return found


def _transform(node: dict[str, Any], index: int, path: Path) -> Floats:
    """Return (4, 4) T_parent_node."""
    if "matrix" in node:
        matrix = np.array(node["matrix"], np.float64).reshape(4, 4).T
    else:
        x, y, z, w = np.array(node.get("rotation", (0, 0, 0, 1)), np.float64)
        length = x * x + y * y + z * z + w * w
        if not length > 0:
            raise InputError(f"node {index} rotation: expected a quaternion, got length {length:g}", path=path)
        s = 2.0 / length
        rotation = np.array(
            [
                [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
                [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)],
                [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)],
            ]
        )
        matrix = np.eye(4)
        matrix[:3, :3] = rotation * np.array(node.get("scale", (1, 1, 1)), np.float64).reshape(3)
        matrix[:3, 3] = np.array(node.get("translation", (0, 0, 0)), np.float64).reshape(3)
    if not np.isfinite(matrix).all():
        raise InputError(f"node {index}: its transform is not finite", path=path)
    return matrix


def _mesh(file: GltfFile, node: dict[str, Any], world: Floats, notes: list[str]) -> RawMesh | None:
    mesh = file.item("meshes", node["mesh"])
    name = str(node.get("name") or mesh.get("name") or file.path.stem)
    surfaces, clouds = [], []
    for primitive in mesh["primitives"]:
        mode = primitive.get("mode", TRIANGLES)
        if mode not in (POINTS, TRIANGLES, STRIP, FAN) or "POSITION" not in primitive["attributes"]:
            notes.append(f"{name!r}: lines are not read")
            continue
        if "targets" in primitive or "skin" in node:
            notes.append(f"{name!r}: read in its rest pose, morph targets and skins are not applied")
        vertices = file.floats(primitive["attributes"]["POSITION"])
        if vertices.shape[1] != 3:
            raise InputError(f"{name!r}: POSITION is not VEC3", path=file.path)
        moved = vertices @ world[:3, :3].T + world[:3, 3]
        if mode == POINTS:
            clouds.append(RawMesh(name, moved, normals=_normals(file, primitive, world, len(vertices))))
            continue
        order = file.indices(primitive["indices"]) if "indices" in primitive else np.arange(len(vertices))
        faces = _triangles(order, mode, name, file.path)
        check_range(faces, len(vertices), f"{name!r} face")
        if np.linalg.det(world[:3, :3]) < 0:  # a mirror turns the surface inside out
            faces = faces[:, ::-1]
        surfaces.append(RawMesh(name, moved, faces))
    chosen = surfaces or clouds
    return merged(name, chosen) if chosen else None


def _normals(file: GltfFile, primitive: dict[str, Any], world: Floats, count: int) -> Floats | None:
    """Return the normals of a cloud's points in the scene's frame; they turn by the inverse transpose."""
    if "NORMAL" not in primitive["attributes"] or not abs(np.linalg.det(world[:3, :3])) > 0:
        return None
    normals = file.floats(primitive["attributes"]["NORMAL"])
    if normals.shape != (count, 3):
        raise InputError(f"{len(normals)} normals for {count} points", path=file.path)
    turned: Floats = normals @ np.linalg.inv(world[:3, :3])
    return turned


def _triangles(order: Ints, mode: int, name: str, path: Path) -> Ints:
    if mode == TRIANGLES:
        if len(order) % 3:
            raise InputError(f"{name!r}: {len(order)} indices are no whole number of triangles", path=path)
        return order.reshape(-1, 3)
    if len(order) < 3:
        return np.empty((0, 3), np.int64)
    if mode == FAN:
        return np.stack([np.full(len(order) - 2, order[0]), order[1:-1], order[2:]], axis=1)
    faces = np.stack([order[:-2], order[1:-1], order[2:]], axis=1)
    faces[1::2] = faces[1::2, ::-1]  # every second triangle of a strip runs the other way
    return faces

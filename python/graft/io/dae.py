"""COLLADA (.dae), as robot descriptions refer to: the geometry of the scene, and nothing else."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from graft.errors import InputError
from graft.io.guards import read_xml
from graft.io.pieces import RawMesh, check_range, fan, merged
from graft.objects import Floats, Ints

MAX_NODES = 10_000
"""Nodes visited, instances counted each time: nodes that instance nodes could otherwise double
without end."""

MAX_DEPTH = 256
"""Nesting of nodes; exporters stay under twenty."""

UPS = {"X_UP": (1.0, 0.0, 0.0), "Y_UP": (0.0, 1.0, 0.0), "Z_UP": (0.0, 0.0, 1.0)}
"""up_axis -> direction; Y_UP where the file is silent (COLLADA 1.4.1, <up_axis>)."""


@dataclass
class _Scene:
    """What is read so far."""

    path: Path
    by_id: dict[str, Any]
    meshes: list[RawMesh] = field(default_factory=list)
    visits: int = 0


def read_dae(path: Path) -> tuple[list[RawMesh], tuple[float, float, float]]:
    """Read a COLLADA file: every node that instances a geometry is a mesh.

    The file's unit is applied. Its up axis is told and not applied, because the programs that show robot
    descriptions, for which most of these files are made, do not apply it either.

    Returns:
        The meshes, in metres, and the direction of up.
    """
    root = read_xml(path)
    for element in root.iter("{*}*"):  # one namespace for each version of COLLADA, none of which matters here
        element.tag = element.tag.rpartition("}")[2]
    if root.tag != "COLLADA":
        raise InputError(f"expected <COLLADA>, got <{root.tag}>", path=path)
    unit = root.find("asset/unit")
    metres = float(unit.get("meter", "1")) if unit is not None else 1.0
    up = (root.findtext("asset/up_axis") or "Y_UP").strip()
    if not (0 < metres < np.inf) or up not in UPS:
        raise InputError(f"asset: unit of {metres} metres, up axis {up!r}", path=path)
    frame = np.diag([metres, metres, metres, 1.0])
    by_id = {element.get("id"): element for element in root.iter() if element.get("id") is not None}
    scene = root.find("scene/instance_visual_scene")
    top = (
        _named(by_id, scene.get("url"), path) if scene is not None else root.find("library_visual_scenes/visual_scene")
    )
    if top is None:
        raise InputError("no visual_scene", path=path)
    found = _Scene(path, by_id)
    for node in top.findall("node"):
        _visit(node, frame, found, 0)
    if not found.meshes:
        raise InputError("no node of the scene holds triangles or polygons", path=path)
    return found.meshes, UPS[up]


def _named(by_id: dict[str, Any], url: str | None, path: Path) -> Any:
    """Return the element that `#id` means."""
    if url is None or not url.startswith("#") or url[1:] not in by_id:
        raise InputError(f"reference {url!r}: expected the id of an element of this file", path=path)
    return by_id[url[1:]]


def _visit(node: Any, parent: Floats, scene: _Scene, depth: int) -> None:
    path, by_id, meshes = scene.path, scene.by_id, scene.meshes
    scene.visits += 1
    if depth > MAX_DEPTH or scene.visits > MAX_NODES:
        raise InputError(f"line {node.sourceline}: nodes nest too deep, or in a circle", path=path)
    world = parent @ _transform(node, path)
    for instance in [*node.findall("instance_geometry"), *node.findall("instance_controller")]:
        geometry = _named(by_id, instance.get("url"), path)
        if geometry.tag == "controller":  # a skin: its mesh in the bind pose
            skin = geometry.find("skin")
            geometry = _named(by_id, None if skin is None else skin.get("source"), path)
        name = node.get("name") or geometry.get("name") or node.get("id") or geometry.get("id") or path.stem
        pieces = [_piece(name, p, by_id, path) for p in geometry.iterfind("mesh/*") if p.tag in _PRIMITIVES]
        if pieces:
            mesh = merged(name, pieces)
            faces = mesh.faces[:, ::-1] if np.linalg.det(world[:3, :3]) < 0 else mesh.faces
            meshes.append(RawMesh(name, mesh.vertices @ world[:3, :3].T + world[:3, 3], faces))
    for child in node.findall("node"):
        _visit(child, world, scene, depth + 1)
    for instance in node.findall("instance_node"):
        _visit(_named(by_id, instance.get("url"), path), world, scene, depth + 1)


def _numbers(element: Any, count: int | None, path: Path) -> Floats:
    """Return the numbers in an element's text."""
    try:
        values = np.array((element.text or "").split(), np.float64)
    except ValueError as error:
        raise InputError(f"line {element.sourceline}: <{element.tag}>: {error}", path=path) from None
    if count is not None and len(values) != count:
        raise InputError(
            f"line {element.sourceline}: <{element.tag}>: expected {count} numbers, got {len(values)}",
            path=path,
        )
    return values


def _transform(node: Any, path: Path) -> Floats:
    """Return (4, 4) T_parent_node: the transforms in the order they are written, the first outermost."""
    total = np.eye(4)
    for element in node:
        step = np.eye(4)
        if element.tag == "matrix":
            step = _numbers(element, 16, path).reshape(4, 4)
        elif element.tag == "translate":
            step[:3, 3] = _numbers(element, 3, path)
        elif element.tag == "scale":
            step[:3, :3] = np.diag(_numbers(element, 3, path))
        elif element.tag == "rotate":
            x, y, z, degrees = _numbers(element, 4, path)
            length = float(np.hypot(np.hypot(x, y), z))
            if not length > 0:
                raise InputError(f"line {element.sourceline}: <rotate>: expected an axis, got zero", path=path)
            skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) / length
            angle = np.radians(degrees)
            step[:3, :3] += np.sin(angle) * skew + (1 - np.cos(angle)) * skew @ skew
        else:
            continue
        if not np.isfinite(step).all():
            raise InputError(f"line {element.sourceline}: <{element.tag}> is not finite", path=path)
        total = total @ step
    return total


_PRIMITIVES = ("triangles", "polylist", "polygons")


def _piece(name: str, primitive: Any, by_id: dict[str, Any], path: Path) -> RawMesh:
    """Read one primitive: the corners' positions, by the interleaved index lists of COLLADA."""
    where = f"line {primitive.sourceline}: <{primitive.tag}>"
    inputs = primitive.findall("input")
    stride = max((int(i.get("offset", "0")) for i in inputs), default=0) + 1
    vertex = next((i for i in inputs if i.get("semantic") == "VERTEX"), None)
    if vertex is None:
        raise InputError(f"{where}: no VERTEX input", path=path)
    offset = int(vertex.get("offset", "0"))
    positions = _named(by_id, vertex.get("source"), path).findall("input")
    position = next((i for i in positions if i.get("semantic") == "POSITION"), None)
    source = _named(by_id, None if position is None else position.get("source"), path)
    array, accessor = source.find("float_array"), source.find("technique_common/accessor")
    if array is None:
        raise InputError(f"line {source.sourceline}: <source> has no float_array", path=path)
    width = int(accessor.get("stride", "3")) if accessor is not None else 3
    values = _numbers(array, None, path)
    if width < 3 or len(values) % width:
        raise InputError(f"line {array.sourceline}: {len(values)} numbers are no positions", path=path)
    vertices = values.reshape(-1, width)[:, :3]

    def corners(element: Any) -> Ints:
        indices = _numbers(element, None, path).astype(np.int64)
        if offset < 0 or len(indices) % stride:
            raise InputError(f"{where}: {len(indices)} indices for {stride} inputs", path=path)
        return indices.reshape(-1, stride)[:, offset]

    lists = [corners(p) for p in primitive.findall("p")]
    order = np.concatenate(lists) if lists else np.empty(0, np.int64)
    if primitive.tag == "triangles":
        if len(order) % 3:
            raise InputError(f"{where}: {len(order)} corners are no whole number of triangles", path=path)
        faces = order.reshape(-1, 3)
    elif primitive.tag == "polygons":
        faces, _ = fan([p.tolist() for p in lists])
    else:
        counts = primitive.find("vcount")
        sizes = np.empty(0, np.int64) if counts is None else _numbers(counts, None, path).astype(np.int64)
        if (sizes < 0).any() or sizes.sum() != len(order):
            raise InputError(f"{where}: vcount says {sizes.sum()} corners, there are {len(order)}", path=path)
        faces, _ = fan([p.tolist() for p in np.split(order, np.cumsum(sizes)[:-1])] if len(sizes) else [])
    check_range(faces, len(vertices), f"{name!r} face")
    return RawMesh(name, vertices, faces)

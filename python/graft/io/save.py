"""`save_object`: an object as GLB, which keeps everything, or as OBJ."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

from graft.errors import InputError
from graft.io.atomic import write_whole
from graft.io.gltf import EXTRAS_KEY, GRAFT_SCHEMA, POINTS, TRIANGLES, UP
from graft.io.gltf_buffers import CHUNK_BIN, CHUNK_JSON, MAGIC
from graft.io.pieces import has_area
from graft.objects import Floats, Joint, Part, PartObject

FLOAT, UINT = 5126, 5125
"""glTF component types of positions and indices."""

ARRAY_BUFFER, ELEMENT_BUFFER = 34962, 34963
"""glTF buffer view targets."""


def save_object(path: str | Path, obj: PartObject) -> None:
    """Write an object to a file that is complete or not there at all.

    GLB (.glb) keeps everything: names, labels, joints, up, scale, category, graspable parts, notes, in the
    `extras` of the root node. `graft.load_object` gives the object back, vertices rounded to float32, as glTF
    has no other, and without the faces that have no area then. The root node turns the object +Y up and scales
    it to metres, so that other programs show it as glTF wants it.

    OBJ (.obj) keeps the vertices to the last bit and the parts as objects called by their names, and nothing
    else.

    Args:
        path: Ends in .glb or .obj; folders on the way are made.
        obj: What to write.

    Raises:
        InputError: Another suffix, or a point cloud as OBJ.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == ".glb":
        data = glb_bytes(obj)
    elif suffix == ".obj":
        data = _obj_bytes(obj, path)
    else:
        raise InputError(f"cannot write {suffix!r}: expected .glb or .obj", path=path)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, data)


def glb_bytes(obj: PartObject) -> bytes:
    """Return an object as the bytes of a GLB file; see `save_object`."""
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []
    binary = bytearray()

    def add(array: np.ndarray[Any, Any], component: int, kind: str, target: int, **bounds: Any) -> int:
        data = array.tobytes()
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data), "target": target})
        binary.extend(data)
        accessors.append(
            {
                "bufferView": len(views) - 1,
                "componentType": component,
                "count": len(array),
                "type": kind,
                **bounds,
            }
        )
        return len(accessors) - 1

    def primitive(part: Part) -> dict[str, Any]:
        positions = part.vertices.astype("<f4")
        bounds = {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
        found: dict[str, Any] = {
            "attributes": {"POSITION": add(positions, FLOAT, "VEC3", ARRAY_BUFFER, **bounds)},
            "mode": POINTS if part.is_point_cloud else TRIANGLES,
        }
        if part.normals is not None:
            found["attributes"]["NORMAL"] = add(part.normals.astype("<f4"), FLOAT, "VEC3", ARRAY_BUFFER)
        if not part.is_point_cloud:
            # A sliver that is flat in single precision would be noticed and dropped by every reader.
            solid = has_area(positions.astype(np.float64), part.faces)
            faces = part.faces[solid] if solid.any() else part.faces
            found["indices"] = add(faces.ravel().astype("<u4"), UINT, "SCALAR", ELEMENT_BUFFER)
        return found

    meshes = [{"name": part.name, "primitives": [primitive(part)]} for part in obj.parts]
    nodes: list[dict[str, Any]] = [
        {
            "name": obj.name,
            "matrix": _to_gltf_frame(obj).T.ravel().tolist(),
            "children": list(range(1, len(obj.parts) + 1)),
            "extras": {EXTRAS_KEY: _object_words(obj)},
        }
    ]
    for index, part in enumerate(obj.parts):
        words = {"name": part.name, "label": part.label, "notes": list(part.notes)}
        nodes.append({"name": part.name, "mesh": index, "extras": {EXTRAS_KEY: words}})
    document = {
        "asset": {"version": "2.0", "generator": "graft"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "meshes": meshes,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    binary.extend(b"\0" * (-len(binary) % 4))
    length = 12 + 8 + len(text) + 8 + len(binary)
    return b"".join(
        (
            struct.pack("<4sII", MAGIC, 2, length),
            struct.pack("<II", len(text), CHUNK_JSON),
            text,
            struct.pack("<II", len(binary), CHUNK_BIN),
            bytes(binary),
        )
    )


def _object_words(obj: PartObject) -> dict[str, Any]:
    """Return what GLB has no place for."""

    def listed(array: Floats | None) -> list[float] | None:
        return None if array is None else array.tolist()

    def limits(joint: Joint) -> list[float | None] | None:
        return None if joint.limits is None else [float(v) if np.isfinite(v) else None for v in joint.limits]

    return {
        "schema": GRAFT_SCHEMA,
        "name": obj.name,
        "category": obj.category,
        "up": listed(obj.up),
        "scale_to_metres": obj.scale_to_metres,
        "graspable": list(obj.graspable),
        "notes": list(obj.notes),
        "joints": [
            {
                "parent": j.parent,
                "child": j.child,
                "kind": j.kind,
                "name": j.name,
                "axis": listed(j.axis),
                "origin": listed(j.origin),
                "limits": limits(j),
            }
            for j in obj.joints
        ],
    }


def _to_gltf_frame(obj: PartObject) -> Floats:
    """Return (4, 4) from the object frame to metres with +Y up, by the shortest turn; unturned without up."""
    matrix = np.eye(4)
    if obj.up is not None:
        up = np.asarray(obj.up)
        axis = np.cross(up, UP)
        sine, cosine = float(np.linalg.norm(axis)), float(up @ np.array(UP))
        if sine > 1e-12:
            x, y, z = axis / sine
            skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            matrix[:3, :3] += sine * skew + (1 - cosine) * skew @ skew
        elif cosine < 0:
            matrix[:3, :3] = np.diag([1.0, -1.0, -1.0])
    matrix[:3, :3] *= obj.scale_to_metres or 1.0
    return matrix


def _obj_bytes(obj: PartObject, path: Path) -> bytes:
    lines = []
    start = 1
    for part in obj.parts:
        if part.is_point_cloud:
            raise InputError(f"part {part.name!r} is a point cloud, which OBJ has no faces for: use .glb", path=path)
        lines.append(f"o {part.name}")
        lines.extend(f"v {x!r} {y!r} {z!r}" for x, y, z in part.vertices.tolist())
        lines.extend(f"f {a} {b} {c}" for a, b, c in (part.faces + start).tolist())
        start += len(part.vertices)
    return ("\n".join(lines) + "\n").encode()

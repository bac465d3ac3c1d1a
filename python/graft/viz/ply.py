"""`save_ply`: parts as labels and colours of a PLY file, which MeshLab, CloudCompare and `load_object` read."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from graft.errors import InputError
from graft.io.atomic import write_whole
from graft.objects import PartObject
from graft.viz.colors import part_colors
from graft.viz.files import check_output

_POINT = [("xyz", "<f8", 3)]
_TRIANGLE = [("count", "u1"), ("corners", "<i4", 3)]
_PART = [("label", "<i4"), ("rgb", "u1", 3)]

_PART_HEADER = ["property int label", *(f"property uchar {name}" for name in ("red", "green", "blue"))]
_POINT_HEADER = [f"property double {axis}" for axis in "xyz"]


def save_ply(path: str | Path, obj: PartObject) -> None:
    """Write an object as one binary PLY; every face, or point of a cloud, has its part's number and colour.

    Args:
        path: Ends in .ply.
        obj: Meshes only or clouds only; names, joints and normals are not kept.

    Raises:
        InputError: Both kinds at once, or the file cannot be written.
    """
    path = check_output(path, ".ply")
    clouds = [part.is_point_cloud for part in obj.parts]
    if any(clouds) and not all(clouds):
        raise InputError("meshes and point clouds at once: use .glb", path=path)
    vertices = np.concatenate([part.vertices for part in obj.parts])
    sizes = [len(part.vertices if part.is_point_cloud else part.faces) for part in obj.parts]
    labels = np.repeat(np.arange(len(obj.parts)), sizes)
    colors = part_colors(len(obj.parts))[labels]
    header = ["ply", "format binary_little_endian 1.0", "comment graft parts", f"element vertex {len(vertices)}"]
    if all(clouds):
        points = np.empty(len(vertices), [*_POINT, *_PART])
        points["xyz"], points["label"], points["rgb"] = vertices, labels, colors
        header += [*_POINT_HEADER, *_PART_HEADER]
        body = points.tobytes()
    else:
        starts = np.cumsum([0, *(len(part.vertices) for part in obj.parts[:-1])])
        faces = np.empty(len(labels), [*_TRIANGLE, *_PART])
        faces["count"], faces["label"], faces["rgb"] = 3, labels, colors
        faces["corners"] = np.concatenate([part.faces + n for part, n in zip(obj.parts, starts, strict=True)])
        header += [
            *_POINT_HEADER,
            f"element face {len(faces)}",
            "property list uchar int vertex_indices",
            *_PART_HEADER,
        ]
        body = np.ascontiguousarray(vertices, "<f8").tobytes() + faces.tobytes()
    write_whole(path, ("\n".join([*header, "end_header"]) + "\n").encode() + body)

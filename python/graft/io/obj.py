"""Wavefront OBJ: its objects and groups are the parts. Materials and textures are not read.

Read here and not through trimesh, which merges by material by default and so loses the groups.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from graft.errors import InputError
from graft.io.guards import read_text, resolve_inside
from graft.io.pieces import RawMesh, check_range, fan
from graft.io.text import number_rows


def read_obj(path: Path) -> list[RawMesh]:
    """Read an OBJ file; every `o` and every `g` that has faces is a mesh, in the order of their first face.

    A group is called by its name, or by object and group where two objects have a group of that name. Faces
    that come under the same object and group again belong to the same mesh. A material library outside the
    file's folder is refused, although none is opened. A file of vertices without faces is a point cloud.
    """
    vertex_lines: list[str] = []
    vertex_numbers: list[int] = []
    polygons: dict[tuple[str, str], list[list[int]]] = {}
    here = ("", "")
    current: list[list[int]] | None = None
    text = read_text(path)
    if "\\\n" in text:
        text = text.replace("\\\n", " ")
    for number, line in enumerate(text.splitlines(), start=1):
        keyword, _, rest = line.strip().partition(" ")
        if keyword == "v":
            vertex_lines.append(rest)
            vertex_numbers.append(number)
        elif keyword == "f":
            if current is None:
                current = polygons.setdefault(here, [])
            current.append(_corners(rest, len(vertex_lines), number, path))
        elif keyword == "o":
            here, current = (rest.strip(), ""), None
        elif keyword == "g":
            here, current = (here[0], " ".join(rest.split())), None
        elif keyword == "mtllib":
            resolve_inside(rest, root=path.parent, path=path)
    if not vertex_lines:
        raise InputError("no vertices: expected lines that begin with v", path=path)
    # x y z [w], or x y z r g b as scanners write
    if len({len(line.split()) for line in vertex_lines}) > 1:
        vertex_lines = [" ".join(line.split()[:3]) for line in vertex_lines]
    try:
        vertices = number_rows(vertex_lines, first_line=vertex_numbers, least=3)[:, :3]
    except InputError as error:
        raise InputError(str(error), path=path) from None
    if not polygons:
        return [RawMesh(path.stem, vertices)]

    groups = [group for _, group in polygons]
    meshes = []
    for (obj, group), corners in polygons.items():
        shared = group and obj and groups.count(group) > 1
        name = f"{obj}_{group}" if shared else group or obj or path.stem
        faces, origin = fan(corners)
        try:
            check_range(faces, len(vertices), f"{name!r} face")
        except InputError as error:
            raise InputError(str(error), path=path) from None
        used, index = np.unique(faces, return_inverse=True)
        meshes.append(RawMesh(name, vertices[used], index.reshape(-1, 3), polygon=origin))
    return meshes


def _corners(rest: str, n_vertices: int, number: int, path: Path) -> list[int]:
    """Return the vertex indices, from 0, of a face line `a/b/c d/e/f ..`; negative ones count backwards."""
    try:
        indices = [int(word.partition("/")[0]) for word in rest.split()]
    except ValueError:
        raise InputError(f"line {number}: expected a face of vertex numbers, got {rest[:60]!r}", path=path) from None
    if 0 in indices:
        raise InputError(f"line {number}: vertex number 0; they count from 1", path=path)
    if len(indices) < 3:
        raise InputError(f"line {number}: expected at least 3 corners, got {len(indices)}", path=path)
    return [i - 1 if i > 0 else n_vertices + i if n_vertices + i >= 0 else -1 for i in indices]

"""OFF, with the optional normals and colours of NOFF and COFF."""

from __future__ import annotations

import re
from pathlib import Path

from graft.errors import InputError
from graft.io.guards import read_text
from graft.io.pieces import RawMesh, check_range, fan
from graft.io.text import number_rows, ragged_rows

_MAGIC = re.compile(r"(ST)?(C)?(N)?OFF\b")


def read_off(path: Path) -> list[RawMesh]:
    """Read an OFF file: one mesh, polygons cut into fans."""
    lines, numbers = [], []
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        kept = line.partition("#")[0].strip()
        if kept:
            lines.append(kept)
            numbers.append(number)
    magic = _MAGIC.match(lines[0]) if lines else None
    if magic is None:
        raise InputError("line 1: expected OFF", path=path)
    lines[0] = lines[0][magic.end() :].strip()
    if not lines[0]:
        lines, numbers = lines[1:], numbers[1:]
    counts = lines[0].split() if lines else []
    if len(counts) not in (2, 3) or not all(word.isdecimal() for word in counts):
        raise InputError("expected the numbers of vertices, faces and edges after OFF", path=path)
    n_vertices, n_faces = int(counts[0]), int(counts[1])
    if n_vertices + n_faces > len(lines) - 1:
        raise InputError(
            f"the header says {n_vertices} vertices and {n_faces} faces; {len(lines) - 1} lines follow",
            path=path,
        )
    try:
        table = number_rows(lines[1 : 1 + n_vertices], first_line=numbers[1:], least=3)
        polygons = ragged_rows(lines[1 + n_vertices : 1 + n_vertices + n_faces], first_line=numbers[1 + n_vertices :])
    except InputError as error:
        raise InputError(str(error), path=path) from None
    faces, origin = fan(polygons)
    check_range(faces, n_vertices)
    normals = table[:, 3:6] if magic[3] and table.shape[1] >= 6 else None
    return [RawMesh(path.stem, table[:, :3], faces, polygon=origin, normals=normals)]

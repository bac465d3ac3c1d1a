"""Point clouds and meshes in text tables and NumPy archives."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from graft.errors import InputError
from graft.io.arrays import read_npz
from graft.io.guards import read_text
from graft.io.pieces import RawMesh, check_range
from graft.io.sidecar import LABEL_KEYS, label_array, whole_numbers
from graft.io.text import number_rows

TEXT_SUFFIXES = (".txt", ".xyz", ".pts", ".csv")
"""Of tables of points."""

MEANINGS = {3: "x y z", 4: "x y z label", 6: "x y z nx ny nz", 7: "x y z nx ny nz label"}
"""What the columns of a table are, by their number (ShapeNetPart has seven)."""


def read_text_cloud(path: Path) -> list[RawMesh]:
    """Read a table of points, one a line, columns as in `MEANINGS`; # and // begin comments."""
    kept = [
        (number, line)
        for number, line in enumerate(read_text(path).splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith(("#", "//"))
    ]
    if not kept:
        raise InputError("no points", path=path)
    table = number_rows([line for _, line in kept], first_line=[number for number, _ in kept], least=3)
    columns = table.shape[1]
    if columns not in MEANINGS:
        meanings = ", ".join(f"{n} ({what})" for n, what in MEANINGS.items())
        raise InputError(f"{columns} columns: expected {meanings}", path=path)
    normals = table[:, 3:6] if columns >= 6 else None
    labels = whole_numbers(table[:, -1], path) if columns in (4, 7) else None
    return [RawMesh(path.stem, table[:, :3], normals=normals, vertex_labels=labels)]


def read_npz_mesh(path: Path) -> list[RawMesh]:
    """Read an archive of `points` or `vertices`, and where it has them `faces`, `normals`, `labels`."""
    arrays = read_npz(path)
    key = next((k for k in ("vertices", "points", "xyz") if k in arrays), None)
    if key is None:
        raise InputError(f"no array called vertices or points among {', '.join(arrays) or 'none'}", path=path)
    points = arrays[key]
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "iuf" or not len(points):
        raise InputError(f"{key}: expected shape (n, 3), got {points.shape} of {points.dtype}", path=path)
    faces = arrays.get("faces", np.empty((0, 3), np.int64))
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
        raise InputError(f"faces: expected integers of shape (f, 3), got {faces.shape} of {faces.dtype}", path=path)
    faces = faces.astype(np.int64)
    check_range(faces, len(points))
    normals = arrays.get("normals")
    if normals is not None and (normals.shape != points.shape or normals.dtype.kind != "f"):
        raise InputError(f"normals: expected shape {points.shape}, got {normals.shape}", path=path)
    labels = whole_numbers(label_array(arrays, path), path) if any(k in arrays for k in LABEL_KEYS) else None
    return [
        RawMesh(
            path.stem,
            points.astype(np.float64),
            faces,
            normals=None if normals is None else normals.astype(np.float64),
            vertex_labels=None if len(faces) else labels,
            face_labels=labels if len(faces) else None,
        )
    ]

"""STL: binary, and ASCII with one or several solids."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from graft.errors import InputError
from graft.io.guards import read_bytes
from graft.io.pieces import RawMesh
from graft.objects import Floats, Ints

HEADER_BYTES = 84
"""Eighty bytes of comment and a uint32 count."""

RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""One binary triangle, 50 bytes."""

_SOLID = re.compile(rb"^[ \t]*solid\b[ \t]*([^\r\n]*)", re.MULTILINE)
_VERTEX = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)")


def read_stl(path: Path) -> list[RawMesh]:
    """Read an STL file; every solid of an ASCII file is a mesh. Corners at equal places become one vertex.

    The normals in the file are not read: the order of the corners tells the side.
    """
    data = read_bytes(path)
    records, rest = divmod(len(data) - HEADER_BYTES, RECORD.itemsize)
    stated = int.from_bytes(data[80:HEADER_BYTES], "little") if len(data) >= HEADER_BYTES else None
    if stated is not None and rest == 0 and records == stated:
        if stated == 0:
            raise InputError("the file has 0 triangles", path=path)
        corners = np.frombuffer(data, RECORD, offset=HEADER_BYTES)["corners"].reshape(-1, 3)
        return [_welded(path.stem, corners.astype(np.float64))]
    if data.lstrip()[:5].lower() == b"solid" and b"\0" not in data[:HEADER_BYTES]:
        return _ascii(data, path)
    if stated is None:
        raise InputError(f"truncated: {len(data)} bytes, an STL header alone has {HEADER_BYTES}", path=path)
    raise InputError(
        f"the header says {stated} triangles, which need {HEADER_BYTES + RECORD.itemsize * stated} bytes; "
        f"the file has {len(data)}",
        path=path,
    )


def _ascii(data: bytes, path: Path) -> list[RawMesh]:
    starts = list(_SOLID.finditer(data))
    meshes = []
    for index, start in enumerate(starts):
        body = data[start.end() : starts[index + 1].start() if index + 1 < len(starts) else len(data)]
        name = start[1].decode("utf-8", errors="replace").strip() or path.stem
        if b"endsolid" not in body:
            raise InputError(f"solid {name!r} is truncated: no endsolid", path=path)
        rows = _VERTEX.findall(body)
        facets = body.count(b"endfacet")
        if len(rows) != 3 * facets:
            raise InputError(f"solid {name!r}: {facets} facets but {len(rows)} vertices", path=path)
        if not rows:
            continue
        try:
            corners = np.array(rows).astype(np.float64)
        except ValueError as error:
            raise InputError(f"solid {name!r}: a vertex is not three numbers: {error}", path=path) from None
        meshes.append(_welded(name, corners))
    if not meshes:
        raise InputError("the file has 0 triangles", path=path)
    return meshes


def _welded(name: str, corners: Floats) -> RawMesh:
    """Make a mesh of (3 f, 3) corners, one vertex for each place; vertices in the order they first appear."""
    places = np.ascontiguousarray(corners + 0.0)  # -0 and 0 are the same place
    keys = places.view(np.dtype((np.void, places.dtype.itemsize * 3))).ravel()
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")
    rank: Ints = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return RawMesh(name, places[first[order]], rank[inverse.reshape(-1, 3)])

"""PLY: ASCII and binary of either byte order, with labels of faces or points."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from graft.errors import InputError
from graft.io.guards import read_bytes
from graft.io.pieces import RawMesh, check_range, fan
from graft.io.text import number_rows
from graft.objects import Floats, Ints

TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2"},
    **{"int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8"},
}
"""PLY's names of types, old and new."""

LABELS = (
    "label",
    "labels",
    "part",
    "part_id",
    "part_label",
    "seg",
    "segment",
    "segmentation",
    "scalar_label",
)
"""Properties that number the part of a face or point, compared in lower case; the last is CloudCompare's."""

CORNERS = ("vertex_indices", "vertex_index")
"""Names of the list of a face's corners."""

ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass
class _Property:
    name: str
    kind: str
    counted_by: str | None = None


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


Columns = dict[str, Any]
"""Property name -> (n,) array, or a list of n lists for list properties of varying length, or (n, k) for
constant."""


def read_ply(path: Path) -> list[RawMesh]:
    """Read a PLY file: one mesh or point cloud, polygons cut into fans."""
    data = read_bytes(path)
    order, elements, start, n_lines = _header(data, path)
    columns = (
        _ascii(data[start:], elements, n_lines, path) if order == "" else _binary(data, start, order, elements, path)
    )
    return [_mesh(columns, elements, path)]


def _header(data: bytes, path: Path) -> tuple[str, list[_Element], int, int]:
    """Return byte order, elements, where the data starts, and how many lines the header has."""
    if data[:3] != b"ply":
        raise InputError(f"expected a file that begins with ply, got {data[:8]!r}", path=path)
    end = data.find(b"end_header")
    stop = data.find(b"\n", end)
    if end < 0 or stop < 0:
        raise InputError("truncated: the header has no end_header", path=path)
    order: str | None = None
    elements: list[_Element] = []
    lines = data[:end].decode("utf-8", errors="replace").splitlines()
    for number, line in enumerate(lines, start=1):
        match line.split():
            case ["format", kind, _] if kind in ORDERS:
                order = ORDERS[kind]
            case ["element", name, count] if count.isdecimal():
                elements.append(_Element(name, int(count)))
            case ["property", "list", counted, kind, name] if elements and counted in TYPES and kind in TYPES:
                elements[-1].properties.append(_Property(name, TYPES[kind], TYPES[counted]))
            case ["property", kind, name] if elements and kind in TYPES:
                elements[-1].properties.append(_Property(name, TYPES[kind]))
            case ["ply"] | ["comment", *_] | ["obj_info", *_] | []:
                pass
            case _:
                raise InputError(f"line {number}: not a PLY header line: {line.strip()[:60]!r}", path=path)
    if order is None:
        raise InputError(f"the header names no format of {', '.join(ORDERS)}", path=path)
    return order, elements, stop + 1, len(lines) + 1


def _short(element: _Element, path: Path, has: str) -> InputError:
    return InputError(f"the header says {element.count} of element {element.name!r}; the file has {has}", path=path)


def _binary(data: bytes, start: int, order: str, elements: list[_Element], path: Path) -> dict[str, Columns]:
    tables: dict[str, Columns] = {}
    for element in elements:
        if not element.properties or element.count == 0:
            tables[element.name] = {}
            continue
        found = _constant_rows(data, start, order, element)
        if found is None and not any(p.counted_by for p in element.properties):
            size = sum(np.dtype(p.kind).itemsize for p in element.properties)
            raise _short(element, path, f"room for {(len(data) - start) // size}")
        tables[element.name], start = found or _varying_rows(data, start, order, element, path)
    return tables


def _constant_rows(data: bytes, start: int, order: str, element: _Element) -> tuple[Columns, int] | None:
    """Read rows at once when every list is as long as in the first row; None when that is not so."""
    fields: list[tuple[Any, ...]] = []
    offset = start
    lengths: dict[str, int] = {}
    for p in element.properties:
        if p.counted_by:
            count_type = np.dtype(order + p.counted_by)
            if offset + count_type.itemsize > len(data):
                return None
            length = int(np.frombuffer(data, count_type, 1, offset)[0])
            lengths[p.name] = length
            if not 0 <= length <= len(data):
                return None
            fields.append((f"{p.name} length", count_type))
            fields.append((p.name, order + p.kind, (length,)))
            offset += count_type.itemsize + length * np.dtype(p.kind).itemsize
        else:
            fields.append((p.name, order + p.kind))
            offset += np.dtype(p.kind).itemsize
    if element.count * (offset - start) > len(data) - start:
        return None
    rows = np.frombuffer(data, np.dtype(fields), element.count, start)
    if any((rows[f"{name} length"] != length).any() for name, length in lengths.items()):
        return None
    return {p.name: rows[p.name] for p in element.properties}, start + rows.nbytes


def _varying_rows(data: bytes, start: int, order: str, element: _Element, path: Path) -> tuple[Columns, int]:
    """Read rows one by one; stops at the end of the file, whatever the header says."""
    columns: dict[str, list[Any]] = {p.name: [] for p in element.properties}
    kinds = [
        (columns[p.name], np.dtype(order + p.kind), np.dtype(order + p.counted_by) if p.counted_by else None)
        for p in element.properties
    ]
    offset = start
    for row in range(element.count):
        for column, kind, counted in kinds:
            length = 1
            if counted is not None:
                if offset + counted.itemsize > len(data):
                    raise _short(element, path, str(row))
                length = int(np.frombuffer(data, counted, 1, offset)[0])
                offset += counted.itemsize
            if length < 0 or offset + length * kind.itemsize > len(data):
                raise _short(element, path, str(row))
            values = np.frombuffer(data, kind, length, offset).tolist()
            column.append(values if counted is not None else values[0])
            offset += length * kind.itemsize
    return {p.name: columns[p.name] if p.counted_by else np.array(columns[p.name]) for p in element.properties}, offset


def _ascii(body: bytes, elements: list[_Element], n_lines: int, path: Path) -> dict[str, Columns]:
    lines = body.decode("utf-8", errors="replace").splitlines()
    tables: dict[str, Columns] = {}
    start = 0
    for element in elements:
        if element.count > len(lines) - start:
            raise _short(element, path, f"{len(lines) - start} more lines")
        chosen = lines[start : start + element.count]
        first = n_lines + start + 1
        start += element.count
        if not chosen or not element.properties:
            tables[element.name] = {}
        elif any(p.counted_by for p in element.properties):
            tables[element.name] = _ascii_lists(chosen, element, first, path)
        else:
            table = number_rows(chosen, first_line=first, least=len(element.properties))
            tables[element.name] = {p.name: table[:, i] for i, p in enumerate(element.properties)}
    return tables


def _ascii_lists(lines: list[str], element: _Element, first: int, path: Path) -> Columns:
    columns: dict[str, list[Any]] = {p.name: [] for p in element.properties}
    for row, line in enumerate(lines):
        words = iter(line.split())
        try:
            for p in element.properties:
                as_number = float if p.kind.startswith("f") else int
                if p.counted_by:
                    columns[p.name].append([as_number(next(words)) for _ in range(int(next(words)))])
                else:
                    columns[p.name].append(as_number(next(words)))
        except (StopIteration, RuntimeError, ValueError):
            raise InputError(
                f"line {first + row}: not a row of element {element.name!r}: {line.strip()[:60]!r}", path=path
            ) from None
    return {p.name: columns[p.name] if p.counted_by else np.array(columns[p.name]) for p in element.properties}


def _mesh(tables: dict[str, Columns], elements: list[_Element], path: Path) -> RawMesh:
    vertex = tables.get("vertex", {})
    if not all(axis in vertex for axis in "xyz"):
        raise InputError("no vertices: expected element vertex with properties x, y and z", path=path)
    if any(element.name == "tristrips" and element.count for element in elements):
        raise InputError("triangle strips are not read: save the mesh with faces", path=path)
    vertices = _stacked(vertex, ("x", "y", "z"))
    normals = _stacked(vertex, ("nx", "ny", "nz")) if all(n in vertex for n in ("nx", "ny", "nz")) else None
    face = tables.get("face", {})
    corners = next((face[name] for name in CORNERS if name in face), None)
    if face and corners is None:
        raise InputError(f"element 'face' has no list {' or '.join(CORNERS)}", path=path)
    faces: Ints = np.empty((0, 3), np.int64)
    origin = None
    if isinstance(corners, np.ndarray) and corners.ndim == 2 and corners.shape[1] == 3:
        faces = corners.astype(np.int64)
    elif corners is not None:
        rows = corners.tolist() if isinstance(corners, np.ndarray) else corners
        faces, origin = fan([[int(i) for i in row] for row in rows])
    check_range(faces, len(vertices))
    return RawMesh(
        path.stem,
        vertices,
        faces,
        polygon=origin,
        normals=normals,
        vertex_labels=_labels(vertex, "vertex", path),
        face_labels=_labels(face, "face", path),
    )


def _stacked(columns: Columns, names: tuple[str, ...]) -> Floats:
    return np.stack([np.asarray(columns[name], np.float64) for name in names], axis=1)


def _labels(columns: Columns, what: str, path: Path) -> Ints | None:
    found = {name.lower(): name for name in columns}
    name = next((found[label] for label in LABELS if label in found), None)
    if name is None:
        return None
    values = np.asarray(columns[name], np.float64)
    if values.ndim != 1 or not np.isfinite(values).all() or (values != np.round(values)).any():
        raise InputError(f"property {name!r} of element {what!r}: expected whole numbers", path=path)
    return values.astype(np.int64)

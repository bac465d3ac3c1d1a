"""The four tables of a segment and what their columns are.

bounds   rows are blocks of 32 parts side by side, what every query reads of every part
parts    rows are parts: what the solver reads of a part
graphs   rows are objects: ids, names, what filters look at, structures, where the rest lies
objects  rows are objects: meshes, samples, contact, names, metadata; read for the matches only

The first three hold one record batch each, whose columns go to the core as they lie in the file. Every object is a
record batch of its own, whose place and checksum are in `graphs`: it is read without looking at the rest of the file,
which need not be whole (pyarrow aborts on some files that are not).
"""

from __future__ import annotations

import secrets
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from graft.errors import InputError
from graft.library.files import FileEntry, HashingFile, discard, map_file, write_new
from graft.library.manifest import SegmentEntry
from graft.objects import Floats
from graft.transport.packed import LANES, side_by_side

TABLES = ("bounds", "parts", "graphs", "objects")

BUFFER = 1 << 20
"""Bytes that are collected before they are written."""

FLOATS = pa.large_list(pa.float64())
BYTES = pa.large_list(pa.uint8())

GRAPHS = pa.schema(
    [
        ("id", pa.binary(16)),
        ("name", pa.large_string()),
        ("category", pa.large_string()),
        ("licence", pa.large_string()),
        ("tags", pa.list_(pa.string())),
        ("gripper_width", pa.float64()),
        ("source", pa.large_string()),
        ("part", pa.int64()),
        ("flags", BYTES),
        ("structure", FLOATS),
        ("start", pa.int64()),
        ("length", pa.int64()),
        ("checksum", pa.uint64()),
    ]
)
"""`flags` has a number a part, so that its offsets are where every graph's parts begin; `start` and `length` say which
bytes of the file of `objects` are the object, `checksum` is their xxh3-64."""

PLACES = ("start", "length", "checksum")

OBJECT_ARRAYS: dict[str, pa.DataType] = {
    "vertices": FLOATS,
    "normals": FLOATS,
    "vertex_counts": pa.large_list(pa.int64()),
    "faces": pa.large_list(pa.int32()),
    "face_counts": pa.large_list(pa.int64()),
    "sweeps": pa.large_list(pa.int64()),
    "trajectory": BYTES,
    "centers": FLOATS,
    "axes": FLOATS,
    "half_extents": FLOATS,
    "areas": FLOATS,
    "gaps": FLOATS,
    "adjacency": BYTES,
    "points": FLOATS,
    "point_normals": FLOATS,
}
"""Columns of `objects` beside `document`, flat."""

OBJECTS = pa.schema([("document", pa.large_string()), *OBJECT_ARRAYS.items()])

_NOTHING = pa.RecordBatch.from_arrays([pa.array([], field.type) for field in OBJECTS], schema=OBJECTS)

REMOVED = pa.schema([("row", pa.int64())])


@dataclass(frozen=True, eq=False)
class PartColumns:
    """What `parts` holds, for p parts: see `PackedGraphs`; hops are steps from the demonstrated part."""

    extents: Floats
    relations: Floats
    descriptors: Floats | None
    masses: Floats
    hops: NDArray[np.int32]


def fixed(values: NDArray[Any], width: int) -> pa.FixedSizeListArray:
    """Return numbers as a column of rows of `width` numbers."""
    return pa.FixedSizeListArray.from_arrays(pa.array(np.ascontiguousarray(values).reshape(-1)), width)


def ragged(kind: pa.DataType, rows: Iterable[NDArray[Any]]) -> pa.LargeListArray:
    """Return arrays of any length as a column of lists."""
    flat = [np.ascontiguousarray(row).reshape(-1) for row in rows]
    offsets = np.concatenate(([0], np.cumsum([len(row) for row in flat], dtype=np.int64)))
    values = np.concatenate(flat) if flat else np.empty(0)
    return pa.LargeListArray.from_arrays(pa.array(offsets), pa.array(values, kind.value_type))


def single(kind: pa.DataType, row: NDArray[Any]) -> pa.LargeListArray:
    """Return one array as a column of one list."""
    return pa.LargeListArray.from_arrays(pa.array([0, row.size], pa.int64()), pa.array(row, kind.value_type))


def parts_batch(columns: PartColumns) -> pa.RecordBatch:
    """Return the `parts` table."""
    arrays = {"extents": fixed(columns.extents, 3), "relations": fixed(columns.relations, columns.relations.shape[1])}
    if columns.descriptors is not None:
        arrays["descriptors"] = fixed(columns.descriptors, columns.descriptors.shape[1])
    arrays |= {"masses": pa.array(columns.masses), "hops": pa.array(columns.hops)}
    return pa.RecordBatch.from_pydict(arrays)


def bounds_batch(columns: PartColumns) -> pa.RecordBatch:
    """Return the `bounds` table, laid out as the core reads it."""
    extents = side_by_side(columns.extents)
    features = side_by_side(columns.descriptors, columns.relations)
    masses = side_by_side(columns.masses[:, None])
    width = len(features) // (len(masses) // LANES)
    return pa.RecordBatch.from_pydict(
        {"extents": fixed(extents, 3 * LANES), "features": fixed(features, width), "masses": fixed(masses, LANES)}
    )


def write_table(path: Path, schema: pa.Schema, batches: Iterable[pa.RecordBatch]) -> FileEntry:
    """Write an Arrow IPC file, flushed to the disk."""

    def write(sink: HashingFile) -> None:
        with pa.PythonFile(sink, "w") as file, pa.ipc.new_file(file, schema) as writer:
            for batch in batches:
                writer.write_batch(batch)

    return write_new(path, write)


def write_objects(path: Path, objects: Iterable[pa.RecordBatch]) -> tuple[FileEntry, pa.RecordBatch]:
    """Write objects, one record batch each; return the file's entry and the columns `PLACES`."""
    places: list[tuple[int, int, int]] = []

    def write(sink: HashingFile) -> None:
        with (
            pa.PythonFile(sink, "w") as file,
            pa.BufferedOutputStream(file, BUFFER) as stream,
            pa.ipc.new_file(stream, OBJECTS) as writer,
        ):
            # The writer puts the schema before its first batch; an empty one leaves the first object alone.
            writer.write_batch(_NOTHING)
            for batch in objects:
                stream.flush()
                start, _ = sink.tell(), sink.mark()
                writer.write_batch(batch)
                stream.flush()
                places.append((start, sink.tell() - start, sink.mark()))

    entry = write_new(path, write)
    schema = pa.schema([GRAPHS.field(name) for name in PLACES])
    columns = [pa.array([place[i] for place in places], schema.types[i]) for i in range(len(PLACES))]
    return entry, pa.RecordBatch.from_arrays(columns, schema=schema)


def write_segment(
    folder: Path, parts: PartColumns, graphs: pa.RecordBatch, objects: Iterable[pa.RecordBatch]
) -> SegmentEntry:
    """Write the files of a segment; the folder itself is not flushed yet.

    Args:
        folder: For segments.
        parts: Of all objects.
        graphs: The columns of `GRAPHS`, `PLACES` aside.
        objects: The same objects, one record batch each.

    Raises:
        InputError: The system refuses; no file is left then.
    """
    name = secrets.token_hex(8)
    paths = {table: folder / f"{name}.{table}.arrow" for table in TABLES}
    try:
        entry, places = write_objects(paths["objects"], objects)
        columns = [(places if f in PLACES else graphs)[f] for f in GRAPHS.names]
        one = {
            "graphs": pa.RecordBatch.from_arrays(columns, schema=GRAPHS),
            "parts": parts_batch(parts),
            "bounds": bounds_batch(parts),
        }
        files = {table: write_table(paths[table], batch.schema, [batch]) for table, batch in one.items()}
    except BaseException:
        for path in paths.values():
            discard(path)
        raise
    return SegmentEntry(name, len(graphs), len(parts.masses), {"objects": entry, **files})


def open_table(folder: Path, entry: FileEntry, *, check: bool) -> pa.ipc.RecordBatchFileReader:
    """Map a table.

    Raises:
        InputError: Its file is missing or damaged.
    """
    buffer = map_file(folder, entry, check=check)
    try:
        return pa.ipc.open_file(pa.BufferReader(buffer))
    except (pa.ArrowException, OSError) as error:
        raise InputError(f"damaged: {error}", path=folder / entry.name) from None


def read_only_batch(folder: Path, entry: FileEntry) -> pa.RecordBatch:
    """Map a table of one batch, its checksum checked."""
    reader = open_table(folder, entry, check=True)
    if reader.num_record_batches != 1:
        raise InputError(f"expected one record batch, got {reader.num_record_batches}", path=folder / entry.name)
    return reader.get_batch(0)


def numbers(column: pa.Array) -> NDArray[Any]:
    """Return a column of numbers, or the flat numbers of a column of lists, as they lie in the file."""
    while not pa.types.is_primitive(column.type):
        column = column.values
    flat: NDArray[Any] = column.to_numpy(zero_copy_only=True)
    return flat

"""Libraries in formats that other programs read."""

from __future__ import annotations

import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from graft.errors import InputError, MissingExtraError
from graft.library.segment import Segment
from graft.library.store import Snapshot, rows_of
from graft.library.tables import FLOATS, GRAPHS, OBJECTS, PLACES, ragged

TableFormat = Literal["parquet", "lance"]

PART_COLUMNS = ("extents", "relations", "descriptors", "masses")
"""Numbers of every part, flat, a row per object."""

TOGETHER = 64
"""Objects that are written at a time."""

SCHEMA = pa.schema(
    [field for field in GRAPHS if field.name not in PLACES] + [(n, FLOATS) for n in PART_COLUMNS] + list(OBJECTS)
)
"""One row per object: what is known of it, its part graph, and its meshes; arrays are flat."""


def export_table(snapshot: Snapshot, path: str | Path, form: TableFormat) -> int:
    """Write a version's objects as one Parquet file or one Lance data set; return how many.

    Raises:
        InputError: There is something at `path`, a segment is damaged, or the system refuses.
        MissingExtraError: Lance is wanted and not installed.
    """
    path = Path(path)
    if path.exists():
        raise InputError("it exists, nothing is written", path=path)
    lance = _lance() if form == "lance" else None
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if lance is not None:
            lance.write_dataset(pa.RecordBatchReader.from_batches(SCHEMA, _batches(snapshot)), str(draft))
        else:
            with pq.ParquetWriter(str(draft), SCHEMA) as writer:
                for batch in _batches(snapshot):
                    writer.write_batch(batch)
        draft.rename(path)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", path=path) from error
    finally:
        if draft.is_dir():
            shutil.rmtree(draft)
        draft.unlink(missing_ok=True)
    return snapshot.manifest.objects


def _lance() -> Any:
    try:
        import lance
    except ImportError:
        raise MissingExtraError("export to Lance", package="pylance", extra="lance") from None
    return lance


def _batches(snapshot: Snapshot) -> Iterator[pa.RecordBatch]:
    for segment in snapshot.segments:
        rows = rows_of(segment)
        for first in range(0, len(rows), TOGETHER):
            own = rows[first : first + TOGETHER]
            graphs = segment.graphs.take(pa.array(own))
            known = [graphs[field.name] for field in GRAPHS if field.name not in PLACES]
            parts = [_parts(segment, name, own) for name in PART_COLUMNS]
            objects = pa.concat_batches([segment.object_batch(row) for row in own.tolist()])
            yield pa.RecordBatch.from_arrays([*known, *parts, *objects], schema=SCHEMA)


def _parts(segment: Segment, name: str, rows: np.ndarray[Any, np.dtype[np.int64]]) -> pa.Array:
    """Return a column of `parts` with one list per object; empty lists where there are no descriptors."""
    column = getattr(segment.parts, name)
    ends = zip(segment.offsets[rows], segment.offsets[rows + 1], strict=True)
    return ragged(FLOATS, [np.empty(0) if column is None else column[a:b] for a, b in ends])

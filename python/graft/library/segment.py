"""One segment of a library on disk, mapped into memory when it is first looked at.

Whatever a query reads of all objects is compared with its checksum once, when it is first touched; the object of a
match is compared with its row's checksum whenever it is read.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from graft.errors import InputError
from graft.graph import PartGraph
from graft.library.decode import demonstration_of, graph_of, parse_document
from graft.library.encode import Arrays, row_checksum
from graft.library.manifest import SegmentEntry
from graft.library.tables import OBJECT_ARRAYS, PartColumns, numbers, open_table, read_only_batch
from graft.objects import Demonstration, Floats, Ints
from graft.transport import UFGW, PackedGraphs
from graft.transport.packed import side_by_side


@dataclass(frozen=True, eq=False)
class Segment:
    """A segment's data.

    Attributes:
        folder: Where its files lie.
        entry: What the manifest says of it.
        descriptor: Name of its descriptors, or None.
        saliency: gamma of its masses.
    """

    folder: Path
    entry: SegmentEntry
    descriptor: str | None
    saliency: float
    _packed: dict[UFGW, PackedGraphs] = field(default_factory=dict, repr=False)

    def __len__(self) -> int:
        return self.entry.objects

    @cached_property
    def graphs(self) -> pa.RecordBatch:
        """The `graphs` table."""
        return read_only_batch(self.folder, self.entry.files["graphs"])

    @cached_property
    def parts(self) -> PartColumns:
        """The `parts` table."""
        batch = read_only_batch(self.folder, self.entry.files["parts"])
        total = self.entry.parts
        names = batch.schema.names
        return PartColumns(
            numbers(batch["extents"]).reshape(total, 3),
            numbers(batch["relations"]).reshape(total, -1),
            numbers(batch["descriptors"]).reshape(total, -1) if "descriptors" in names else None,
            numbers(batch["masses"]),
            numbers(batch["hops"]),
        )

    @cached_property
    def offsets(self) -> Ints:
        """(objects + 1,) where every object's parts begin."""
        offsets: Ints = self.graphs["flags"].offsets.to_numpy(zero_copy_only=True)
        return offsets

    @cached_property
    def live(self) -> Ints | None:
        """Rows that are not removed, rising; None for all."""
        if self.entry.removed is None:
            return None
        gone = numbers(read_only_batch(self.folder, self.entry.removed)["row"])
        return np.setdiff1d(np.arange(len(self)), gone)

    @cached_property
    def names(self) -> pa.LargeStringArray:
        """Names of all rows."""
        return self.graphs["name"]

    def packed(self, solver: UFGW) -> PackedGraphs:
        """Return what is ranked: the columns as they lie in the file."""
        if solver not in self._packed:
            bounds = read_only_batch(self.folder, self.entry.files["bounds"])
            parts = self.parts
            masses, hot = parts.masses, tuple(numbers(bounds[key]) for key in ("extents", "features", "masses"))
            if solver.saliency != self.saliency:
                masses = self._masses(solver.saliency)
                hot = (*hot[:2], side_by_side(masses[:, None]))
            self._packed[solver] = PackedGraphs(
                self.offsets,
                numbers(self.graphs["part"]),
                parts.extents,
                parts.relations,
                parts.descriptors,
                numbers(self.graphs["structure"]),
                masses,
                solver,
                self.descriptor,
                hot,
            )
        return self._packed[solver]

    def _masses(self, saliency: float) -> Floats:
        """Return source masses of another gamma than the stored one, each graph's as `source_mass` adds it up."""
        masses = np.empty(self.entry.parts)
        for first, end in zip(self.offsets[:-1], self.offsets[1:], strict=True):
            volumes = self.parts.extents[first:end].prod(axis=1)
            own = saliency ** self.parts.hops[first:end].astype(np.int64) * (volumes / volumes.max())
            masses[first:end] = own / own.sum()
        return masses

    @cached_property
    def _objects(self) -> pa.ipc.RecordBatchFileReader:
        return open_table(self.folder, self.entry.files["objects"], check=False)

    def read(self, row: int) -> tuple[Demonstration, PartGraph]:
        """Read one object.

        Raises:
            InputError: Its bytes are not those that were written.
        """
        document, arrays = self._row(row)
        words = parse_document(document)
        demonstration = demonstration_of(words, arrays)
        own = slice(int(self.offsets[row]), int(self.offsets[row + 1]))
        descriptors = self.parts.descriptors
        graph = graph_of(
            demonstration.object,
            words,
            arrays,
            flags=self.graphs["flags"][row].values.to_numpy(),
            structure=self.graphs["structure"][row].values.to_numpy(),
            relations=self.parts.relations[own],
            descriptors=None if descriptors is None else descriptors[own],
            descriptor_name=self.descriptor,
        )
        return demonstration, graph

    def demonstration(self, row: int) -> Demonstration:
        """Read one object without its graph."""
        document, arrays = self._row(row)
        return demonstration_of(parse_document(document), arrays)

    def _row(self, row: int) -> tuple[str, Arrays]:
        batch, place = self.graphs["batch"][row].as_py(), self.graphs["row"][row].as_py()
        path = self.folder / self.entry.files["objects"].name
        try:
            table = self._objects.get_batch(batch)
            document = table["document"][place].as_py()
            arrays = {name: _slice(table[name], place) for name in OBJECT_ARRAYS}
        except (pa.ArrowException, OSError, IndexError, KeyError, ValueError, TypeError) as error:
            raise InputError(f"damaged: {error}", path=path) from None
        if row_checksum(document, arrays) != self.graphs["checksum"][row].as_py():
            name = self.names[row].as_py()
            raise InputError(f"damaged: object {name!r} does not have the checksum that was written", path=path)
        return document, arrays


def _slice(column: pa.LargeListArray, row: int) -> NDArray[Any]:
    """Return one row of a column of lists; offsets that lead out of the column give what there is."""
    offsets = column.offsets.to_numpy(zero_copy_only=True)
    first, end = int(offsets[row]), int(offsets[row + 1])
    if not 0 <= first <= end <= len(column.values):
        raise ValueError(f"row {row} lies outside of its column")
    array: NDArray[Any] = column.values.to_numpy(zero_copy_only=True)[first:end]
    return array

"""One segment of a library on disk, mapped into memory when it is first looked at.

Whatever a query reads of all objects is compared with its checksum once, when it is first touched; the object of a
match is compared with its row's checksum whenever it is read.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
import pyarrow as pa
import xxhash

from graft.errors import InputError
from graft.graph import PartGraph
from graft.library.decode import demonstration_of, graph_of, parse_document
from graft.library.encode import Arrays
from graft.library.files import map_file
from graft.library.manifest import SegmentEntry
from graft.library.tables import OBJECT_ARRAYS, OBJECTS, PLACES, PartColumns, numbers, read_only_batch
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
    def _objects(self) -> pa.Buffer:
        return map_file(self.folder, self.entry.files["objects"], check=False)

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

    def object_batch(self, row: int) -> pa.RecordBatch:
        """Return a row of the `objects` table, its checksum compared.

        Raises:
            InputError: Its bytes are not those that were written.
        """
        start, length, checksum = (self.graphs[key][row].as_py() for key in PLACES)
        data = self._objects.slice(start, length)
        if xxhash.xxh3_64_intdigest(memoryview(data)) != checksum:
            path = self.folder / self.entry.files["objects"].name
            name = self.names[row].as_py()
            raise InputError(f"damaged: object {name!r} does not have the checksum that was written", path=path)
        return pa.ipc.read_record_batch(data, OBJECTS)

    def _row(self, row: int) -> tuple[str, Arrays]:
        batch = self.object_batch(row)
        return batch["document"][0].as_py(), {name: numbers(batch[name]) for name in OBJECT_ARRAYS}

"""Demonstrations into a library on disk."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from graft.errors import InputError
from graft.graph import PartGraph
from graft.library.encode import content_id, graphs_batch, make_row, object_batches, part_columns
from graft.library.manifest import SEGMENTS
from graft.library.store import Snapshot, append
from graft.library.tables import write_segment
from graft.objects import Demonstration


def add_graphs(snapshot: Snapshot, demonstrations: Sequence[Demonstration], graphs: Sequence[PartGraph]) -> Snapshot:
    """Write demonstrations and their graphs as one segment and commit it; return the new version.

    Raises:
        InputError: A name is taken, a graph's descriptors are not the library's, or the disk is full.
    """
    manifest = snapshot.manifest
    taken: set[str] = set()
    for demonstration in demonstrations:
        if demonstration.name in taken:
            raise InputError(f"library: it has a demonstration called {demonstration.name!r} already")
        taken.add(demonstration.name)
    for graph in graphs:
        if graph.descriptor_name != manifest.descriptor:
            raise InputError(
                f"descriptors: the library has {manifest.descriptor}, {graph.object.name} {graph.descriptor_name}"
            )
    rows = [make_row(d, g, samples=manifest.samples) for d, g in zip(demonstrations, graphs, strict=True)]
    columns = part_columns(rows, manifest.saliency)
    entry = write_segment(snapshot.path / SEGMENTS, columns, graphs_batch(rows), object_batches(rows))
    return append(snapshot.path, [entry], columns.relations.shape[1], snapshot)


def duplicates(snapshot: Snapshot, demonstrations: Iterable[Demonstration]) -> dict[str, str]:
    """Return those that are in a library already, by geometry and contact: their names and the names there."""
    names = {content_id(demonstration): demonstration.name for demonstration in demonstrations}
    places = snapshot.find(list(names), "id")
    return {names[id_]: snapshot.segments[number].names[row].as_py() for id_, (number, row) in places.items()}

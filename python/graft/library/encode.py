"""Demonstrations and their part graphs as the columns of a segment."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
import xxhash
from numpy.typing import NDArray

from graft import _core
from graft.errors import InputError
from graft.graph import PartGraph, source_mass
from graft.io.trajectories import packed_trajectory
from graft.library.tables import GRAPHS, OBJECT_ARRAYS, OBJECTS, PLACES, PartColumns, ragged, single
from graft.objects import Demonstration, Joint

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Row:
    """One object ready to be written.

    Attributes:
        demonstration: The object and its contact.
        graph: Its part graph.
        id: (16 bytes) hash of its geometry, its part names and its contact.
        document: JSON of all that is no array.
        arrays: `OBJECT_ARRAYS`, flat.
        source: Where it was read; "" for objects made in memory.
    """

    demonstration: Demonstration
    graph: PartGraph
    id: bytes
    document: str
    arrays: Arrays
    source: str


def make_row(demonstration: Demonstration, graph: PartGraph, *, samples: bool, source: str = "") -> Row:
    """Return the row of a demonstration.

    Raises:
        InputError: Its metadata do not fit JSON.
    """
    obj = demonstration.object
    arrays: Arrays = {
        "vertices": np.concatenate([part.vertices for part in obj.parts]).ravel(),
        "normals": np.concatenate([[] if p.normals is None else p.normals.ravel() for p in obj.parts]),
        "vertex_counts": np.array([len(part.vertices) for part in obj.parts], np.int64),
        "faces": np.concatenate([part.faces for part in obj.parts]).astype(np.int32).ravel(),
        "face_counts": np.array([len(part.faces) for part in obj.parts], np.int64),
        "sweeps": np.concatenate([np.empty(0, np.int64), *(s.ravel() for p in obj.parts for s in p.sweeps)]),
        "trajectory": np.frombuffer(_trajectory(demonstration), np.uint8),
        "centers": graph.centers.ravel(),
        "axes": graph.axes.ravel(),
        "half_extents": graph.half_extents.ravel(),
        "areas": graph.areas,
        "gaps": graph.gaps.ravel(),
        "adjacency": graph.adjacency.astype(np.uint8).ravel(),
        "points": np.stack(graph.points).ravel() if samples else np.empty(0),
        "point_normals": np.stack(graph.normals).ravel() if samples else np.empty(0),
    }
    return Row(demonstration, graph, content_id(demonstration), _document(demonstration, graph), arrays, source)


def _trajectory(demonstration: Demonstration) -> bytes:
    """Return the trajectory as a .npz file's bytes, which no object need be unpickled from; none without one."""
    return b"" if demonstration.trajectory is None else packed_trajectory(demonstration.trajectory)


def content_id(demonstration: Demonstration) -> bytes:
    """Return the 16 bytes that tell what a demonstration shows: geometry, part names, category, contact."""
    obj, contact = demonstration.object, demonstration.contact
    digest = xxhash.xxh3_128()
    for part in obj.parts:
        digest.update(json.dumps([part.name, len(part.vertices), len(part.faces)]).encode())
        digest.update(part.vertices.data)
        digest.update(part.faces.data)
    where = [contact.part, contact.point.tolist(), contact.normal.tolist(), obj.category, obj.scale_to_metres]
    digest.update(json.dumps(where).encode())
    return digest.digest()


def part_columns(rows: Sequence[Row], saliency: float) -> PartColumns:
    """Return the `parts` table of rows.

    Raises:
        InputError: Some have descriptors and some have none.
    """
    graphs = [row.graph for row in rows]
    places = [row.demonstration.contact.part for row in rows]
    described = [g.descriptors for g in graphs if g.descriptors is not None]
    if described and len(described) < len(graphs):
        raise InputError(f"descriptors: expected one a part, {len(graphs) - len(described)} graphs have none")
    hops = [_core.part_hops(g.adjacency, part) for g, part in zip(graphs, places, strict=True)]
    return PartColumns(
        np.concatenate([g.half_extents / g.diagonal for g in graphs]),
        np.concatenate([g.relations for g in graphs]),
        np.concatenate(described) if described else None,
        np.concatenate([source_mass(g, part, saliency) for g, part in zip(graphs, places, strict=True)]),
        np.concatenate(hops).astype(np.int32),
    )


def graphs_batch(rows: Sequence[Row]) -> pa.RecordBatch:
    """Return the `graphs` table of rows, without the places of their objects."""
    shown = [row.demonstration for row in rows]
    words = [d.metadata for d in shown]
    columns = [
        pa.array([row.id for row in rows], GRAPHS.field("id").type),
        [d.name for d in shown],
        [d.object.category for d in shown],
        [licence_of(w) for w in words],
        [tags_of(w) for w in words],
        [width_of(w) for w in words],
        [row.source for row in rows],
        [d.contact.part for d in shown],
        ragged(GRAPHS.field("flags").type, [np.array([f.value for f in r.graph.flags], np.uint8) for r in rows]),
        ragged(GRAPHS.field("structure").type, [row.graph.structure for row in rows]),
    ]
    schema = pa.schema([field for field in GRAPHS if field.name not in PLACES])
    arrays = [c if isinstance(c, pa.Array) else pa.array(c, f.type) for c, f in zip(columns, schema, strict=True)]
    return pa.RecordBatch.from_arrays(arrays, schema=schema)


def object_batches(rows: Iterable[Row]) -> Iterator[pa.RecordBatch]:
    """Return the `objects` table of rows, one record batch each."""
    for row in rows:
        arrays = [pa.array([row.document], pa.large_string())]
        arrays += [single(kind, row.arrays[name]) for name, kind in OBJECT_ARRAYS.items()]
        yield pa.RecordBatch.from_arrays(arrays, schema=OBJECTS)


def _document(demonstration: Demonstration, graph: PartGraph) -> str:
    """Return JSON of what is no array; floats come back to the last bit."""
    obj, contact = demonstration.object, demonstration.contact
    words = {
        "name": demonstration.name,
        "metadata": dict(demonstration.metadata),
        "grasp": None if demonstration.grasp is None else demonstration.grasp.tolist(),
        "contact": {
            "point": contact.point.tolist(),
            "normal": contact.normal.tolist(),
            "part": contact.part,
            "approach": None if contact.approach is None else contact.approach.tolist(),
        },
        "object": {
            "name": obj.name,
            "category": obj.category,
            "up": None if obj.up is None else obj.up.tolist(),
            "scale_to_metres": obj.scale_to_metres,
            "graspable": list(obj.graspable),
            "notes": list(obj.notes),
            "source": obj.source,
            "parts": [
                [p.name, p.label, list(p.notes), p.normals is not None, [list(sweep.shape) for sweep in p.sweeps]]
                for p in obj.parts
            ],
            "joints": [_joint(joint) for joint in obj.joints],
        },
        "diagonal": graph.diagonal,
    }
    try:
        return json.dumps(words, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InputError(f"metadata of {demonstration.name!r}: {error}") from None


def _joint(joint: Joint) -> dict[str, Any]:
    return {
        "parent": joint.parent,
        "child": joint.child,
        "kind": joint.kind,
        "name": joint.name,
        "axis": None if joint.axis is None else joint.axis.tolist(),
        "origin": None if joint.origin is None else joint.origin.tolist(),
        # Infinity is no JSON.
        "limits": None if joint.limits is None else [repr(float(limit)) for limit in joint.limits],
    }


def licence_of(metadata: Mapping[str, Any]) -> str | None:
    """Return what filters take for the licence."""
    value = metadata.get("licence", metadata.get("license"))
    return value if isinstance(value, str) else None


def tags_of(metadata: Mapping[str, Any]) -> list[str]:
    """Return what filters take for the tags: a list of strings, or one string."""
    value = metadata.get("tags")
    given = value if isinstance(value, list | tuple) else [value]
    return [tag for tag in given if isinstance(tag, str)]


def width_of(metadata: Mapping[str, Any]) -> float | None:
    """Return what filters take for the width that the gripper was open, metres."""
    value = metadata.get("gripper_width")
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None

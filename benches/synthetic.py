"""Libraries of random graphs, written segment by segment in seconds.

Graphs of 2 to 20 parts, median 4, in families: a graph's descriptors, relations and boxes are those of one of 1000
random prototypes with noise, as objects of a category resemble each other. The objects themselves are tetrahedra.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa

from graft.graph import build_graph
from graft.library import Library
from graft.library.encode import make_row, object_batches
from graft.library.manifest import SEGMENTS
from graft.library.search import Query
from graft.library.store import append
from graft.library.tables import GRAPHS, PLACES, PartColumns, write_segment
from graft.marking import mark_contact
from graft.objects import Floats, Part, PartObject

FAMILIES = 1000
RELATIONS = 34
"""As many as real graphs have."""
LARGEST = 20
SEGMENT = 1 << 16
NAME = "random-1"


def sizes(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return part counts: 2 plus a geometric number, median 4, at most 20."""
    return np.minimum(1 + rng.geometric(0.3, count), LARGEST)


class Prototypes:
    """What the members of a family have in common."""

    def __init__(self, dim: int) -> None:
        rng = np.random.default_rng(1)
        self.boxes = rng.random((FAMILIES, LARGEST, 3)) / 2
        self.looks = rng.standard_normal((FAMILIES, LARGEST, dim))
        self.places = rng.standard_normal((FAMILIES, LARGEST, RELATIONS))

    def members(self, rng: np.random.Generator, family: np.ndarray, slot: np.ndarray) -> tuple[Floats, Floats, Floats]:
        """Return half extents, relations and descriptors of parts in slots of families."""

        def near(prototypes: np.ndarray, noise: float) -> np.ndarray:
            values = prototypes[family, slot]
            values += noise * rng.standard_normal(values.shape, np.float32)
            return values

        relations = near(self.places, 0.5)
        relations /= np.linalg.norm(relations, axis=1, keepdims=True)
        return np.abs(near(self.boxes, 0.05)), relations, near(self.looks, 0.5)


def edge_lengths(rng: np.random.Generator, count: int, size: int) -> Floats:
    """Return edge lengths (count, size, size) of random points."""
    points = rng.random((count, size, 3), np.float32)
    x = np.linalg.norm(points[:, :, None] - points[:, None], axis=-1)
    return (x / (1 + x)).astype(np.float64)


def random_query(prototypes: Prototypes, rng: np.random.Generator) -> Query:
    """Return a further member of a random family."""
    m = int(sizes(rng, 1)[0])
    extents, relations, descriptors = prototypes.members(rng, np.full(m, rng.integers(FAMILIES)), np.arange(m))
    prior = rng.random(m) + 0.05
    return Query("query", extents, relations, descriptors, edge_lengths(rng, 1, m)[0], prior / prior.sum(), NAME)


def tetrahedra(size: int) -> pa.RecordBatch:
    """Return the `objects` row of an object of `size` tetrahedra, without samples."""
    corners, faces = np.vstack([np.zeros(3), np.eye(3)]), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    parts = tuple(Part(f"part_{i}", corners + np.array([i, 0, 0]), faces) for i in range(size))
    shown = mark_contact(PartObject("tetrahedra", parts), 0)
    row = make_row(shown, build_graph(shown.object, descriptor=None), samples=False)
    return next(object_batches([row]))


def segment(path: Path, prototypes: Prototypes, number: int, count: int) -> None:
    """Commit one segment of random graphs."""
    rng = np.random.default_rng([2, number])
    n = sizes(rng, count)
    offsets = np.concatenate(([0], np.cumsum(n)))
    total = int(offsets[-1])
    slot = np.arange(total) - np.repeat(offsets[:-1], n)
    extents, relations, descriptors = prototypes.members(rng, np.repeat(rng.integers(FAMILIES, size=count), n), slot)
    masses = rng.random(total) + 0.05
    masses /= np.repeat(np.add.reduceat(masses, offsets[:-1]), n)
    squares = np.concatenate(([0], np.cumsum(n**2)))
    structures = np.empty(int(squares[-1]))
    for size in np.unique(n).tolist():
        which = np.flatnonzero(n == size)
        places = squares[which][:, None] + np.arange(size**2)
        structures[places.ravel()] = edge_lengths(rng, len(which), size).ravel()
    first = number * SEGMENT

    def lists(ends: np.ndarray, values: np.ndarray) -> pa.Array:
        return pa.LargeListArray.from_arrays(pa.array(ends), pa.array(values))

    columns = {
        "id": pa.array([(first + i).to_bytes(16, "little") for i in range(count)], pa.binary(16)),
        "name": [f"g{first + i}" for i in range(count)],
        "category": [f"category {i % 100}" for i in range(count)],
        "licence": ["CC0"] * count,
        "tags": [["random"]] * count,
        "gripper_width": rng.random(count) * 0.08,
        "source": [""] * count,
        "part": (rng.random(count) * n).astype(np.int64),
        "flags": lists(offsets, np.zeros(total, np.uint8)),
        "structure": lists(squares, structures),
    }
    schema = pa.schema([field for field in GRAPHS if field.name not in PLACES])
    arrays = [
        columns[f.name] if isinstance(columns[f.name], pa.Array) else pa.array(columns[f.name], f.type) for f in schema
    ]
    graphs = pa.RecordBatch.from_arrays(arrays, schema=schema)
    templates = {size: tetrahedra(size) for size in np.unique(n).tolist()}
    parts = PartColumns(extents, relations, descriptors, masses, np.zeros(total, np.int32))
    objects: Iterator[pa.RecordBatch] = (templates[size] for size in n.tolist())
    append(path, [write_segment(path / SEGMENTS, parts, graphs, objects)], RELATIONS)


class Random:
    """Stands for the descriptor of random graphs."""

    name = NAME

    def __init__(self, dim: int) -> None:
        self.dim = dim

    def describe(self, obj: PartObject) -> Floats:
        """Return random vectors, the same for the same number of parts."""
        return np.random.default_rng(len(obj.parts)).standard_normal((len(obj.parts), self.dim))


def make(path: Path, graphs: int, dim: int) -> Prototypes:
    """Write a library of random graphs."""
    prototypes = Prototypes(dim)
    Library.create(path, descriptor=Random(dim), samples=False)
    for number, first in enumerate(range(0, graphs, SEGMENT)):
        segment(path, prototypes, number, min(SEGMENT, graphs - first))
    return prototypes


def real_rows(dim: int, count: int, prefix: str) -> tuple[list, list]:
    """Return demonstrations of four tetrahedra and their graphs, as they are appended."""
    corners, faces = np.vstack([np.zeros(3), np.eye(3)]), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    parts = tuple(Part(f"part_{i}", corners + np.array([i, 0, 0]), faces) for i in range(4))
    shown = mark_contact(PartObject("tetrahedra", parts), 0)
    graph = build_graph(shown.object, descriptor=Random(dim))
    return [replace(shown, name=f"{prefix}{i}") for i in range(count)], [graph] * count

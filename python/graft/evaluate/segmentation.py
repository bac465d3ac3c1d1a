"""Automatic parts against those that people drew: the measures of the Princeton mesh segmentation benchmark."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from graft.errors import InputError
from graft.evaluate.book import ROWS, Book, code_fingerprint
from graft.evaluate.cut_measures import (
    CutField,
    Net,
    consistency_errors,
    cut_discrepancy,
    hamming_distance,
    rand_index_error,
)
from graft.evaluate.cutters import Cutter
from graft.evaluate.intervals import Estimate, bootstrap_mean
from graft.evaluate.protocols import Half
from graft.evaluate.work import Progress, answered
from graft.io import load_object
from graft.io.mesh_file import read_raw
from graft.objects import Floats, Ints

PEOPLE = "people"
"""The row of the people themselves, each against the others: the ceiling."""

HUMAN_FILE = "human_segmentations.npz"
"""`labels` (people, faces): the part that each person gave each face."""

QUOTED = {
    "people": 0.10,
    "randomized cuts": 0.15,
    "normalised cuts": 0.17,
    "shape diameter": 0.18,
}
"""Rand-index errors over all 380 meshes and 19 categories, as published with the benchmark."""

MEASURES = ("rand", "cut", "hamming", "gce", "lce")
"""Figures of a row, less is better in all."""


@dataclass(frozen=True, eq=False)
class DrawnObject:
    """A mesh that several people cut.

    Attributes:
        key: Its folder's name.
        category: From object.json; the key where it has none.
        vertices: (v, 3) as in the file.
        faces: (f, 3) as in the file.
        people: (p, f) part of each face, by person; at least two people.
    """

    key: str
    category: str
    vertices: Floats
    faces: Ints
    people: Ints


@dataclass(frozen=True)
class CutRow:
    """What one method made of one object; means over the people.

    Attributes:
        query: Key of the object.
        method: Which made it.
        category: Of the object.
        parts: How many it made; of people the mean.
        seconds: Processor time it took.
        rand: Rand-index error.
        cut: Cut discrepancy; None where nobody or the method made no cut.
        hamming: Hamming distance.
        gce: Global consistency error.
        lce: Local consistency error.
    """

    query: str
    method: str
    category: str
    parts: float
    seconds: float
    rand: float
    cut: float | None
    hamming: float
    gce: float
    lce: float


def load_drawn(folder: Path, half: Half = "both", limit: int | None = None) -> list[DrawnObject]:
    """Read the objects under a folder that have `human_segmentations.npz` beside their `mesh.ply`.

    Args:
        folder: One folder per object.
        half: Of the objects sorted by category and name every second one is for tuning, the others for reporting.
        limit: At most so many, evenly spread.

    Raises:
        InputError: There are none, or labels and faces do not agree.
    """
    found = []
    for path in sorted(folder.glob(f"*/{HUMAN_FILE}")):
        (mesh,) = read_raw(path.with_name("mesh.ply"))
        try:
            with np.load(path, allow_pickle=False) as file:
                labels = np.asarray(file["labels"])
        except (OSError, ValueError, KeyError) as error:
            raise InputError(f"expected an array labels ({error})", path=path) from None
        if labels.ndim != 2 or labels.dtype.kind not in "iu" or len(labels) < 2:
            raise InputError(
                f"labels: expected integers (people, faces) of at least two people, got {labels.shape}", path=path
            )
        if labels.shape[1] != len(mesh.faces):
            raise InputError(f"{labels.shape[1]} labels for {len(mesh.faces)} faces", path=path)
        category = load_object(path.parent).category or path.parent.name
        found.append(DrawnObject(path.parent.name, category, mesh.vertices, mesh.faces, labels.astype(np.int64)))
    if not found:
        raise InputError(f"expected folders with mesh.ply and {HUMAN_FILE}, got none", path=folder)
    found.sort(key=lambda obj: (obj.category, obj.key))
    chosen = {"both": found, "tuning": found[::2], "reporting": found[1::2]}[half]
    if limit is None or limit >= len(chosen):
        return chosen
    return [chosen[i * len(chosen) // limit] for i in range(limit)]


@dataclass(frozen=True, eq=False)
class _Job:
    """What a worker needs."""

    objects: tuple[DrawnObject, ...]
    cutters: tuple[Cutter, ...]
    seed: int

    def rows(self, number: int) -> list[CutRow]:
        """Measure every method, and the people, on one object."""
        judge = _Judge.of(self.objects[number])
        rows = [judge.people()]
        for cutter in self.cutters:
            start = time.process_time()
            labels = cutter.cut(judge.object.vertices, judge.object.faces, judge.median, self.seed)
            rows.append(judge.row(cutter.name, labels, time.process_time() - start))
        return rows


@dataclass(frozen=True, eq=False)
class _Judge:
    """One object with what measuring needs, made once."""

    object: DrawnObject
    areas: Floats
    net: Net
    fields: tuple[CutField, ...]

    @classmethod
    def of(cls, obj: DrawnObject) -> _Judge:
        corners = obj.vertices[obj.faces]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        net = Net.of(obj.vertices, obj.faces)
        fields = tuple(CutField.of(net, labels) for labels in obj.people)
        return cls(obj, np.linalg.norm(cross, axis=1) / 2.0, net, fields)

    @property
    def median(self) -> int:
        """How many parts people make, in the middle."""
        return int(np.median([len(np.unique(labels)) for labels in self.object.people]))

    def figures(self, labels: Ints, field: CutField, others: Sequence[int]) -> dict[str, float | None]:
        """Return means over some of the people."""
        found: dict[str, list[float | None]] = {name: [] for name in MEASURES}
        for person in others:
            drawn = self.object.people[person]
            overall, local = consistency_errors(labels, drawn, self.areas)
            found["rand"].append(rand_index_error(labels, drawn))
            found["cut"].append(cut_discrepancy(field, self.fields[person], self.net.radius))
            found["hamming"].append(hamming_distance(labels, drawn, self.areas))
            found["gce"].append(overall)
            found["lce"].append(local)
        return {name: _mean(values) for name, values in found.items()}

    def row(self, method: str, labels: Ints, seconds: float) -> CutRow:
        """Measure against everybody."""
        figures = self.figures(labels, CutField.of(self.net, labels), range(len(self.object.people)))
        return _row(self.object, method, float(len(np.unique(labels))), seconds, figures)

    def people(self) -> CutRow:
        """Measure everybody against the others."""
        count = len(self.object.people)
        each = [
            self.figures(labels, self.fields[i], [j for j in range(count) if j != i])
            for i, labels in enumerate(self.object.people)
        ]
        parts = float(np.mean([len(np.unique(labels)) for labels in self.object.people]))
        return _row(self.object, PEOPLE, parts, 0.0, {name: _mean([f[name] for f in each]) for name in MEASURES})


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def _row(obj: DrawnObject, method: str, parts: float, seconds: float, figures: dict[str, float | None]) -> CutRow:
    certain = {name: 0.0 if value is None else round(value, 9) for name, value in figures.items()}
    return CutRow(
        query=obj.key,
        method=method,
        category=obj.category,
        parts=parts,
        seconds=round(seconds, 3),
        rand=certain["rand"],
        cut=None if figures["cut"] is None else certain["cut"],
        hamming=certain["hamming"],
        gce=certain["gce"],
        lce=certain["lce"],
    )


def evaluate_cuts(
    objects: Sequence[DrawnObject],
    cutters: Sequence[Cutter],
    *,
    seed: int = 0,
    workers: int = 1,
    out: Path | None = None,
    progress: Progress = lambda *_: None,
) -> list[CutRow]:
    """Cut every object by every method, and measure.

    Args:
        objects: With unique keys.
        cutters: With unique names.
        seed: Of methods that draw.
        workers: Processes; rows do not depend on it.
        out: Folder of `rows.jsonl`; a stopped run goes on from it. None keeps nothing.
        progress: Told after every object.

    Returns:
        Rows in the order of objects; people first, then the methods.
    """
    header = {
        "code": code_fingerprint(),
        "seed": seed,
        "methods": [cutter.name for cutter in cutters],
        "objects": [obj.key for obj in objects],
    }
    book: Book[CutRow] | None = None if out is None else Book.open(out / ROWS, header, lambda d: CutRow(**d))
    keys = [obj.key for obj in objects]
    make: Callable[[], _Job] = lambda: _Job(tuple(objects), tuple(cutters), seed)  # noqa: E731
    return answered(keys, make, book, workers=workers, what="cutting", progress=progress)


@dataclass(frozen=True)
class CutSummary:
    """Means over objects.

    Attributes:
        method: Name.
        objects: How many.
        parts: Mean number of parts.
        seconds: Mean processor time.
        slowest: Its maximum.
        figures: Mean and interval of each of `MEASURES`; objects without cuts are left out of "cut".
    """

    method: str
    objects: int
    parts: float
    seconds: float
    slowest: float
    figures: dict[str, Estimate] = field(default_factory=dict)


def summarise_cuts(rows: Sequence[CutRow], seed: int = 0) -> list[CutSummary]:
    """Return one summary per method, in the order of rows."""
    summaries = []
    for method in dict.fromkeys(row.method for row in rows):
        own = [row for row in rows if row.method == method]
        figures = {}
        for name in MEASURES:
            known = [(getattr(row, name), row.query) for row in own if getattr(row, name) is not None]
            if known:
                figures[name] = bootstrap_mean([v for v, _ in known], [key for _, key in known], seed=seed)
        summaries.append(
            CutSummary(
                method=method,
                objects=len(own),
                parts=float(np.mean([row.parts for row in own])),
                seconds=float(np.mean([row.seconds for row in own])),
                slowest=max(row.seconds for row in own),
                figures=figures,
            )
        )
    return summaries


def cuts_by_category(rows: Sequence[CutRow], seed: int = 0) -> dict[str, list[CutSummary]]:
    """Return summaries per category, in alphabetical order."""
    kinds = sorted({row.category for row in rows})
    return {kind: summarise_cuts([row for row in rows if row.category == kind], seed) for kind in kinds}

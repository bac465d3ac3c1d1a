"""Which objects are targets, which demonstrations they may be answered from, and how the objects lie.

A benchmark holds every object once, posed (turned and scaled at random) and with parts as drawn or perturbed.
The same posed object serves as target and, with a contact on it, as source: its part graph is built once.

On folders of labelled objects nobody demonstrated anything: the contact of a source is the middle of each of
its graspable parts (`graft.marking.mark_contact` without a point), one source per graspable part.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np

from graft import zoo
from graft.errors import InputError
from graft.evaluate.automatic import automatic_parts
from graft.evaluate.perturb import perturb_parts
from graft.graph import build_graph
from graft.io import load_object
from graft.marking import closest_surface_point, mark_contact
from graft.objects import Demonstration, Floats, PartObject

ProtocolName = Literal["paper", "leave-category-out", "within-category", "one-source"]
Half = Literal["both", "tuning", "reporting"]
WhoseParts = Literal["drawn", "auto-target", "auto-both"]
PROTOCOLS: tuple[ProtocolName, ...] = ("paper", "leave-category-out", "within-category", "one-source")

SCALES = (0.5, 2.0)
"""Objects are scaled by a factor drawn from this range, evenly in its logarithm."""


@dataclass(frozen=True)
class Posing:
    """How objects are put before they are evaluated.

    Attributes:
        seed: Of rotations, scales and defects; each object draws from its own stream, told by its name.
        turn: Rotate and scale every object at random; its up axis and its metres go along.
        up: Keep what is known of the up axis; False drops it.
        perturb: Give every object's parts a defect (`graft.evaluate.perturb`).
        parts: Whose parts methods see: as drawn, or cut by `graft.segment`, of targets only or of all objects.
    """

    seed: int = 0
    turn: bool = True
    up: bool = True
    perturb: bool = False
    parts: WhoseParts = "drawn"


@dataclass(frozen=True, eq=False)
class Subject:
    """An object as it is evaluated.

    Attributes:
        key: Unique name.
        object: What methods see.
        truth: The same object in the same pose with parts as drawn: what predictions are measured against.
        diagonal: Of its box, object units.
        defect: What was done to its parts.
    """

    key: str
    object: PartObject
    truth: PartObject
    diagonal: float
    defect: str | None = None


@dataclass(frozen=True, eq=False)
class Source:
    """A demonstration on one of the benchmark's objects.

    Attributes:
        subject: Index of the object.
        demonstration: On `Subject.object`, name unique.
    """

    subject: int
    demonstration: Demonstration


@dataclass(frozen=True)
class Query:
    """A target and the sources that it may be answered from.

    Attributes:
        key: Unique.
        target: Index of the object.
        sources: Indices of the sources.
    """

    key: str
    target: int
    sources: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Benchmark:
    """Everything that is asked.

    Attributes:
        protocol: Its name.
        posing: How the objects were put.
        subjects: All objects.
        sources: All demonstrations.
        queries: In the order of reports.
    """

    protocol: str
    posing: Posing
    subjects: tuple[Subject, ...]
    sources: tuple[Source, ...]
    queries: tuple[Query, ...]

    def category(self, subject: int) -> str:
        """Return the category of an object, its name where it has none."""
        obj = self.subjects[subject].truth
        return obj.category or obj.name


def stream(*names: str | int) -> np.random.Generator:
    """Return a random generator told by names and numbers, the same on any machine and in any order."""
    return np.random.default_rng([n if isinstance(n, int) else zlib.crc32(n.encode()) for n in names])


def random_similarity(rng: np.random.Generator, scales: tuple[float, float] = SCALES) -> Floats:
    """Return a rotation (4, 4), uniform over all, times a scale."""
    w, x, y, z = (q := rng.standard_normal(4)) / np.linalg.norm(q)
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    transform = np.eye(4)
    transform[:3, :3] = np.exp(rng.uniform(*np.log(scales))) * rotation
    return transform


def pose(
    key: str, obj: PartObject, posing: Posing, shown: Sequence[Demonstration] = (), *, target: bool = False
) -> tuple[Subject, list[Demonstration]]:
    """Put an object, and the contacts demonstrated on it, as `posing` says; `target`: it is only asked about."""
    rng = stream(posing.seed, key)
    transform = random_similarity(rng) if posing.turn else np.eye(4)
    truth = replace(obj.transformed(transform), name=key)
    truth = truth if posing.up else replace(truth, up=None)
    diagonal = build_graph(truth, descriptor=None).diagonal
    cut = posing.parts == "auto-both" or (target and posing.parts == "auto-target")
    seen = automatic_parts(truth) if cut else truth
    seen, defect = perturb_parts(seen, diagonal, rng) if posing.perturb else (seen, None)
    moved = []
    for demonstration in shown:
        contact = demonstration.contact.transformed(transform)
        if seen is not truth:
            apart = [closest_surface_point(part, contact.point)[2] for part in seen.parts]
            contact = replace(contact, part=int(np.argmin(apart)))
        moved.append(replace(demonstration, object=seen, contact=contact))
    return Subject(key, seen, truth, diagonal, defect), moved


def middles(obj: PartObject) -> list[Demonstration]:
    """Return one demonstration per graspable part: the part's middle."""
    return [mark_contact(obj, part, name=f"{obj.name}:{obj.parts[part].name}") for part in obj.graspable]


def load_objects(where: str | Path) -> list[PartObject]:
    """Read the labelled objects of a folder of folders, or the scans that the package brings (`ycb`).

    Objects of which nothing is said to be graspable are left out.

    Raises:
        InputError: There is no such folder, an object cannot be read, or none says what is graspable.
    """
    if str(where) == "ycb":
        return [replace(zoo.ycb_object(name), name=name) for name in zoo.ycb_names()]
    folder = Path(where)
    if not folder.is_dir():
        raise InputError("expected a folder with one folder per object, or ycb", path=folder)
    found = [replace(load_object(path.parent), name=path.parent.name) for path in sorted(folder.glob("*/object.json"))]
    objects = [obj for obj in found if obj.graspable]
    if not objects:
        raise InputError("expected folders with an object.json that lists graspable_parts, got none", path=folder)
    return objects


def paper(posing: Posing, *, variants: int = 12, demonstrations: int = 1, limit: int | None = None) -> Benchmark:
    """Return the paper's protocol on the zoo: demonstrated categories answer for the unseen ones.

    Args:
        posing: Its seed also chooses the variants.
        variants: Of each unseen category.
        demonstrations: Of each demonstrated category.
        limit: At most so many targets, taken in turn from the categories.
    """
    first = 1000 * posing.seed
    posed = [
        pose(f"{category}_{first + n}", shown.object, posing, [shown])
        for category in zoo.demonstrated()
        for n in range(demonstrations)
        for shown in [zoo.demonstration(category, first + n)]
    ]
    names = [(category, n) for n in range(variants) for category in zoo.unseen()][:limit]
    targets = [pose(f"{c}_{first + n}", zoo.make(c, first + n), posing, target=True) for c, n in sorted(names)]
    sources = _sources(posed)
    everything = tuple(range(len(sources)))
    return Benchmark(
        protocol="paper",
        posing=posing,
        subjects=tuple(subject for subject, _ in posed + targets),
        sources=sources,
        queries=tuple(Query(subject.key, len(posed) + i, everything) for i, (subject, _) in enumerate(targets)),
    )


def from_objects(
    protocol: ProtocolName,
    objects: Sequence[PartObject],
    posing: Posing,
    *,
    source: str | None = None,
    half: Half = "both",
    limit: int | None = None,
) -> Benchmark:
    """Return a benchmark over labelled objects.

    * leave-category-out: a target is answered from all objects of other categories;
    * within-category: from the other objects of its own category; objects that are alone are no targets;
    * one-source: every demonstration alone answers for all other objects, one query each.

    Args:
        protocol: Which of these.
        objects: With unique names and graspable parts.
        posing: How they are put.
        source: one-source: only the demonstrations of this object; by default those of the first object of
            each category.
        half: Which targets: of the objects sorted by category and name, every second one is for tuning, the
            others are for reporting. Sources are all objects in either case.
        limit: At most so many targets, evenly spread over these.

    Raises:
        InputError: A name comes twice, `source` is unknown, or no target has any source.
    """
    names = [obj.name for obj in objects]
    if len(set(names)) < len(names):
        raise InputError(f"objects: expected unique names, got {len(names) - len(set(names))} repeated")
    if source is not None and source not in names:
        raise InputError(f"source: no object called {source!r}; the objects are {', '.join(names)}")
    posed = [pose(obj.name, obj, posing, middles(obj)) for obj in objects]
    subjects, sources = tuple(subject for subject, _ in posed), _sources(posed)
    asked = range(len(objects))
    if posing.parts == "auto-target":
        # Every object twice: with its own parts as a source, with automatic ones as a target.
        again = [pose(obj.name, obj, posing, target=True)[0] for obj in objects]
        asked = range(len(objects), 2 * len(objects))
        subjects += tuple(replace(subject, key=f"{subject.key}, automatic parts") for subject in again)
    kinds = [subject.truth.category or subject.key for subject in subjects]
    chosen = _spread(_half(kinds, names, half), limit)

    def among(target: int, allowed: Callable[[int], bool]) -> tuple[int, ...]:
        return tuple(i for i, s in enumerate(sources) if s.subject != target and allowed(s.subject))

    if protocol == "one-source":
        heads = {names.index(source)} if source else {kinds.index(kind) for kind in kinds}
        queries = [
            Query(f"{names[target]}<{sources[i].demonstration.name}", asked[target], (i,))
            for target in chosen
            for i in among(target, lambda subject: subject in heads)
        ]
    elif protocol in ("leave-category-out", "within-category"):
        wanted = protocol == "within-category"
        queries = [
            Query(names[target], asked[target], among(target, partial(_same_kind, kinds, wanted, target)))
            for target in chosen
        ]
    else:
        raise InputError(f"protocol: expected one of {', '.join(PROTOCOLS[1:])}, got {protocol!r}")
    queries = [query for query in queries if query.sources]
    if not queries:
        raise InputError(f"{protocol}: no target has a source it may be answered from")
    return Benchmark(protocol, posing, subjects, sources, tuple(queries))


def _same_kind(kinds: Sequence[str], wanted: bool, target: int, subject: int) -> bool:
    """Tell whether two objects are of one category, or, where that is not wanted, of two."""
    return (kinds[subject] == kinds[target]) == wanted


def _sources(posed: Iterable[tuple[Subject, list[Demonstration]]]) -> tuple[Source, ...]:
    return tuple(Source(i, shown) for i, (_, many) in enumerate(posed) for shown in many)


def _half(kinds: Sequence[str], names: Sequence[str], half: Half) -> list[int]:
    """Return the objects of one half, in their order."""
    order = sorted(range(len(names)), key=lambda i: (kinds[i], names[i]))
    return sorted({"both": order, "tuning": order[::2], "reporting": order[1::2]}[half])


def _spread(indices: Sequence[int], limit: int | None) -> list[int]:
    """Return at most `limit` of the indices, evenly spread."""
    if limit is None or limit >= len(indices):
        return list(indices)
    return [indices[i * len(indices) // limit] for i in range(limit)]

"""Which demonstration an attempt is made from: graft's retrieval and vote, or MimicGen's strategies."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.random import Generator

from graft.checks import Floats
from graft.contact import VOTERS, TransferredContact, agree, transfer_contact
from graft.datagen.config import TASKS, Selection, Task
from graft.datagen.retarget import Source, retargeted, source_of
from graft.datagen.rotations import rotation_vector
from graft.errors import InputError
from graft.graph import PartGraph
from graft.library import Library
from graft.objects import Demonstration

NEAREST = 3
"""MimicGen's nearest neighbours draw from so many (`nn_k`)."""


def replayable(library: Library, task: Task) -> dict[str, Source]:
    """Return the demonstrations that have a trajectory and are not of another task of `TASKS`, by name.

    Raises:
        InputError: None is, or the trajectory of one cannot be replayed.
    """
    others = {other for other in TASKS if other != task}
    shown = [d for d in library if d.trajectory is not None]
    sources = {d.name: source_of(d) for d in shown if d.metadata.get("task") not in others}
    if not sources:
        what = "a trajectory to replay" if not shown else f"a trajectory of the task {task!r}"
        raise InputError(f"library: no demonstration has {what}; graft demonstrate makes such")
    return sources


class Chooser:
    """Chooses sources for one object, and knows where their contacts land on it.

    Args:
        library: Demonstrations.
        sources: Those that can be replayed.
        graph: The object's, in metres.
    """

    def __init__(self, library: Library, sources: dict[str, Source], graph: PartGraph) -> None:
        self._library, self._sources, self._graph = library, sources, graph
        self._voted: list[TransferredContact] | None = None
        self._landed: dict[str, list[TransferredContact]] = {}

    def choose(self, how: Selection, rng: Generator, placed: Floats, hand: Floats) -> Source:
        """Return the source of an attempt; the object stands at `placed`, the hand at `hand` (4, 4)."""
        if how == "graft":
            return self._sources[self.voted()[0].match.demonstration.name]
        names = list(self._sources)
        if how == "random":
            return self._sources[names[int(rng.integers(len(names)))]]
        if how == "nearest_neighbor_object":
            near = _nearest(self._sources.values(), lambda source: _apart(source.object_pose(0), placed))
        else:
            near = _nearest(self._sources.values(), lambda source: _apart(_first(source, placed), hand))
        return near[int(rng.integers(len(near)))]

    def contacts(self, source: Source, how: Selection, count: int) -> list[TransferredContact]:
        """Return at most `count` places to take the object, the best first.

        With graft's selection those of the vote, best first, one a part's place; else where the source's lands.
        """
        if how == "graft":
            return self.voted()[:count]
        if source.name not in self._landed:
            matches = self._library.retrieve(self._graph, k=1, where=lambda d: d.name == source.name)
            self._landed[source.name] = [transfer_contact(match) for match in matches]
        return self._landed[source.name]

    def voted(self) -> list[TransferredContact]:
        """Return the contacts of the best matches in the order of their vote."""
        if self._voted is None:

            def usable(demonstration: Demonstration) -> bool:
                return demonstration.name in self._sources

            matches = self._library.retrieve(self._graph, k=VOTERS, where=usable)
            self._voted = agree([transfer_contact(match) for match in matches])
        return self._voted


def _nearest(sources: Iterable[Source], distance: Callable[[Source], float]) -> list[Source]:
    ranked = sorted(sources, key=distance)
    return ranked[:NEAREST]


def _apart(a: Floats, b: Floats) -> float:
    """Return MimicGen's distance of two poses: metres plus radians."""
    turn = rotation_vector(a[:3, :3] @ b[:3, :3].T)
    return float(np.linalg.norm(a[:3, 3] - b[:3, 3]) + np.linalg.norm(turn))


def _first(source: Source, placed: Floats) -> Floats:
    pose: Floats = retargeted(source.targets(0)[:1], source.object_pose(0), placed)[0]
    return pose

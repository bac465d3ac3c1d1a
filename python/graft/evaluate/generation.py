"""The paper's second claim: how many attempts to make training data from a demonstration succeed, by method.

The methods differ by their switches alone: they meet the same objects in the same places, and the noise is the same.
Objects are as drawn: their body frames agree (z up, fronts alike), as MimicGen takes for granted.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import graft
from graft import zoo
from graft.datagen.attempt import Target, run_attempt
from graft.datagen.config import GenerationConfig, checked_force, vanilla
from graft.datagen.judge import AttemptOutcome
from graft.datagen.scripted import demonstrate
from graft.datagen.selection import replayable
from graft.errors import InputError
from graft.evaluate.book import ROWS, Book, code_fingerprint
from graft.evaluate.intervals import Estimate, bootstrap_mean
from graft.evaluate.work import Progress, answered
from graft.grasp import PANDA_HAND, Gripper
from graft.library import Library
from graft.objects import PartObject

GRAFT = "graft"
"""Name of the method that the others are compared with."""

QUOTED: Mapping[str, float] = {"GRAFT, paper (quoted)": 0.63, "MimicGen, paper (quoted)": 0.11}
"""Success rates that others published, on their own objects and physics; not measured here."""


def generation_methods(base: GenerationConfig) -> dict[str, GenerationConfig]:
    """Return graft, its two single switches, both off, and MimicGen as published; name -> configuration."""
    published = vanilla()
    neither = replace(base, anchor=published.anchor, reach=published.reach)
    return {
        GRAFT: base,
        "anchor only": replace(base, reach=published.reach),
        "reach only": replace(base, anchor=published.anchor),
        "neither": neither,
        "vanilla": replace(neither, select=published.select),
    }


@dataclass(frozen=True)
class GenerationRow:
    """One attempt.

    Attributes:
        method: Name.
        query: Name of the object.
        attempt: Number on this object.
        demonstration: The source; "" for none.
        outcome: Value of an `AttemptOutcome`.
        reason: What decided it.
        any_step: Whether MimicGen's success, at any step, would have counted.
        seconds: Of the wall clock; the only value that differs between runs.
    """

    method: str
    query: str
    attempt: int
    demonstration: str
    outcome: str
    reason: str
    any_step: bool
    seconds: float

    @classmethod
    def read(cls, document: dict[str, Any]) -> GenerationRow:
        """Return the row that a line of the file tells."""
        return cls(**document)


@dataclass(frozen=True)
class GenerationRate:
    """How the attempts of a method, or on an object, ended.

    Attributes:
        name: Of the method or object.
        attempts: How many.
        counts: Outcome -> how many.
        success: Rate at the end of the hold, and its interval; whole objects resampled.
        any_step: Rate by MimicGen's semantics: raised at any step.
        sources: Demonstrations that anything kept came from.
        seconds_per_kept: Wall clock of one process for each success; None without any.
    """

    name: str
    attempts: int
    counts: dict[str, int]
    success: Estimate
    any_step: float
    sources: int
    seconds_per_kept: float | None


def rate(name: str, rows: Sequence[GenerationRow], seed: int = 0) -> GenerationRate:
    """Return the rate of some rows, of which there is at least one."""
    good = [row.outcome == AttemptOutcome.SUCCESS for row in rows]
    kept = sum(good)
    return GenerationRate(
        name=name,
        attempts=len(rows),
        counts=dict(Counter(row.outcome for row in rows)),
        success=bootstrap_mean([float(g) for g in good], [row.query for row in rows], seed=seed),
        any_step=sum(row.any_step for row in rows) / len(rows),
        sources=len({row.demonstration for row, g in zip(rows, good, strict=True) if g}),
        seconds_per_kept=sum(row.seconds for row in rows) / kept if kept else None,
    )


def above(rows: Sequence[GenerationRow], method: str, seed: int = 0) -> Estimate:
    """Return by how much graft's success rate is above another's, on the same attempts."""
    ours = {(r.query, r.attempt): r.outcome == AttemptOutcome.SUCCESS for r in rows if r.method == GRAFT}
    theirs = {(r.query, r.attempt): r.outcome == AttemptOutcome.SUCCESS for r in rows if r.method == method}
    keys = sorted(ours.keys() & theirs.keys())
    return bootstrap_mean([float(ours[k]) - float(theirs[k]) for k in keys], [k[0] for k in keys], seed=seed)


@dataclass(frozen=True, eq=False)
class Field:
    """What is evaluated.

    Attributes:
        library: Demonstrations with trajectories.
        objects: With unique names.
        attempts: On each object, by each method.
        seed: Of the run.
        gripper: The floating hand.
        methods: Name -> configuration.
    """

    library: Library
    objects: tuple[PartObject, ...]
    attempts: int
    seed: int = 0
    gripper: Gripper = PANDA_HAND
    methods: Mapping[str, GenerationConfig] = field(default_factory=lambda: generation_methods(GenerationConfig()))

    def __post_init__(self) -> None:
        if self.attempts < 1:
            raise InputError(f"attempts: expected at least 1, got {self.attempts}")
        names = [obj.name for obj in self.objects]
        if not names or len(set(names)) < len(names):
            raise InputError("objects: expected at least one, with unique names")
        for config in self.methods.values():
            checked_force(self.gripper, config.physics)

    def rows(self, number: int) -> list[GenerationRow]:
        """Make all attempts on object `number`."""
        base = next(iter(self.methods.values()))
        sources = replayable(self.library, base.task)
        target = Target.lay(self.objects[number], self.library, sources, base.physics)
        rows = []
        for attempt in range(self.attempts):
            for method, config in self.methods.items():
                made = run_attempt(target, self.gripper, config, run=self.seed, number=attempt, keep=False)
                rows.append(
                    GenerationRow(
                        method, made.object, attempt, made.demonstration, made.outcome.value, made.reason,
                        made.any_step, round(made.seconds, 6),
                    )
                )  # fmt: skip
        return rows


def zoo_library(seed: int, gripper: Gripper = PANDA_HAND) -> Library:
    """Return the paper's: one scripted demonstration of each demonstrated category of the zoo.

    Raises:
        InputError: One of them cannot be demonstrated with that gripper.
    """
    return _scripted([zoo.demonstration(category, seed) for category in zoo.demonstrated()], seed, gripper)


def ycb_library(seed: int, gripper: Gripper = PANDA_HAND) -> Library:
    """Return scripted demonstrations of every second YCB scan that can be demonstrated.

    Raises:
        InputError: None can.
    """
    shown = [zoo.ycb_demonstration(name) for name in zoo.ycb_names()[::2]]
    return _scripted(shown, seed, gripper, skip=True)


def _scripted(shown: Sequence[Any], seed: int, gripper: Gripper, *, skip: bool = False) -> Library:
    library, last = Library(), None
    for one in shown:
        try:
            library.add(demonstrate(one, gripper, seed=seed))
        except InputError as error:
            if not skip:
                raise
            last = error
    if not len(library):
        raise InputError(f"no demonstration could be made; the last: {last}")
    return library


def evaluate_generation(
    asked: Field, *, workers: int = 1, out: Path | None = None, progress: Progress = lambda *_: None
) -> list[GenerationRow]:
    """Make the attempts of every method on every object.

    Args:
        asked: What is evaluated.
        workers: Processes; the rows do not depend on it, but for their seconds.
        out: Folder of `rows.jsonl`; rows found there are not made again. None keeps nothing.
        progress: Told what is being done.

    Returns:
        Rows in the order of objects, attempts, methods.

    Raises:
        InputError: An object cannot be simulated, or the file of rows was made with other settings.
        MissingExtraError: The simulator is not installed.
    """
    book = None if out is None else Book.open(out / ROWS, _header(asked), GenerationRow.read)
    keys = [obj.name for obj in asked.objects]
    return answered(keys, lambda: asked, book, workers=workers, what="attempts", progress=progress)


def _header(asked: Field) -> dict[str, Any]:
    shapes = hashlib.sha256(b"".join(obj.bounds.tobytes() for obj in asked.objects)).hexdigest()[:16]
    shown = hashlib.sha256()
    for demonstration in asked.library:
        shown.update(demonstration.name.encode() + demonstration.contact.point.tobytes())
        if demonstration.trajectory is not None:
            shown.update(demonstration.trajectory.T_world_target.tobytes())
    header = {
        "graft": graft.__version__,
        "code": code_fingerprint(),
        "attempts": asked.attempts,
        "seed": asked.seed,
        "gripper": asked.gripper.name,
        "methods": {name: config.document() for name, config in asked.methods.items()},
        "objects": [obj.name for obj in asked.objects],
        "shapes": shapes,
        "library": shown.hexdigest()[:16],
    }
    told: dict[str, Any] = json.loads(json.dumps(header))
    return told

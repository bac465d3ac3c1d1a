"""Runs of attempts that survive being killed: `graft generate`.

A folder has `run.json` (what it was made with), `episodes.hdf5` (successes; until the end in `episodes.hdf5.parts/`, a
file each, written by the workers) and `failures.jsonl`. What is in neither has not been tried. The same run gives the
same episodes and failures with any number of workers, however often it was stopped.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from graft import __version__
from graft.datagen.attempt import Attempt
from graft.datagen.config import GenerationConfig, checked_force
from graft.datagen.durable import make_folder, put
from graft.datagen.episode import SUCCESS
from graft.datagen.export import export_episodes
from graft.datagen.failures import FailureBook
from graft.datagen.pool import Work, made
from graft.datagen.read import Format
from graft.datagen.selection import replayable
from graft.datagen.writers.robomimic import RobomimicWriter, parts_folder
from graft.errors import InputError
from graft.grasp import PANDA_HAND, Gripper
from graft.io.guards import read_json
from graft.library import Library
from graft.objects import PartObject

EPISODES, FAILURES, RUN, LEROBOT = "episodes.hdf5", "failures.jsonl", "run.json", "lerobot"
"""What a run's folder holds; the last where LeRobot's format was asked for."""


@dataclass
class Tally:
    """How a run stands.

    Attributes:
        total: Attempts asked for.
        resumed: Attempts found from before.
        outcomes: Object -> outcome -> count, those from before included.
        seconds: Of this run's wall clock.
        fresh: Attempts made by this run.
    """

    total: int
    resumed: int = 0
    outcomes: dict[str, Counter[str]] = field(default_factory=dict)
    seconds: float = 0.0
    fresh: int = 0

    def add(self, obj: str, outcome: str) -> None:
        """Count an attempt."""
        self.outcomes.setdefault(obj, Counter())[outcome] += 1

    @property
    def counts(self) -> Counter[str]:
        """Outcome -> count."""
        return sum(self.outcomes.values(), Counter())

    @property
    def done(self) -> int:
        """Attempts that ended."""
        return self.counts.total()

    @property
    def kept(self) -> int:
        """Successes."""
        return self.counts[SUCCESS]

    @property
    def remaining(self) -> float | None:
        """Seconds that the rest will take at the pace so far; None before the first attempt."""
        return None if self.fresh == 0 else self.seconds / self.fresh * (self.total - self.done)

    def document(self) -> dict[str, Any]:
        """Return the tally for JSON."""
        return {
            "attempts": self.done,
            "kept": self.kept,
            "resumed": self.resumed,
            "outcomes": dict(sorted(self.counts.items())),
            "objects": {name: dict(sorted(counts.items())) for name, counts in sorted(self.outcomes.items())},
            "seconds": round(self.seconds, 3),
        }


Progress = Callable[[Tally], None]
"""Told after each attempt."""


def generate(
    library: Library,
    objects: Sequence[PartObject],
    out: str | Path,
    *,
    n: int,
    gripper: Gripper = PANDA_HAND,
    config: GenerationConfig | None = None,
    seed: int = 0,
    workers: int = 0,
    format: Format = "robomimic",
    progress: Progress = lambda _: None,
) -> Tally:
    """Make attempts, evenly over the objects, and keep the episodes of those that succeed.

    Begun again in the same folder it goes on where it was stopped; with a larger `n` it adds attempts.

    Args:
        library: Demonstrations with trajectories.
        objects: With unique names.
        out: Folder of the run.
        n: Attempts.
        gripper: The floating hand.
        config: How attempts are made; graft's way when None.
        seed: Of the run; an attempt's is a hash of it, the object, the demonstration and the attempt's number.
        workers: Processes; 0 works in this one. More than 0 needs `if __name__ == "__main__":` in scripts.
        format: "lerobot" also writes the folder `lerobot` when all attempts are done.
        progress: Told after each attempt.

    Raises:
        InputError: No demonstration can be replayed, two objects have one name, the folder has another run or is being
            written by one, or the system refuses (disk full); what was finished by then stays and is found again.
        MissingExtraError: mujoco or h5py is not installed.
    """
    config, out = config or GenerationConfig(), Path(out)
    _check(library, objects, config, n, workers, seed)
    checked_force(gripper, config.physics)
    make_folder(out)
    work = Work(library, tuple(objects), gripper, config, seed)
    _claim(out / RUN, _document(work))
    began, tally = time.perf_counter(), Tally(n)
    path = out / EPISODES
    with RobomimicWriter(path) as writer, FailureBook(out / FAILURES) as failures:
        names = [work.name(index) for index in range(n)]
        for index, name in enumerate(names):
            entry = failures.entries.get(name)
            if name in writer.names or entry is not None:
                tally.add(_object(work, index), SUCCESS if entry is None else entry["outcome"])
        tally.resumed = tally.done
        # One object after the other, so that a worker prepares it once.
        waiting = [i for i in range(n) if names[i] not in writer.names and names[i] not in failures.entries]
        waiting.sort(key=lambda i: (i % len(objects), i))

        def finish(attempt: Attempt) -> None:
            if attempt.outcome.value != SUCCESS:
                failures.add(attempt.document())
            tally.add(attempt.object, attempt.outcome.value)
            tally.fresh += 1
            tally.seconds = time.perf_counter() - began
            progress(tally)

        for _, attempt in made(replace(work, parts=parts_folder(path)), waiting, workers):
            finish(attempt)
        failures.sort({name: index for index, name in enumerate(names)})
    if format == "lerobot" and path.exists():
        export_episodes(path, out / LEROBOT, "lerobot")
    tally.seconds = time.perf_counter() - began
    return tally


def _check(
    library: Library, objects: Sequence[PartObject], config: GenerationConfig, n: int, workers: int, seed: int
) -> None:
    if not len(library):
        raise InputError("library: it is empty, add a demonstration first")
    replayable(library, config.task)
    if not objects:
        raise InputError("objects: expected at least one, got none")
    twice = [name for name, count in Counter(obj.name for obj in objects).items() if count > 1]
    if twice:
        raise InputError(f"objects: expected unique names, {twice[0]!r} is there twice")
    for name, value, least in (("n", n, 1), ("workers", workers, 0), ("seed", seed, 0)):
        if value < least:
            raise InputError(f"{name}: expected at least {least}, got {value}")


def _object(work: Work, index: int) -> str:
    return work.objects[index % len(work.objects)].name


def _document(work: Work) -> dict[str, Any]:
    """Return what the attempts of a run depend on."""
    shown = hashlib.sha256()
    for demonstration in work.library:
        shown.update(demonstration.name.encode())
        shown.update(demonstration.contact.point.tobytes())
        if demonstration.trajectory is not None:
            shown.update(demonstration.trajectory.T_world_target.tobytes())
    seen = hashlib.sha256()
    for obj in work.objects:
        seen.update(obj.name.encode())
        seen.update(obj.bounds.tobytes())
    return {
        "graft": __version__,
        "seed": work.seed,
        "gripper": work.gripper.name,
        "config": work.config.document(),
        "library": shown.hexdigest()[:16],
        "objects": [obj.name for obj in work.objects],
        "shapes": seen.hexdigest()[:16],
    }


def _claim(path: Path, document: dict[str, Any]) -> None:
    """Write what a run is made with, or refuse a folder that has another run."""
    document = json.loads(json.dumps(document, allow_nan=False))
    if not path.exists():
        put(path, json.dumps(document, indent=1, allow_nan=False).encode())
        return
    found = read_json(path)
    for key, value in document.items():
        if found.get(key) != value:
            raise InputError(f"the folder has a run with another {key}; choose another --out or remove it", path=path)

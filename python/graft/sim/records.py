"""Trials in a file, one JSON document a line: appended as they end, read again when a run is taken up."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Sequence
from dataclasses import fields
from io import BufferedWriter
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from graft.errors import GraftError, InputError
from graft.objects import Floats
from graft.sim.outcome import Measurements, Outcome, Trial

if TYPE_CHECKING:
    from graft.sim.runner import Job

SYNC_SECONDS = 1.0
"""Seconds between two times that the file is forced to the disk: what a power cut can cost."""


class TrialBook:
    """The trials of a run by the index of their job, and their file.

    Lines are written in the order of the jobs, so that the file does not depend on the number of workers; half a line
    at the end, from a run that was killed, is cut off.
    """

    def __init__(self, path: Path | None, jobs: Sequence[Job], *, resume: bool, simulator: str) -> None:
        self.jobs = jobs
        self.simulator = simulator
        self.trials: list[Trial | None] = [None] * len(jobs)
        self._path = path
        self._file: BufferedWriter | None = None
        self._digests = [_digest(job, simulator) for job in jobs] if path is not None else []
        self._written = [False] * len(jobs)
        self._next = 0
        self._synced = monotonic()
        if path is not None and resume and path.exists():
            self._read(path)
        elif path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(b"")

    def __enter__(self) -> TrialBook:
        if self._path is not None:
            self._file = self._path.open("ab")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._file is not None:
            # A run that is broken off keeps what ended out of order, too.
            for index, trial in enumerate(self.trials):
                if trial is not None and not self._written[index]:
                    self._write(index, trial)
            self._sync()
            self._file.close()

    def open(self) -> list[int]:
        """Return the indices of jobs without a trial."""
        return [index for index, trial in enumerate(self.trials) if trial is None]

    def put(self, index: int, trial: Trial) -> None:
        """Keep a trial; write all that no earlier job keeps waiting."""
        self.trials[index] = trial
        while self._next < len(self.trials) and (ready := self.trials[self._next]) is not None:
            if self._file is not None and not self._written[self._next]:
                self._write(self._next, ready)
            self._next += 1
        if self._file is not None and monotonic() - self._synced > SYNC_SECONDS:
            self._sync()

    def complete(self) -> list[Trial]:
        """Return all trials."""
        trials = [trial for trial in self.trials if trial is not None]
        if len(trials) != len(self.trials):
            raise GraftError(f"{len(self.trials) - len(trials)} of {len(self.trials)} trials are missing")
        return trials

    def _write(self, index: int, trial: Trial) -> None:
        if self._file is None:
            return
        entry = {"key": self.jobs[index].key, "job": self._digests[index]} | trial.document()
        self._file.write(json.dumps(entry, allow_nan=False).encode() + b"\n")
        self._written[index] = True

    def _sync(self) -> None:
        if self._file is not None:
            self._file.flush()
            os.fsync(self._file.fileno())
            self._synced = monotonic()

    def _read(self, path: Path) -> None:
        data = path.read_bytes()
        whole = data[: data.rfind(b"\n") + 1]
        if len(whole) < len(data):
            with path.open("r+b") as file:
                file.truncate(len(whole))
        index_of = {job.key: index for index, job in enumerate(self.jobs)}
        for number, line in enumerate(whole.splitlines(), start=1):
            try:
                entry = json.loads(line)
                index = index_of.get(entry["key"])
                made_by = entry["job"]
            except (ValueError, KeyError, TypeError):
                raise InputError(f"line {number}: expected a trial", path=path) from None
            if index is None:
                continue
            if made_by != self._digests[index]:
                raise InputError(
                    f"line {number}: the trial {entry['key']!r} was made with another grasp, object or settings; give "
                    "another file, or begin anew (resume=False)",
                    path=path,
                )
            self.trials[index] = _trial(entry, self.jobs[index])
            self._written[index] = True


def _trial(entry: dict[str, Any], job: Job) -> Trial:
    """Return the trial of a line; what the job knows comes from the job."""
    names = [f.name for f in fields(Measurements)]
    measured = {k: tuple(v) if isinstance(v, list) else v for k, v in entry["measurements"].items() if k in names}
    pose = entry["T_world_object"]
    return Trial(
        outcome=Outcome(entry["outcome"]),
        reason=entry["reason"],
        object_name=entry["object"],
        config=job.config,
        grasp=job.grasp,
        T_world_object=None if pose is None else np.array(pose),
        measurements=Measurements(**measured),
        warnings=tuple(entry["warnings"]),
        simulator=entry["simulator"],
        versions=entry["versions"],
        steps=entry["steps"],
        wall_seconds=entry["wall_seconds"],
    )


def _digest(job: Job, simulator: str) -> str:
    """Return what tells jobs of one key apart: object, pose, grasp, gripper, settings, simulator."""
    digest = hashlib.sha256(simulator.encode())
    digest.update(json.dumps([job.object.object.name, job.config.document()], sort_keys=True).encode())
    arrays: list[Floats] = [job.object.T_world_object, job.object.body.hull, *job.object.body.pieces]
    if job.pose is not None:
        arrays.append(job.pose)
    if job.grasp is not None:
        digest.update(f"{job.grasp.gripper.name} {job.grasp.gripper.stroke}".encode())
        arrays.append(job.grasp.pose)
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:16]

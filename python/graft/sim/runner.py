"""Many trials over processes: the same results for any number of workers, in order, whatever a worker does."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from time import monotonic
from typing import Any

from graft.errors import GraftError, InputError
from graft.grasp import Grasp
from graft.objects import Floats
from graft.sim.config import SimulationConfig
from graft.sim.outcome import Outcome, Trial
from graft.sim.prepare import PreparedObject
from graft.sim.records import TrialBook
from graft.sim.simulator import MujocoSimulator, Simulator

BATCH = 8
"""Most jobs on one object that are sent to a worker at once."""

GRACE = 5.0
"""Seconds beyond a trial's own timeout after which its worker is killed."""

START_SECONDS = 120.0
"""Seconds that a worker has to import what it needs."""

Progress = Callable[[int, int], None]
"""Told how many trials are done, of how many."""


@dataclass(frozen=True, eq=False)
class Job:
    """One trial to be run.

    Attributes:
        key: Unique among the jobs; what a file of trials knows it by.
        object: Jobs on the same object are best given one after the other: its scene is compiled once.
        grasp: What to try; None when the planner gave nothing, and the outcome is NO_GRASP.
        config: The settings.
        pose: (4, 4) T_world_object; where the object was prepared when None.
        reason: Why there is no grasp.
    """

    key: str
    object: PreparedObject
    grasp: Grasp | None
    config: SimulationConfig = field(default_factory=SimulationConfig)
    pose: Floats | None = None
    reason: str = "the planner gave no grasp"


def simulate_grasps(
    jobs: Sequence[Job],
    *,
    workers: int | None = None,
    out: Path | None = None,
    resume: bool = True,
    simulator: Simulator | None = None,
    progress: Progress = lambda *_: None,
) -> list[Trial]:
    """Run trials in parallel.

    A trial that runs out of time or whose worker dies ends as UNSTABLE with the reason, and the others go on.

    Args:
        jobs: With unique keys.
        workers: Processes; as many as there are cores when None. A script that calls this needs the usual
            `if __name__ == "__main__":` of multiprocessing. 0 runs in this process, where nothing can be killed.
        out: File of trials, one JSON document a line, in the order of the jobs; appended to as they end.
        resume: Whether trials found in `out` are taken as done; else the file is begun anew.
        simulator: MuJoCo when None.
        progress: Called after each trial.

    Returns:
        One trial a job, in order.

    Raises:
        InputError: Two jobs of one key, or `out` has a trial of the same key made with other settings.
        GraftError: Workers die before they can work.
    """
    workers = (os.cpu_count() or 1) if workers is None else workers
    if workers < 0:
        raise InputError(f"workers: expected at least 0, got {workers}")
    keys = [job.key for job in jobs]
    if len(set(keys)) < len(keys):
        twice = next(key for key in keys if keys.count(key) > 1)
        raise InputError(f"jobs: expected unique keys, got {twice!r} twice")
    simulator = simulator or MujocoSimulator()
    book = TrialBook(out, jobs, resume=resume, simulator=simulator.name)
    with book:
        for index, job in enumerate(jobs):
            if job.grasp is None and book.trials[index] is None:
                trial = replace(
                    Trial.no_grasp(job.object.object.name, job.reason, job.config), simulator=simulator.name
                )
                book.put(index, trial)
        done = len(jobs) - len(book.open())
        progress(done, len(jobs))

        def finish(index: int, trial: Trial) -> None:
            nonlocal done
            book.put(index, trial)
            done += 1
            progress(done, len(jobs))

        if workers == 0:
            for index in book.open():
                finish(index, _simulated(simulator, jobs[index]))
        elif book.open():
            _Pool(jobs, simulator, finish).run(book.open(), workers)
    return book.complete()


def _simulated(simulator: Simulator, job: Job) -> Trial:
    if job.grasp is None:
        raise GraftError(f"job {job.key!r} has no grasp to simulate")
    return simulator.simulate(job.object, job.grasp, job.config, pose=job.pose)


@dataclass(eq=False)
class _Worker:
    """A process, the pipe to it, and what it was given."""

    process: BaseProcess
    pipe: Connection
    ready: bool = False
    batch: list[int] = field(default_factory=list)
    deadline: float = 0.0


class _Pool:
    """Workers that are given batches, watched, and replaced when they hang or die."""

    def __init__(self, jobs: Sequence[Job], simulator: Simulator, finish: Callable[[int, Trial], None]) -> None:
        self.jobs, self.simulator, self.finish = jobs, simulator, finish
        # Never fork: MuJoCo and the threads of numpy's libraries do not survive it.
        self.context = multiprocessing.get_context("spawn")

    def run(self, waiting: Sequence[int], workers: int) -> None:
        """Run the jobs `waiting`, by index."""
        queue = self._batches(waiting)
        pool: list[_Worker] = []
        try:
            while queue or any(worker.batch for worker in pool):
                while len(pool) < min(workers, len(queue) + sum(bool(w.batch) for w in pool)):
                    pool.append(self._hired())
                for worker in pool:
                    if worker.ready and not worker.batch and queue:
                        self._give(worker, queue.pop(0))
                patience = max(0.0, min(worker.deadline for worker in pool) - monotonic())
                heard = wait([worker.pipe for worker in pool], timeout=patience)
                for worker in list(pool):
                    fine = self._listen(worker) if worker.pipe in heard else monotonic() < worker.deadline
                    if not fine:
                        pool.remove(worker)
                        self._bury(worker, queue)
        finally:
            for worker in pool:
                worker.process.kill()
                worker.process.join()
                worker.pipe.close()

    def _batches(self, waiting: Sequence[int]) -> list[list[int]]:
        """Return runs of jobs on one object, none longer than `BATCH`."""
        batches: list[list[int]] = []
        for index in waiting:
            last = batches[-1] if batches else None
            if last and len(last) < BATCH and self.jobs[last[-1]].object is self.jobs[index].object:
                last.append(index)
            else:
                batches.append([index])
        return batches

    def _hired(self) -> _Worker:
        ours, theirs = self.context.Pipe()
        process = self.context.Process(target=_work, args=(theirs, self.simulator), daemon=True)
        process.start()
        theirs.close()
        return _Worker(process, ours, deadline=monotonic() + START_SECONDS)

    def _give(self, worker: _Worker, batch: list[int]) -> None:
        worker.batch = batch
        first = self.jobs[batch[0]]
        lean = [(job.grasp, job.config, job.pose) for job in (self.jobs[i] for i in batch)]
        worker.deadline = monotonic() + first.config.timeout + GRACE
        try:
            worker.pipe.send((first.object, lean))
        except OSError:
            worker.deadline = 0.0  # it is dead: `_bury` gives its jobs to another

    def _listen(self, worker: _Worker) -> bool:
        """Take what a worker says; False when it is dead."""
        try:
            said = worker.pipe.recv()
        except (EOFError, OSError):
            return False
        if said is None:
            worker.ready = True
            worker.deadline = float("inf")
            return True
        self.finish(worker.batch.pop(0), said)
        more = worker.batch
        worker.deadline = monotonic() + self.jobs[more[0]].config.timeout + GRACE if more else float("inf")
        return True

    def _bury(self, worker: _Worker, queue: list[list[int]]) -> None:
        """End a worker that hangs or is dead: its trial is UNSTABLE, the rest of its batch goes back to the queue."""
        hung = worker.process.is_alive() and monotonic() >= worker.deadline > 0
        worker.process.kill()
        worker.process.join()
        worker.pipe.close()
        code = worker.process.exitcode
        if not worker.ready:
            raise GraftError(
                f"a worker ended with code {code} before its first trial; a script that runs trials in parallel needs "
                'if __name__ == "__main__":'
            )
        if not worker.batch:
            return
        job = self.jobs[worker.batch[0]]
        reason = f"timeout: more than {job.config.timeout:g} s, the worker was killed"
        if not hung:
            reason = f"the worker died with code {code}"
        trial = Trial(
            Outcome.UNSTABLE, reason, job.object.object.name, job.config, grasp=job.grasp,
            T_world_object=job.object.T_world_object if job.pose is None else job.pose, simulator=self.simulator.name,
        )  # fmt: skip
        self.finish(worker.batch[0], trial)
        if worker.batch[1:]:
            queue.insert(0, worker.batch[1:])


def _work(pipe: Connection, simulator: Simulator) -> None:
    """Run the batches that come through the pipe, until it closes. An error of a trial is its outcome."""
    pipe.send(None)
    while True:
        try:
            received: tuple[PreparedObject, list[tuple[Grasp, SimulationConfig, Any]]] = pipe.recv()
        except (EOFError, KeyboardInterrupt):
            return
        prepared, batch = received
        for grasp, config, pose in batch:
            try:
                trial = simulator.simulate(prepared, grasp, config, pose=pose)
            except Exception as error:
                reason = f"{type(error).__name__}: {error}"
                trial = Trial(Outcome.UNSTABLE, reason, prepared.object.name, config, grasp=grasp)
            pipe.send(trial)

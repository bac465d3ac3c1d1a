"""Processes that make attempts: each prepares an object once, writes what succeeds, and tells what came of it."""

from __future__ import annotations

import multiprocessing
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

from graft.datagen.attempt import Attempt, Target, attempt_name, derived_seed, run_attempt
from graft.datagen.config import GenerationConfig
from graft.datagen.judge import AttemptOutcome
from graft.datagen.retarget import Source
from graft.datagen.selection import replayable
from graft.datagen.writers.robomimic import write_part
from graft.errors import GraftError, InputError, MissingExtraError
from graft.grasp import Gripper
from graft.library import Library
from graft.objects import PartObject

KEPT_TARGETS = 2
"""Prepared objects that a worker keeps: attempts on one object follow each other."""


@dataclass(frozen=True, eq=False)
class Work:
    """What every worker needs; sent to it once. Attempt i is number i // m on object i % m of m.

    Attributes:
        library: Demonstrations.
        objects: With unique names.
        gripper: The floating hand.
        config: How attempts are made.
        seed: Of the run.
        parts: Folder that successes are written to, each as a file of its own; None writes nothing.
    """

    library: Library
    objects: tuple[PartObject, ...]
    gripper: Gripper
    config: GenerationConfig
    seed: int
    parts: Path | None = None

    def name(self, index: int) -> str:
        """Return the name of attempt `index`."""
        return attempt_name(self.config.task, self.objects[index % len(self.objects)].name, index // len(self.objects))

    def failed(self, index: int, outcome: AttemptOutcome, reason: str) -> Attempt:
        """Return the attempt that could not be made."""
        obj, number = self.objects[index % len(self.objects)].name, index // len(self.objects)
        return Attempt(self.name(index), obj, number, derived_seed(self.seed, obj, "", number), outcome, reason)


class Maker:
    """Makes the attempts of a run in this process."""

    def __init__(self, work: Work) -> None:
        self.work = work
        self._sources: dict[str, Source] = replayable(work.library, work.config.task)
        self._targets: OrderedDict[int, Target | str] = OrderedDict()

    def make(self, index: int) -> Attempt:
        """Make an attempt; a success is on disk when this returns, and its episode is not returned.

        Raises:
            InputError: It cannot be written.
        """
        work = self.work
        target = self._target(index % len(work.objects))
        if isinstance(target, str):
            return work.failed(index, AttemptOutcome.INVALID, target)
        attempt = run_attempt(
            target, work.gripper, work.config, run=work.seed, number=index // len(work.objects),
            keep=work.parts is not None,
        )  # fmt: skip
        parent = multiprocessing.parent_process()
        if parent is not None and not parent.is_alive():
            raise EOFError  # killed; who takes the run up must not meet two writers
        if attempt.episode is not None and work.parts is not None:
            write_part(work.parts / f"demo_{index:06d}.hdf5", attempt.episode)
        return replace(attempt, episode=None)

    def _target(self, place: int) -> Target | str:
        """Return the object made ready, or why it cannot be."""
        if place in self._targets:
            self._targets.move_to_end(place)
            return self._targets[place]
        obj = self.work.objects[place]
        try:
            found: Target | str = Target.lay(obj, self.work.library, self._sources, self.work.config.physics)
        except InputError as error:
            found = str(error)
        self._targets[place] = found
        while len(self._targets) > KEPT_TARGETS:
            self._targets.popitem(last=False)
        return found


@dataclass(eq=False)
class _Worker:
    process: BaseProcess
    pipe: Connection
    index: int | None = None


def made(work: Work, waiting: Sequence[int], workers: int) -> Iterator[tuple[int, Attempt]]:
    """Give index and attempt of all that wait, as they end; the same attempts for any number of workers.

    A worker that dies is replaced, its attempt is UNSTABLE with the reason.

    Args:
        work: The run.
        waiting: Indices, in the order in which they are begun.
        workers: Processes; 0 makes the attempts in this one.

    Raises:
        InputError: An attempt cannot be written; those before are safe.
        GraftError: A worker dies before it can work.
    """
    if workers == 0:
        maker = Maker(work)
        for index in waiting:
            yield index, maker.make(index)
        return
    # Never fork: MuJoCo and the threads of numpy's libraries do not survive it.
    context = multiprocessing.get_context("spawn")
    queue, pool = list(reversed(waiting)), list[_Worker]()

    def hire() -> None:
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, work), daemon=True)
        process.start()
        theirs.close()
        pool.append(_Worker(process, ours))

    try:
        for _ in range(min(workers, len(queue))):
            hire()
        while pool:
            for pipe in wait([worker.pipe for worker in pool]):
                worker = next(w for w in pool if w.pipe is pipe)
                try:
                    said = worker.pipe.recv()
                except (EOFError, OSError):
                    worker.process.join()
                    pool.remove(worker)
                    code = f"the worker died with code {worker.process.exitcode}"
                    if worker.index is None:
                        raise GraftError(f"{code} before its first attempt; a script needs __name__ guarded") from None
                    yield worker.index, work.failed(worker.index, AttemptOutcome.UNSTABLE, code)
                    if queue:
                        hire()
                    continue
                if isinstance(said, str):
                    raise InputError(said)
                if said is not None and worker.index is not None:
                    yield worker.index, said
                if not queue:
                    worker.pipe.close()
                    worker.process.join()
                    pool.remove(worker)
                    continue
                worker.index = queue.pop()
                try:
                    worker.pipe.send(worker.index)
                except OSError:
                    continue  # it is dead; the next wait tells
    finally:
        for worker in pool:
            worker.process.kill()
            worker.process.join()
            worker.pipe.close()


def _serve(pipe: Connection, work: Work) -> None:
    """Make the attempts whose indices come through the pipe, until it closes."""
    try:
        maker = Maker(work)
        pipe.send(None)
        while True:
            index: int = pipe.recv()
            try:
                pipe.send(maker.make(index))
            except (InputError, MissingExtraError) as error:
                pipe.send(str(error))
                return
    except (EOFError, OSError, KeyboardInterrupt):
        return  # the parent is gone

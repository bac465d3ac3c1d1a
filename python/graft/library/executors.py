"""Where work on a library is done: processes of this machine, or (`graft.library.cluster`) a Ray cluster."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import forkserver, resource_tracker
from typing import Protocol, TypeVar

from graft.errors import InputError

T = TypeVar("T")
R = TypeVar("R")

AHEAD = 2
"""Tasks that wait for each worker, so that none idles."""


@dataclass(frozen=True)
class Lost:
    """The answer of a task whose worker died again when it was tried once more, by itself."""

    reason: str


class Executor(Protocol):
    """Runs tasks somewhere; a user's own cluster drops in."""

    @property
    def workers(self) -> int:
        """How many tasks run at a time."""
        ...

    def map(self, work: Callable[[T], R], tasks: Sequence[T]) -> Iterator[R | Lost]:
        """Yield the answers in the order of the tasks, while later ones run.

        Args:
            work: A function of a module.
            tasks: What it is called with, one at a time; they and the answers travel between processes.
        """
        ...


@dataclass(frozen=True)
class LocalExecutor:
    """Processes of this machine.

    Attributes:
        workers: How many; each computes on one core.
    """

    workers: int = os.cpu_count() or 1

    def __post_init__(self) -> None:
        if self.workers < 1:
            raise InputError(f"workers: expected at least 1, got {self.workers}")

    def map(self, work: Callable[[T], R], tasks: Sequence[T]) -> Iterator[R | Lost]:
        """Yield the answers in the order of the tasks.

        A worker that dies (a crash, a lack of memory) takes down what runs beside it; those tasks are run again, each
        by itself, and only the one that kills its worker again is lost.
        """
        waiting = deque(tasks)
        while waiting:
            running: deque[tuple[T, Future[R]]] = deque()
            with _pool(self.workers) as pool:
                try:
                    while waiting or running:
                        while waiting and len(running) < AHEAD * self.workers:
                            running.append((waiting[0], pool.submit(work, waiting[0])))
                            waiting.popleft()
                        answer = running[0][1].result()
                        running.popleft()
                        yield answer
                except BrokenProcessPool:
                    pass
                except BaseException:
                    pool.shutdown(cancel_futures=True)
                    raise
            for task, future in running:
                finished = future.done() and not future.cancelled() and future.exception() is None
                yield future.result() if finished else _alone(work, task)


def _pool(workers: int) -> ProcessPoolExecutor:
    # A fork of a process with threads may hang; the server that is forked instead has none.
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["graft.library.building"])
    # The server starts with interruptions held back, and so do the workers until they can end without a traceback.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    return ProcessPoolExecutor(workers, context, _begin)


def _begin() -> None:
    """Keep the core's threads of several workers from crowding each other; end without a word when interrupted."""
    os.environ["RAYON_NUM_THREADS"] = "1"
    signal.signal(signal.SIGINT, lambda *_: os._exit(1))
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


def _alone(work: Callable[[T], R], task: T) -> R | Lost:
    with _pool(1) as pool:
        try:
            return pool.submit(work, task).result()
        except BrokenProcessPool:
            return Lost("the process that worked on it died")

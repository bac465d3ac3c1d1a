"""Answer queries on several processes, and keep what was answered.

Rows go to a file as they come, so that a run that was stopped goes on where it was; a file made with
anything else, another version of the code included, is refused. The rows, and their order, are the same on
any number of workers.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol, TypeVar

from graft.evaluate.book import Book, QueryRow

Progress = Callable[[str, int, int], None]
"""Called with what is being done, how many are done, how many there are."""

R = TypeVar("R", bound=QueryRow)
R_co = TypeVar("R_co", covariant=True)


class Job(Protocol[R_co]):
    """What a worker needs to answer queries; sent to it once."""

    def rows(self, number: int) -> Sequence[R_co]:
        """Return the rows of query `number`."""
        ...


def answered(
    keys: Sequence[str],
    make_job: Callable[[], Job[R]],
    book: Book[R] | None,
    *,
    workers: int,
    what: str,
    progress: Progress,
) -> list[R]:
    """Return the rows of all queries, in their order.

    Args:
        keys: Of the queries.
        make_job: Called when there is anything left to answer.
        book: Has what was answered before, and gets what is answered now.
        workers: Processes. With more than one, a script that calls this needs the usual
            `if __name__ == "__main__":` of multiprocessing.
        what: Is being done, for `progress`.
        progress: Told after every query.
    """
    done: dict[str, list[R]] = {} if book is None else book.done
    missing = [i for i, key in enumerate(keys) if key not in done]
    if missing:
        job = make_job()
        for count, (number, rows) in enumerate(zip(missing, _stream(job, missing, workers), strict=True)):
            done[keys[number]] = list(rows)
            if book is not None:
                book.write(done[keys[number]])
            progress(what, len(keys) - len(missing) + count + 1, len(keys))
    return [row for key in keys for row in done[key]]


_sent: list[Job[Any]] = []
"""The job of this worker process; empty in the parent."""


def _receive(job: Job[Any]) -> None:
    _sent[:] = [job]


def _answer(number: int) -> Sequence[Any]:
    return _sent[0].rows(number)


def _stream(job: Job[R], numbers: Sequence[int], workers: int) -> Iterator[Sequence[R]]:
    """Yield the rows of every query, in order."""
    if workers == 1 or len(numbers) == 1:
        yield from map(job.rows, numbers)
        return
    # Spawned, not forked: the core's threads would not survive a fork.
    context = multiprocessing.get_context("spawn")
    with context.Pool(min(workers, len(numbers)), _receive, (job,)) as pool:
        yield from pool.imap(_answer, numbers)

"""Work on a library by a Ray cluster whose nodes see its folder; needs the `ray` extra."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from graft.errors import MissingExtraError
from graft.library.executors import AHEAD, Lost

T = TypeVar("T")
R = TypeVar("R")

RETRIES = 3
"""How often Ray starts a task anew whose worker or node died."""


def _ray() -> Any:
    try:
        import ray
    except ImportError:
        raise MissingExtraError("work on a Ray cluster", package="ray", extra="ray") from None
    return ray


@dataclass(frozen=True)
class RayExecutor:
    """Tasks of a Ray cluster, one core each.

    Attributes:
        address: Of the cluster's head ("auto", "ray://host:10001"); None takes the one that this process is
            connected to, or starts one on this machine.
    """

    address: str | None = None

    def connect(self) -> Any:
        """Return the ray module, connected.

        Raises:
            MissingExtraError: Ray is not installed.
            ConnectionError: There is no cluster at the address.
        """
        ray = _ray()
        if not ray.is_initialized():
            ray.init(address=self.address, log_to_driver=False, logging_level="error")
        return ray

    @property
    def workers(self) -> int:
        """Cores of the cluster."""
        return max(1, int(self.connect().cluster_resources().get("CPU", 1)))

    def map(self, work: Callable[[T], R], tasks: Sequence[T]) -> Iterator[R | Lost]:
        """Yield the answers in the order of the tasks; tasks of workers that died are run again."""
        ray = self.connect()
        options = {"max_retries": RETRIES, "runtime_env": {"env_vars": {"RAYON_NUM_THREADS": "1"}}}
        remote = ray.remote(**options)(work)
        waiting, running = deque(tasks), deque[Any]()
        most = AHEAD * self.workers
        while waiting or running:
            while waiting and len(running) < most:
                running.append(remote.remote(waiting.popleft()))
            yield self._answer(ray, running.popleft())

    def _answer(self, ray: Any, reference: Any) -> Any:
        try:
            return ray.get(reference)
        except ray.exceptions.RayTaskError as error:
            raise error.cause from None
        except ray.exceptions.RayError as error:
            return Lost(f"its workers died {RETRIES + 1} times: {type(error).__name__}")

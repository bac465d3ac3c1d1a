"""The attempts that failed, one JSON document a line: appended as they end, sorted when the run is complete."""

from __future__ import annotations

import json
import os
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Any

from graft.datagen.durable import put
from graft.errors import InputError

SYNC_SECONDS = 1.0
"""Seconds between two times that lines are forced to the disk: what a power cut, not a kill, can cost."""


class FailureBook:
    """The file of failures; what it has is read when it is opened, half a line at its end is cut off.

    Raises:
        InputError: A line is no failure; or the system refuses.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.entries: dict[str, dict[str, Any]] = {}
        self._file = None
        if path.exists():
            self._read()
        self._file = path.open("ab")
        self._synced = monotonic()

    def add(self, entry: dict[str, Any]) -> None:
        """Append a failure; it outlives this process when this returns."""
        assert self._file is not None
        self._file.write(json.dumps(entry, allow_nan=False).encode() + b"\n")
        self._file.flush()
        self.entries[entry["name"]] = entry
        if monotonic() - self._synced > SYNC_SECONDS:
            os.fsync(self._file.fileno())
            self._synced = monotonic()

    def sort(self, rank: dict[str, int]) -> None:
        """Write the file anew in the order of `rank` (name -> place), so that it does not depend on who was first."""
        chosen = sorted(self.entries.values(), key=lambda entry: rank.get(entry["name"], len(rank)))
        put(self.path, b"".join(json.dumps(entry, allow_nan=False).encode() + b"\n" for entry in chosen))

    def __enter__(self) -> FailureBook:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._file is not None:
            self._file.close()

    def _read(self) -> None:
        data = self.path.read_bytes()
        whole = data[: data.rfind(b"\n") + 1]
        if len(whole) < len(data):
            os.truncate(self.path, len(whole))
        for number, line in enumerate(whole.splitlines(), start=1):
            try:
                entry = json.loads(line)
                self.entries[entry["name"]] = entry
                entry["outcome"], entry["object"]
            except (ValueError, KeyError, TypeError):
                raise InputError(f"line {number}: expected a failed attempt", path=self.path) from None

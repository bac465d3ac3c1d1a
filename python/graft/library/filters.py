"""Which demonstrations may answer, by what is known of them beside their shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from graft.errors import InputError
from graft.library.encode import licence_of, tags_of, width_of
from graft.objects import Demonstration, Ints


@dataclass(frozen=True)
class Filter:
    """Conditions on categories and metadata; all that are given must hold.

    Attributes:
        category: One of these categories.
        tags: All of these are among the metadata's `tags`.
        licence: One of these is the metadata's `licence` (or `license`).
        max_gripper_width: Metres; the metadata's `gripper_width`, how far the gripper was open, is known and at most
            this.
    """

    category: tuple[str, ...] = ()
    tags: tuple[str, ...] = ()
    licence: tuple[str, ...] = ()
    max_gripper_width: float | None = None

    def __post_init__(self) -> None:
        for key in ("category", "tags", "licence"):
            if isinstance(getattr(self, key), str):
                raise InputError(f"filter {key}: expected a tuple of strings, got {getattr(self, key)!r}")
        width = self.max_gripper_width
        if width is not None and not width >= 0:
            raise InputError(f"filter max_gripper_width: expected metres, at least 0, got {width}")

    def accepts(self, demonstration: Demonstration) -> bool:
        """Tell whether a demonstration fulfils the conditions."""
        words = demonstration.metadata
        width = width_of(words)
        return (
            (not self.category or demonstration.object.category in self.category)
            and set(self.tags) <= set(tags_of(words))
            and (not self.licence or licence_of(words) in self.licence)
            and (self.max_gripper_width is None or (width is not None and width <= self.max_gripper_width))
        )

    def rows(self, graphs: pa.RecordBatch) -> Ints:
        """Return the rows of a segment's `graphs` table that fulfil the conditions, rising."""
        kept = np.ones(len(graphs), np.bool_)
        for key, values in (("category", self.category), ("licence", self.licence)):
            if values:
                kept &= _true(pc.is_in(graphs[key], value_set=pa.array(values, pa.large_string())))
        if self.tags:
            offsets = graphs["tags"].offsets.to_numpy()
            owners = np.repeat(np.arange(len(graphs)), np.diff(offsets))
            for tag in self.tags:
                has = np.zeros(len(graphs), np.bool_)
                has[owners[_true(pc.equal(graphs["tags"].flatten(), tag))]] = True
                kept &= has
        if self.max_gripper_width is not None:
            kept &= _true(pc.less_equal(graphs["gripper_width"], self.max_gripper_width))
        return np.flatnonzero(kept)


def _true(column: Any) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return a column of truths as numpy; what is not known is not true."""
    found: np.ndarray[Any, np.dtype[np.bool_]] = column.fill_null(False).to_numpy(zero_copy_only=False)
    return found

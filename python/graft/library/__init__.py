"""Libraries of demonstrated objects: in memory or on disk, searched exactly."""

from __future__ import annotations

from graft.library.explain import Explanation, PartPair
from graft.library.filters import Filter
from graft.library.library import Library, match
from graft.library.manifest import LibraryChangedError
from graft.library.matching import Match

__all__ = ["Explanation", "Filter", "Library", "LibraryChangedError", "Match", "PartPair", "match"]

"""Libraries of demonstrated objects: in memory or on disk, searched exactly.

`Library` answers; the functions below keep a library on disk in order and take its folder.
"""

from __future__ import annotations

from graft.library.adding import duplicates
from graft.library.building import BuildReport, build
from graft.library.cluster import RayExecutor
from graft.library.compaction import compact, vacuum
from graft.library.executors import Executor, LocalExecutor
from graft.library.explain import Explanation, PartPair
from graft.library.export import export_table
from graft.library.filters import Filter
from graft.library.library import Library, match
from graft.library.listing import Listed, listing
from graft.library.manifest import LibraryChangedError, Manifest
from graft.library.matching import Match
from graft.library.store import checkout, versions
from graft.library.verification import Report, drop_damaged, verify

__all__ = [
    "BuildReport",
    "Executor",
    "Explanation",
    "Filter",
    "Library",
    "LibraryChangedError",
    "Listed",
    "LocalExecutor",
    "Manifest",
    "Match",
    "PartPair",
    "RayExecutor",
    "Report",
    "build",
    "checkout",
    "compact",
    "drop_damaged",
    "duplicates",
    "export_table",
    "listing",
    "match",
    "vacuum",
    "verify",
    "versions",
]

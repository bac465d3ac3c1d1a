"""Flags that every evaluation shares: which objects, how they are put, where the results go."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from graft.errors import InputError
from graft.evaluate.protocols import Benchmark, Posing, WhoseParts, from_objects, load_objects, paper


@dataclass(frozen=True)
class Asked:
    """What is evaluated, and how."""

    protocol: Literal["paper", "leave-category-out", "within-category", "one-source"] = "paper"
    """paper: the zoo's demonstrated categories answer for its unseen ones. The others need --objects."""
    objects: str | None = None
    """Folder with one folder per labelled object (object.json with graspable_parts), or ycb."""
    source: str | None = None
    """one-source: the object whose demonstrations answer; by default the first of each category in turn."""
    half: Literal["both", "tuning", "reporting"] = "both"
    """Of --objects: tune on one half of the targets, report the other."""
    variants: int = 12
    """paper: variants of each unseen category."""
    demonstrations: int = 1
    """paper: variants of each demonstrated category."""
    seed: int = 0
    """Of variants, rotations, scales, defects, chance."""
    turn: bool = True
    """Rotate and scale every object at random."""
    up: bool = True
    """Keep what is known of the up axis."""
    perturb: bool = False
    """Give the parts defects: merged, split, boundaries moved."""
    parts: WhoseParts = "drawn"
    """As people drew them, or cut by graft segment: of targets only, or of all objects."""
    limit: int | None = None
    """At most so many targets."""
    workers: int = os.cpu_count() or 1
    """Processes; the results do not depend on it."""
    json: bool = False
    """Print one JSON document and nothing else."""
    out: Path | None = None
    """Folder for rows.jsonl (a stopped run goes on from it), table, JSON and pictures of the worst cases."""

    def benchmark(self) -> Benchmark:
        """Return the objects, demonstrations and queries."""
        for name in ("variants", "demonstrations", "limit", "workers"):
            value = getattr(self, name)
            if value is not None and value < 1:
                raise InputError(f"--{name}: expected at least 1, got {value}")
        if self.seed < 0:
            raise InputError(f"--seed: expected at least 0, got {self.seed}")
        posing = Posing(self.seed, self.turn, self.up, self.perturb, self.parts)
        if self.protocol == "paper":
            if self.objects is not None:
                raise InputError("--objects: the paper's protocol runs on the zoo; choose another --protocol")
            return paper(posing, variants=self.variants, demonstrations=self.demonstrations, limit=self.limit)
        if self.objects is None:
            raise InputError(f"--protocol {self.protocol}: expected --objects, a folder or ycb")
        objects = load_objects(self.objects)
        return from_objects(self.protocol, objects, posing, source=self.source, half=self.half, limit=self.limit)

"""Why a match is the best one: the terms of its cost, the parts that belong together, what the next one lacks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from graft.library.matching import Match
from graft.transport.graphs import matched_part


@dataclass(frozen=True)
class PartPair:
    """A part of the source and the target part that it goes to.

    Attributes:
        source: Name.
        target: Name.
        share: Of the source part, in [0, 1].
        demonstrated: Whether it is the part that was taken.
    """

    source: str
    target: str
    share: float
    demonstrated: bool


@dataclass(frozen=True, eq=False)
class Explanation:
    """What speaks for a match.

    Attributes:
        match: The best one.
        terms: Its cost term by term; entropy and prior, which do not rank, are left out.
        pairs: Its parts, in order.
        runner_up: The second best, None when there is none.
        lacks: What each term of the runner-up costs more than the best one's, greatest first; they add up to the
            difference of the costs.
    """

    match: Match
    terms: dict[str, float]
    pairs: tuple[PartPair, ...]
    runner_up: Match | None
    lacks: dict[str, float]


RANKED = ("structure", "feature", "marginal_source", "marginal_target", "part", "doubt", "rivals")
"""Terms that add up to a sharp cost."""


def explanation(matches: Sequence[Match]) -> Explanation:
    """Explain the first of the matches by comparing it with the second."""
    first = matches[0]
    runner_up = matches[1] if len(matches) > 1 else None
    terms, pairs = _terms(first), []
    for i, name in enumerate(first.source.object.part_names):
        part, share = matched_part(first.transport.plan, first.transport.target_mass, i)
        pairs.append(PartPair(name, first.target.object.part_names[part], share, i == first.source_part))
    lacks: dict[str, float] = {}
    if runner_up is not None:
        more = {name: value - terms[name] for name, value in _terms(runner_up).items()}
        lacks = dict(sorted(more.items(), key=lambda item: -item[1]))
    return Explanation(first, terms, tuple(pairs), runner_up, lacks)


def _terms(match: Match) -> dict[str, float]:
    return {name: float(match.transport.terms[name]) for name in RANKED if name in match.transport.terms}

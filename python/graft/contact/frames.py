"""Alignment of the canonical frames of matched parts.

A part's box gives a frame only up to the box's symmetries: which way each axis points, which axis is which when
extents tie, and how a round part is turned about its axis. A pair of matched parts is therefore aligned by search:

1. every rotation that permutes and flips the axes of the target's box (the 24 rotations of a cube) is a candidate;
   when two extents tie, so is every turn about the third axis by `TURN_STEP`, and the turn that brings the rest
   of the object to a side of the box;
2. each is judged by the cues of `graft.contact.cues`; the best wins, ties go to the candidate made first;
3. the best, and those that are close to it but point elsewhere, are turned by closest points, and round parts about
   their axis in ever smaller steps, while their score falls; the best refined one wins.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graft.contact.canonical import THINNEST, CanonicalFrame, CanonicalFrames, box_frame, turns_about
from graft.contact.cues import Cues, Spot, View, companion
from graft.graph import PartGraph
from graft.objects import Contact, Floats, Ints

ROUND_TIE = 0.15
"""Two extents of a box within this relative difference make the part round about the third axis."""

CONCENTRIC = 0.02
"""Where the rest of the object lies less than this share of the diagonal off a round part's axis, it is not faced."""

TURN_STEP = np.deg2rad(15.0)
"""Between turns of a round part that are tried. Divides the quarter turn, which the cube's rotations supply."""

FINEST_STEP = np.deg2rad(0.4)
"""The refinement stops below this step: on the rim of a part it is 0.4 % of its width."""

TIE_TOLERANCE = 1e-9
"""Scores closer than this are equal; the earlier candidate wins."""

AMBIGUOUS = 0.02
"""A margin below this is within what another draw of the surface samples does to a score: up to .0175 for a plain block
in six draws, while the least margin of a mug's, a jug's or a pan's parts is .04."""

ELSEWHERE = float(np.cos(np.deg2rad(45)))
"""Frames that differ by a turn whose cosine is below this point elsewhere; they set the margin."""

FINALISTS = 3
"""Most candidates that are refined."""

CLOSE = 0.1
"""Candidates that score within this of the best, and point elsewhere, are refined too: the box of a copy need not be
turned as the original's, and the right candidate may be the second best until it is refined."""

CLOSEST_POINT_STEPS = 12
"""Most steps of the refinement by nearest points; it stops earlier when one does not lower the score."""

LEAST_GAIN = 1e-3
"""A step of the refinement that lowers the score by less is the last of its kind: another draw of the samples changes
the score by more."""

CHUNK = 8
"""Candidates whose chamfer distances are computed at once."""


@dataclass(frozen=True, eq=False)
class FramePair:
    """The aligned canonical frames of a source part and a target part.

    Attributes:
        source: Frame of the source part.
        target: Frame of the target part: points with equal canonical coordinates correspond.
        score: What the winner scored, lower is better.
        margin: How much worse the best candidate that points elsewhere scored than the winner, or than another draw
            of the samples would score if that is worse; 0 at least, inf when there is no such candidate. Below
            `AMBIGUOUS` nothing but chance tells the two apart.
    """

    source: CanonicalFrame
    target: CanonicalFrame
    score: float
    margin: float

    @property
    def ambiguous(self) -> bool:
        """Whether another frame fits as well: the part, with all that surrounds it, is symmetric."""
        return self.margin < AMBIGUOUS


def align_parts(
    source: PartGraph,
    source_part: int,
    target: PartGraph,
    target_part: int,
    plan: Floats,
    contact: Contact | None = None,
) -> FramePair:
    """Align the canonical frames of two matched parts.

    Args:
        source: n parts.
        source_part: Index of the part in the source.
        target: m parts.
        target_part: Index of the part in the target.
        plan: (n, m) transport plan; tells which neighbours correspond.
        contact: On the source part, object frame. Where it would look at the object other than it does on the
            source, a frame is worse: it tells how to turn a round part that nothing else does.
    """
    frame = _faced(source, source_part)
    cues = _cues(source, source_part, target, target_part, frame, plan, contact)
    candidates = _candidates(target, target_part)
    best, scores = _search(cues, candidates)
    drawn = {}
    for row in _finalists(candidates, scores, best):
        drawn[row], scores[row] = _drawn_closer(cues, target, target_part, candidates.one(row), float(scores[row]))
    best = min(drawn, key=lambda row: float(scores[row]))
    margin = float("inf")
    elsewhere = scores[_points_elsewhere(candidates.rotations, candidates.rotations[best])]
    if len(elsewhere):
        margin = max(0.0, float(elsewhere.min()) - max(float(scores[best]), cues.noise()))
    winner, score = _turned(cues, target, target_part, drawn[best], float(scores[best]))
    return FramePair(frame, winner, score, margin)


def _cues(
    source: PartGraph,
    source_part: int,
    target: PartGraph,
    target_part: int,
    frame: CanonicalFrame,
    plan: Floats,
    contact: Contact | None,
) -> Cues:
    """Return the cues for frames of the target part against `frame` of the source part."""
    seen = View.of(source, source_part)
    spot = None
    if contact is not None:
        outlook = float(seen.outlook(contact.point[None], contact.normal[None])[0])
        spot = Spot(frame.to_canonical(contact.point), frame.directions(contact.normal), outlook)
    weights = plan.copy()
    weights[source_part, :] = 0.0
    weights[:, target_part] = 0.0
    weights /= max(float(weights.sum()), np.finfo(np.float64).tiny)
    return Cues(frame.half_extents, seen.within(frame), View.of(target, target_part), weights, spot)


def _points_elsewhere(rotations: Floats, rotation: Floats) -> NDArray[np.bool_]:
    """Tell which rotations (k, 3, 3) differ from `rotation` by a large turn."""
    elsewhere: NDArray[np.bool_] = (np.einsum("kij,ij->k", rotations, rotation) - 1.0) / 2.0 < ELSEWHERE
    return elsewhere


def _round_axes(half_extents: Floats) -> list[int]:
    """Return the columns about which a box is round, the best tie first: none, one, or all three."""
    logs = np.log(half_extents)
    apart = np.array([abs(logs[(k + 1) % 3] - logs[(k + 2) % 3]) for k in range(3)])
    return [int(k) for k in np.argsort(apart, kind="stable") if apart[k] < ROUND_TIE]


def _floor(graph: PartGraph, part: int) -> float:
    """Return the least half extent of a fitted frame."""
    return float(graph.half_extents[part].min()) * THINNEST


def _faced(graph: PartGraph, part: int) -> CanonicalFrame:
    """Return the part's frame, turned, when the part is round, so that the other parts lie on an axis."""
    frame = box_frame(graph, part)
    axes = _round_axes(frame.half_extents)
    if not axes:
        return frame
    axis = axes[0]
    toward = companion(graph, part) @ frame.rotation
    first, second = (axis + 1) % 3, (axis + 2) % 3
    if np.hypot(toward[first], toward[second]) < CONCENTRIC:
        return frame
    turn = turns_about(axis, np.array([np.arctan2(toward[second], toward[first])]))
    return CanonicalFrames.fitted(graph.points[part], frame.rotation @ turn, _floor(graph, part)).one(0)


def _candidates(graph: PartGraph, part: int) -> CanonicalFrames:
    """Return the frames of the part that are tried, in the order in which ties are broken."""
    faced, box = _faced(graph, part), box_frame(graph, part)
    axes = _round_axes(box.half_extents)
    bases = [CanonicalFrames.of([faced, box] if axes else [box])]
    angles = np.arange(1, round(np.pi / 2.0 / TURN_STEP)) * TURN_STEP
    for axis in axes:
        rotations = faced.rotation @ turns_about(axis, angles)
        bases.append(CanonicalFrames.fitted(graph.points[part], rotations, _floor(graph, part)))
    return CanonicalFrames.joined(bases).permuted()


def _search(cues: Cues, frames: CanonicalFrames) -> tuple[int, Floats]:
    """Return the best candidate and the scores (k,) of all that were in the running, inf for the others.

    Candidates are taken in the order of their quick scores, which bound the full ones from below, until none that
    is left can win; then until none that points elsewhere can be the runner-up.
    """
    quick = cues.quick(frames)
    order = np.argsort(quick, kind="stable")
    scores = np.full(len(frames), np.inf)

    def judge(rows: Ints, rivals: Ints) -> None:
        for start in range(0, len(rows), CHUNK):
            chunk = rows[start : start + CHUNK]
            if quick[chunk[0]] > scores[rivals].min() + TIE_TOLERANCE:
                return
            scores[chunk] = quick[chunk] + cues.dear(frames[chunk])

    judge(order, order)
    best = int(np.argmax(scores <= scores.min() + TIE_TOLERANCE))
    elsewhere = order[_points_elsewhere(frames.rotations[order], frames.rotations[best])]
    if len(elsewhere):
        judge(elsewhere[np.isinf(scores[elsewhere])], elsewhere)
    return best, scores


def _finalists(frames: CanonicalFrames, scores: Floats, best: int) -> list[int]:
    """Return the best candidate, and the next best that are close to it in score and point elsewhere."""
    chosen = [best]
    if scores[best] <= TIE_TOLERANCE:
        return chosen
    left = scores <= scores[best] + CLOSE
    while len(chosen) < FINALISTS:
        left &= _points_elsewhere(frames.rotations, frames.rotations[chosen[-1]])
        if not left.any():
            break
        chosen.append(int(np.argmin(np.where(left, scores, np.inf))))
    return chosen


def _drawn_closer(
    cues: Cues, graph: PartGraph, part: int, frame: CanonicalFrame, score: float
) -> tuple[CanonicalFrame, float]:
    """Turn a frame by iterative closest points while its score falls."""
    for _ in range(CLOSEST_POINT_STEPS):
        if score <= TIE_TOLERANCE:
            break
        turned = CanonicalFrames.fitted(graph.points[part], cues.closest_turn(frame)[None], _floor(graph, part))
        found = float(cues.scores(turned)[0])
        gain = score - found
        if gain > TIE_TOLERANCE:
            frame, score = turned.one(0), found
        if gain < LEAST_GAIN:
            break
    return frame, score


def _turned(
    cues: Cues, graph: PartGraph, part: int, frame: CanonicalFrame, score: float
) -> tuple[CanonicalFrame, float]:
    """Turn the frame of a round part about its axes, in halving steps, while its score falls."""
    axes = _round_axes(frame.half_extents)
    step = TURN_STEP / 2.0
    while axes and step >= FINEST_STEP and score > TIE_TOLERANCE:
        turns = np.concatenate([turns_about(axis, np.array([step, -step])) for axis in axes])
        tried = CanonicalFrames.fitted(graph.points[part], frame.rotation @ turns, _floor(graph, part))
        scores = cues.scores(tried)
        best = int(np.argmin(scores))
        gain = score - float(scores[best])
        if gain > TIE_TOLERANCE:
            frame, score = tried.one(best), float(scores[best])
        if gain < LEAST_GAIN:
            step /= 2.0
    return frame, score

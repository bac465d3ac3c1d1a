"""Carry a demonstrated contact over to the target: part by the plan, then point by canonical frames.

The target part is the one the plan sends the demonstrated part to. Both parts are put into aligned canonical
frames (`graft.contact.frames`), their points get Fourier codes, and the target's surface point whose code and
normal are nearest to the contact's is the transferred contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graft.contact.encoding import fourier_encoding
from graft.contact.frames import FramePair, align_parts
from graft.library import Match
from graft.objects import Contact, Floats, Ints

SURFACE_SAMPLES = 2048
"""Points of the target part among which the contact is sought; 2048 on a handle are about 1 % of its length apart."""

NORMAL_WEIGHT = 0.5
"""Weight of the squared difference of unit normals beside the squared difference of codes. Keeps a contact on the
outer wall from landing on the inner one; small enough that a place decides before a direction does."""

HEAT_WIDTH = 0.35
"""Standard deviation, in canonical units (the part's box is 2 wide), of the dense map's heat about the contact."""

COST_SCALE = 0.5
"""Ranking cost at which the confidence has fallen to 1/e of what the plan alone would give."""


@dataclass(frozen=True, eq=False)
class TransferredContact:
    """A contact carried from a source to a target.

    Attributes:
        contact: On the target's surface, target frame and units.
        source_part: Index of the demonstrated part.
        target_part: Index of the part it went to.
        transform: (4, 4) T_target_source: takes the demonstrated contact to the transferred one, point to point
            and normal to normal, and with them a gripper pose; a rotation, a translation, and the ratio of
            units where both objects know their metres.
        confidence: In [0, 1]: share of the demonstrated part's mass that went to this part, times
            exp(-cost / COST_SCALE). An ordering, not a probability.
        share: Share of the demonstrated part's transported mass that the target part received.
        frames: The aligned canonical frames.
        match: What it was transferred along.
    """

    contact: Contact
    source_part: int
    target_part: int
    transform: Floats
    confidence: float
    share: float
    frames: FramePair
    match: Match


@dataclass(frozen=True, eq=False)
class DenseMap:
    """Correspondences of surface points, and how much of the contact each target point carries.

    Attributes:
        points: (q, 3) on the target's surface, its frame and units.
        part: (q,) target part of each point.
        source_points: (q, 3) corresponding points on the source's surface, its frame and units.
        source_part: (q,) source part of each.
        heat: (q,) in [0, 1]: nearness of the source point to the demonstrated contact in the canonical frame, times
            the share of the demonstrated part that went to this part.
    """

    points: Floats
    part: Ints
    source_points: Floats
    source_part: Ints
    heat: Floats


def matched_part(plan: Floats, source_part: int) -> tuple[int, float]:
    """Return the target part that receives most of a source part, and the share it receives.

    Args:
        plan: (n, m) transport plan.
        source_part: Row of the plan. Ties go to the lowest index. An empty row falls back to the column
            that receives most in all, with share 0.
    """
    row = plan[source_part]
    total = float(row.sum())
    if total <= 0:
        return int(np.argmax(plan.sum(axis=0))), 0.0
    part = int(np.argmax(row))
    return part, float(row[part]) / total


def transfer_contact(match: Match) -> TransferredContact:
    """Transfer the demonstrated contact of `match` to its target.

    Returns:
        The contact with its normal on the target's surface, the transform, a confidence.
    """
    contact = match.demonstration.contact
    target_part, share = matched_part(match.transport.plan, contact.part)
    frames = align_parts(match.source, contact.part, match.target, target_part, match.transport.plan)
    part = match.target.object.parts[target_part]

    place = frames.source.to_canonical(contact.point)
    facing = frames.source.directions(contact.normal)
    points, normals = _surface_candidates(
        match.target.points[target_part],
        match.target.normals[target_part],
        part,
        frames.target.to_object(place),
        match.target.object.parts[target_part],
    )
    codes = fourier_encoding(frames.target.to_canonical(points))
    distance = np.square(codes - fourier_encoding(place)).sum(axis=1)
    distance += NORMAL_WEIGHT * np.square(frames.target.directions(normals) - facing).sum(axis=1)
    best = int(np.argmin(distance))

    rotation = frames.target.rotation @ frames.source.rotation.T
    transform = _contact_transform(match, rotation, points[best], normals[best])
    approach = None if contact.approach is None else transform[:3, :3] @ contact.approach
    return TransferredContact(
        contact=Contact(points[best], normals[best], target_part, approach),
        source_part=contact.part,
        target_part=target_part,
        transform=transform,
        confidence=float(share * np.exp(-max(match.cost, 0.0) / COST_SCALE)),
        share=share,
        frames=frames,
        match=match,
    )

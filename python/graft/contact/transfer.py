"""Carry a demonstrated contact over to the target: part by the plan, then point by canonical frames.

The target part is the one the plan sends the demonstrated part to. Both parts are put into aligned canonical
frames (`graft.contact.frames`), their points get Fourier codes, and the target's surface point whose code and
normal are nearest to the contact's is the transferred contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graft.contact.cues import View
from graft.contact.encoding import fourier_encoding
from graft.contact.frames import FramePair, align_parts
from graft.library import Match
from graft.marking import closest_surface_point
from graft.objects import Contact, Floats
from graft.transport import matched_part

NORMAL_WEIGHT = 0.5
"""Weight of the squared difference of unit normals, beyond the tolerance, beside the squared difference of codes.
Keeps a contact on the outer wall from landing on the inner one."""

NORMAL_TOLERANCE = 2.0 - 2.0 * float(np.cos(np.deg2rad(30)))
"""Squared difference of unit normals that costs nothing, so that a place decides before a direction does: on a thin
bar a frame that is a few degrees off changes the normal at a place by more than a point further along would."""

COST_SCALE = 1.5
"""Ranking cost at which the confidence has fallen to 1/e of what the votes alone would give. On one half of the targets
of several protocols votes told right from wrong and costs below 1 hardly did; the log loss against being right was
0.85 with exp(-cost / 0.5), 0.30 with this, 0.27 without costs, when nothing would say that no source fits."""

OUTLOOK_WEIGHT = 1.0
"""Weight of how much more of the target a place looks at than the demonstrated contact does of the source, in
[0, 1]. Keeps the gripper's side of a place clear where it was clear in the demonstration."""

OPPOSITE = 1e-9
"""Two unit vectors whose sum is shorter than this are opposite: the turn between them has no axis of its own."""


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
        confidence: In [0, 1]: `confidence_in` the share.
        share: Of the target part in the demonstrated part's row of the plan (`graft.transport.matched_part`).
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


def confidence_in(share: float, cost: float) -> float:
    """Return share exp(-(cost / COST_SCALE)^2), in [0, 1]; it rises with the share and falls with the cost.

    Args:
        share: Of the demonstrated part that the target part has, or, where several matches vote, of the votes.
        cost: What the match is ranked by; below 0 counts as 0.
    """
    return float(share * np.exp(-np.square(max(cost, 0.0) / COST_SCALE)))


def transfer_contact(match: Match) -> TransferredContact:
    """Transfer the demonstrated contact of `match` to its target.

    Returns:
        The contact with its normal on the target's surface, the transform, a confidence.
    """
    contact = match.demonstration.contact
    target_part, share = matched_part(match.transport.plan, match.transport.target_mass, contact.part)
    frames = align_parts(match.source, contact.part, match.target, target_part, match.transport.plan, contact)

    place = frames.source.to_canonical(contact.point)
    facing = frames.source.directions(contact.normal)
    points, normals = _landing_places(match, target_part, frames.target.to_object(place))
    codes = fourier_encoding(frames.target.to_canonical(points))
    distance = np.square(codes - fourier_encoding(place)).sum(axis=1)
    turned = np.square(frames.target.directions(normals) - facing).sum(axis=1)
    distance += NORMAL_WEIGHT * np.maximum(turned - NORMAL_TOLERANCE, 0.0)
    running = distance <= distance.min() + OUTLOOK_WEIGHT  # no other can win: the outlooks differ by 1 at most
    demonstrated = View.of(match.source, contact.part).outlook(contact.point[None], contact.normal[None])
    outlook = View.of(match.target, target_part).outlook(points[running], normals[running])
    distance[running] += OUTLOOK_WEIGHT * np.maximum(outlook - demonstrated, 0.0)
    best = int(np.argmin(distance))

    rotation = frames.target.rotation @ frames.source.rotation.T
    transform = _contact_transform(match, rotation, points[best], normals[best])
    turn = transform[:3, :3] / np.cbrt(np.linalg.det(transform[:3, :3]))
    approach = None if contact.approach is None else turn @ contact.approach
    return TransferredContact(
        contact=Contact(points[best], normals[best], target_part, approach),
        source_part=contact.part,
        target_part=target_part,
        transform=transform,
        confidence=confidence_in(share, match.cost),
        share=share,
        frames=frames,
        match=match,
    )


def _landing_places(match: Match, part: int, mapped: Floats) -> tuple[Floats, Floats]:
    """Return points (q, 3) and normals (q, 3) of the target part's surface on which the contact may land.

    The first is the surface point nearest to the mapped contact, so that a contact carried onto its own object
    comes back exactly; the others are the part's samples.
    """
    graph = match.target
    point, normal, _ = closest_surface_point(graph.object.parts[part], mapped)
    return np.vstack([point, graph.points[part]]), np.vstack([normal, graph.normals[part]])


def _contact_transform(match: Match, rotation: Floats, point: Floats, normal: Floats) -> Floats:
    """Return T_target_source (4, 4) that takes the contact's point to `point` and its normal to `normal`.

    `rotation` is turned by the smallest angle that makes the normals agree.
    """
    contact = match.demonstration.contact
    source, target = match.source.object, match.target.object
    units = 1.0
    if source.scale_to_metres is not None and target.scale_to_metres is not None:
        units = source.scale_to_metres / target.scale_to_metres
    transform = np.eye(4)
    transform[:3, :3] = units * (_shortest_turn(rotation @ contact.normal, normal) @ rotation)
    transform[:3, 3] = point - transform[:3, :3] @ contact.point
    return transform


def _shortest_turn(start: Floats, end: Floats) -> Floats:
    """Return the rotation (3, 3) by the smallest angle that takes unit vector `start` to unit vector `end`."""
    middle = start + end
    if np.linalg.norm(middle) < OPPOSITE:
        # Half a turn about any axis across; the one nearest to the frame's least aligned axis is stated.
        across = np.cross(start, np.eye(3)[np.argmin(np.abs(start))])
        across /= np.linalg.norm(across)
        return 2.0 * np.outer(across, across) - np.eye(3)
    # Two reflections: across the plane between them, then across `end`'s own.
    middle = middle / np.linalg.norm(middle)
    turn: Floats = (2.0 * np.outer(end, end) - np.eye(3)) @ (2.0 * np.outer(middle, middle) - np.eye(3))
    return turn

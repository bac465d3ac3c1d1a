"""A dense map: for every surface sample of the target, where it corresponds to on the source."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graft.contact.encoding import fourier_encoding
from graft.contact.frames import align_parts
from graft.library import Match
from graft.objects import Floats, Ints

HEAT_WIDTH = 0.35
"""Standard deviation, in canonical units (the part's box is 2 wide), of the heat about the contact."""

NEGLIGIBLE = 0.01
"""A target part that received less than this share of the demonstrated part has no heat."""


@dataclass(frozen=True, eq=False)
class DenseMap:
    """Correspondences of surface points, and how much of the contact each target point carries.

    Attributes:
        points: (q, 3) on the target's surface, its frame and units.
        part: (q,) target part of each point.
        source_points: (q, 3) corresponding points on the source's surface, its frame and units.
        source_part: (q,) source part of each: the one that sends most mass to the point's part.
        heat: (q,) in [0, 1]: nearness to the demonstrated contact in the aligned canonical frames of the
            demonstrated part and the point's part, times the share of the demonstrated part that went there.
    """

    points: Floats
    part: Ints
    source_points: Floats
    source_part: Ints
    heat: Floats


def dense_map(match: Match) -> DenseMap:
    """Return the correspondence of every surface sample of the target of `match`.

    Parts correspond by the plan's columns, points by the codes of aligned canonical frames.
    """
    plan = match.transport.plan
    contact = match.demonstration.contact
    shares = plan[contact.part] / max(float(plan[contact.part].sum()), np.finfo(np.float64).tiny)
    points, owners, sources, source_owners, heats = [], [], [], [], []
    for part, surface in enumerate(match.target.points):
        sender = int(np.argmax(plan[:, part]))
        there = match.source.points[sender]
        frames = align_parts(
            match.source, sender, match.target, part, plan, contact if sender == contact.part else None
        )
        nearest = _nearest_codes(
            fourier_encoding(frames.target.to_canonical(surface)), fourier_encoding(frames.source.to_canonical(there))
        )
        points.append(surface)
        owners.append(np.full(len(surface), part, np.int64))
        sources.append(there[nearest])
        source_owners.append(np.full(len(surface), sender, np.int64))
        if shares[part] < NEGLIGIBLE:
            heats.append(np.zeros(len(surface)))
            continue
        if sender != contact.part:
            frames = align_parts(match.source, contact.part, match.target, part, plan, contact)
        offset = frames.target.to_canonical(surface) - frames.source.to_canonical(contact.point)
        heats.append(shares[part] * np.exp(-np.square(offset).sum(axis=1) / (2.0 * HEAT_WIDTH**2)))
    return DenseMap(
        np.concatenate(points),
        np.concatenate(owners),
        np.concatenate(sources),
        np.concatenate(source_owners),
        np.concatenate(heats),
    )


def _nearest_codes(codes: Floats, others: Floats) -> Ints:
    """Return (q,) the row of others (s, d) nearest to each of codes (q, d); the first on a tie.

    In single precision: its rounding is far below what tells neighbouring samples apart.
    """
    a, b = codes.astype(np.float32), others.astype(np.float32)
    products = a @ (-2.0 * b).T
    products += np.square(b).sum(axis=1)
    nearest: Ints = products.argmin(axis=1)
    return nearest

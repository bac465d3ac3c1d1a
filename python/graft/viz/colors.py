"""Colours of parts. Red belongs to contacts, grey to what matches nothing, amber to what was demonstrated."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graft.objects import Floats

Colors = NDArray[np.uint8]

DEMONSTRATED = (244, 176, 58)
"""The demonstrated part and what it is matched to: the same in every picture, so that the eye learns it."""

CONTACT = (222, 32, 38)
"""Contact balls and arrows. No part's colour comes near it."""

UNMATCHED = (196, 198, 202)
"""A part that receives no mass."""

INK = (38, 42, 50)
"""Text and lines."""

GOOD, BAD, UNKNOWN = (38, 150, 84), (200, 44, 44), (176, 180, 188)
"""Frames: the contact lies in the graspable mask, outside it, or there is no mask."""

PALETTE = (
    (86, 136, 199),
    (98, 180, 162),
    (160, 128, 196),
    (132, 176, 84),
    (170, 138, 108),
    (104, 192, 226),
    (214, 148, 188),
    (188, 186, 88),
    (110, 120, 158),
    (62, 142, 120),
)
"""Colours of the other parts, in order; mid-toned, so that shading and highlights show."""

TINTS = (0.0, 0.4, -0.35, 0.65, -0.6)
"""How far towards white (above zero) or black (below) the palette goes each time it is used up; from the
fifty-first part on colours come again, rather than fade to a white that no one can tell apart."""

NO_MASS = 1e-9
"""A column of a plan below this share of the whole receives nothing."""


def part_colors(n: int, demonstrated: int | None = None) -> Colors:
    """Return (n, 3) colours, the first 50 of them distinguishable, the demonstrated part's being `DEMONSTRATED`."""
    colors = np.empty((n, 3), np.uint8)
    others = [i for i in range(n) if i != demonstrated]
    for place, part in enumerate(others):
        base = np.array(PALETTE[place % len(PALETTE)], np.float64)
        tint = TINTS[place // len(PALETTE) % len(TINTS)]
        colors[part] = np.round(base + ((255.0 if tint > 0 else 0.0) - base) * abs(tint))
    if demonstrated is not None:
        colors[demonstrated] = DEMONSTRATED
    return colors


def matched_colors(plan: Floats, source_colors: Colors) -> Colors:
    """Colour target parts by the source part that sends them the most mass; ties go to the lower index.

    Args:
        plan: (n, m) transport plan.
        source_colors: (n, 3).

    Returns:
        (m, 3); `UNMATCHED` where nothing arrives.
    """
    colors: Colors = source_colors[np.argmax(plan, axis=0)].copy()
    colors[plan.sum(axis=0) <= NO_MASS * plan.sum()] = UNMATCHED
    return colors

"""Rotation- and scale-invariant moments of a point set and of its convex hull."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from graft.objects import Floats

FLOOR = 1e-9
"""A spread below this share of the largest counts as this: flat and straight point sets have one, too."""


def hull_volume(points: Floats) -> tuple[float, float]:
    """Return volume and area of the convex hull of points (s, 3); zeros for flat ones."""
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return 0.0, 0.0
    return float(hull.volume), float(hull.area)


def shape_moments(points: Floats) -> Floats:
    """Describe points (s, 3) on a surface by four numbers that turning and scaling do not change.

    With s1 >= s2 >= s3 the standard deviations along the principal axes and V, A volume and area of the hull:
    s2/s1, s3/s1, V / (s1 s2 s3) and the hull's sphericity 36 pi V^2 / A^3.
    """
    offsets = points - points.mean(axis=0)
    values = np.linalg.eigvalsh(offsets.T @ offsets / len(points))[::-1]
    spreads = np.sqrt(np.maximum(values, 0.0))
    largest = max(float(spreads[0]), np.finfo(float).tiny)
    spreads = np.maximum(spreads / largest, FLOOR)
    volume, area = hull_volume(offsets / largest)
    sphericity = 36.0 * np.pi * volume**2 / area**3 if area > 0 else 0.0
    return np.array([spreads[1], spreads[2], volume / spreads.prod(), sphericity])


def standardised(rows: Floats) -> Floats:
    """Return (n, d) with mean 0 and deviation 1 in every column; constant columns become 0."""
    deviation = rows.std(axis=0)
    scaled: Floats = (rows - rows.mean(axis=0)) / np.where(deviation > FLOOR, deviation, 1.0)
    return scaled

"""Curves that the zoo's surfaces are drawn along: polylines, splines, outlines and handle loops. Metres."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from graft.objects import Floats

OVERSAMPLING = 16
"""Points per wanted point when a curve is evaluated densely before it is resampled by arc length."""

CORNER_POINTS = 6
"""Points of the arc that replaces a rounded corner."""


def resampled(points: ArrayLike, count: int, *, closed: bool = False) -> Floats:
    """Return `count` points at equal arc lengths along the polyline `points` (n, d).

    A closed polyline is given without repeating its first point, and returned so.
    """
    line = np.asarray(points, float)
    if closed:
        line = np.vstack([line, line[:1]])
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = np.linspace(0.0, at[-1], count + 1)[:-1] if closed else np.linspace(0.0, at[-1], count)
    return np.stack([np.interp(wanted, at, column) for column in line.T], axis=1)


def spaced(points: ArrayLike, step: float) -> Floats:
    """Return the polyline `points` (n, d) with segments no longer than `step`; its corners stay."""
    line = np.asarray(points, float)
    pieces = [line[:1]]
    for a, b in itertools.pairwise(line):
        count = max(1, int(np.ceil(np.linalg.norm(b - a) / step)))
        pieces.append(a + (b - a) * np.linspace(0.0, 1.0, count + 1)[1:, None])
    return np.vstack(pieces)


def spline(values: ArrayLike, at: ArrayLike, *, closed: bool = False) -> Floats:
    """Evaluate the Catmull-Rom spline through equally spaced `values` (n, ...) at `at` in [0, 1]."""
    knots = np.asarray(values, float)
    n = len(knots)
    where = np.asarray(at, float) * (n if closed else n - 1)
    left = np.clip(np.floor(where).astype(int), 0, n - 1 if closed else max(n - 2, 0))
    t = (where - left).reshape(-1, *([1] * (knots.ndim - 1)))
    if closed:
        a, b, c, d = (knots[(left + k) % n] for k in (-1, 0, 1, 2))
    else:
        first, last = 2 * knots[0] - knots[1], 2 * knots[-1] - knots[-2]
        padded = np.concatenate([first[None], knots, last[None]])
        a, b, c, d = (padded[left + k] for k in range(4))
    curve: Floats = 0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3)
    return curve


def smooth(points: ArrayLike, count: int, *, closed: bool = False) -> Floats:
    """Return `count` points at equal arc lengths of the smooth curve through `points` (n, d)."""
    dense = np.linspace(0.0, 1.0, OVERSAMPLING * len(np.asarray(points)) + 1)
    curve = spline(points, dense[:-1] if closed else dense, closed=closed)
    return resampled(curve, count, closed=closed)


def rounded(points: ArrayLike, radius: float | Sequence[float], *, closed: bool = False) -> Floats:
    """Return the polyline `points` (n, d) with its corners rounded from `radius` before them on."""
    line = np.asarray(points, float)
    n = len(line)
    radii = np.broadcast_to(np.asarray(radius, float), n)
    t = np.linspace(0.0, 1.0, CORNER_POINTS)[:, None]
    pieces = []
    for i, corner in enumerate(line):
        if radii[i] <= 0 or (not closed and i in (0, n - 1)):
            pieces.append(corner[None])
            continue
        before, after = line[i - 1] - corner, line[(i + 1) % n] - corner
        ends = []
        for arm in (before, after):
            length = float(np.linalg.norm(arm))
            ends.append(corner + arm / length * min(radii[i], 0.49 * length))
        pieces.append((1 - t) ** 2 * ends[0] + 2 * t * (1 - t) * corner + t**2 * ends[1])
    return np.vstack(pieces)


def superellipse(count: int, a: float = 1.0, b: float = 1.0, exponent: float = 2.0) -> Floats:
    """Return (count, 2) points of |x/a|^exponent + |y/b|^exponent = 1, counterclockwise from (a, 0)."""
    angle = np.linspace(0.0, 2 * np.pi, OVERSAMPLING * count, endpoint=False)
    c, s = np.cos(angle), np.sin(angle)
    curve = np.stack(
        [a * np.sign(c) * np.abs(c) ** (2 / exponent), b * np.sign(s) * np.abs(s) ** (2 / exponent)], axis=1
    )
    return resampled(curve, count, closed=True)


def rectangle(count: int, width: float, height: float, radius: float) -> Floats:
    """Return (count, 2) points of a rectangle around the origin with corners rounded by `radius`."""
    x, y = width / 2, height / 2
    return resampled(rounded([(x, -y), (x, y), (-x, y), (-x, -y)], radius, closed=True), count, closed=True)


def loop(
    start: ArrayLike,
    end: ArrayLike,
    out: ArrayLike,
    depth: float,
    *,
    exponent: float = 2.0,
    skew: float = 0.0,
    count: int = 44,
) -> Floats:
    """Return (count, 3) points of a handle's centre line from `start` to `end`, bulging by `depth`.

    Args:
        start: (3,) first end.
        end: (3,) second end.
        out: (3,) unit direction away from the body, across the line between the ends.
        depth: How far the loop stands off the line between the ends.
        exponent: 2 is half an ellipse; more is squarer (D-shaped); less is pointed.
        skew: In (-1, 1); positive bulges near the start (an ear), negative near the end.
        count: Number of points.
    """
    a, b, away = (np.asarray(v, float) for v in (start, end, out))
    angle = np.linspace(0.0, np.pi, OVERSAMPLING * count)
    along = np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** (2 / exponent)
    off = depth * np.sin(angle) ** (2 / exponent) * (1 + skew * along)
    line = (a + b) / 2 + along[:, None] * (a - b) / 2 + off[:, None] * away
    return resampled(line, count)

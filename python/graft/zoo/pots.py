"""Closed pouring vessels: teapot, kettle and watering can. Metres, z up; the spout points along +x."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from graft.objects import Floats
from graft.zoo.curves import loop, smooth
from graft.zoo.design import Design, Touch
from graft.zoo.surfaces import Mesh, facing, lathe, radius_at, ring, seated, side, tube, vessel

SINK = 0.004
"""How deep handles and spouts go into a body, metres."""


def _dome(radius: float, z: float, rise: float) -> Mesh:
    """Return a lid: a low rim and a dome of `rise` over it, starting at height `z`."""
    t = np.linspace(0.15, np.pi / 2, 14)
    cap = np.stack([radius * np.cos(t - 0.15), z + 0.004 + rise * (np.sin(t) - np.sin(0.15))], axis=1)
    return lathe(np.vstack([[(radius - 0.002, z - 0.003)], cap[:-1], [(0.004, cap[-1, 1])]]))


def _knob(radius: float, z: float, tall: float) -> Mesh:
    """Return a lid's knob: a stem and a flattened ball, its foot at height `z`."""
    t = np.linspace(-0.9, 1.35, 12)
    ball = np.stack([radius * np.cos(t), z + tall - radius * 0.75 + 0.75 * radius * np.sin(t)], axis=1)
    return lathe(np.vstack([[(radius * 0.6, z - 0.002), (radius * 0.45, z + 0.25 * tall)], ball]), step=0.0025)


def _spout(points: Floats, wide: float, narrow: float) -> Mesh:
    """Return a tapered spout with a bored mouth through `points` (n, 3) in the x-z plane."""
    path = smooth(points, 36)
    width = narrow + (wide - narrow) * (1 - np.linspace(0, 1, 36)) ** 1.5
    return tube(path, (0, 1, 0), width, dome=False, bore=min(0.012, narrow))


def _side_handle(body: Floats, low: float, high: float, depth: float, exponent: float, skew: float) -> Floats:
    """Return the centre line of a handle on the -x side between two heights of a body's outline."""
    start = (SINK - radius_at(body, high), 0, high)
    end = (SINK - radius_at(body, low), 0, low)
    return loop(start, end, (-1, 0, 0), depth, exponent=exponent, skew=skew, count=52)


def teapot(rng: Generator) -> Design:
    """Return a teapot: belly, lid, knob, curved spout, foot, and an ear at the side or a bail on top."""
    radius, height = rng.uniform(0.062, 0.082), rng.uniform(0.095, 0.125)
    low, mid, high, mouth = rng.uniform(0.86, 0.97), 1.0, rng.uniform(0.78, 0.93), rng.uniform(0.42, 0.54)
    body = side(height, [radius * k for k in (0.6, low, mid, high, mouth)], base=0.005, fillet=0.006, count=26)
    top = body[-1, 1]
    opening = radius * mouth
    rise = opening * rng.uniform(0.28, 0.5)
    knob = rng.uniform(0.009, 0.013)
    tip = radius + rng.uniform(0.055, 0.075)
    root = height * rng.uniform(0.40, 0.52)
    bend = rng.uniform(0.40, 0.58)
    mouth_z = height * rng.uniform(0.98, 1.12)
    spout = np.array(
        [
            (radius_at(body, root) - 0.014, 0, root),
            (radius + 0.006, 0, root + 0.010),
            (radius + bend * (tip - radius), 0, root + 0.45 * (mouth_z - root)),
            (radius + 0.75 * (tip - radius), 0, root + 0.80 * (mouth_z - root)),
            (tip, 0, mouth_z),
        ]
    )
    parts = {
        "body": lathe(body),
        "lid": _dome(opening + 0.003, top, rise),
        "knob": _knob(knob, top + 0.004 + rise * 0.98 - 0.001, knob * 1.7),
        "spout": _spout(spout, rng.uniform(0.034, 0.044), rng.uniform(0.013, 0.017)),
        "foot": ring(radius * 0.6 - 0.002, 0.005, 0.010, 0.010),
    }
    width, thick = rng.uniform(0.011, 0.017), rng.uniform(0.009, 0.012)
    if rng.random() < 0.65:
        path = _side_handle(
            body,
            height * rng.uniform(0.24, 0.36),
            height * rng.uniform(0.76, 0.88),
            rng.uniform(0.042, 0.055),
            rng.uniform(1.9, 3.0),
            rng.uniform(-0.1, 0.4),
        )
        parts["handle"] = tube(path, (0, 1, 0), width, thick, exponent=2.3)
        grip = path[int(np.argmin(path[:, 0]))]
        touch = Touch("handle", grip - np.array((thick, 0, 0)), (-1, 0, 0), "pour")
    else:
        z = height * 0.86
        reach = radius_at(body, z) - SINK
        peak = rng.uniform(0.075, 0.095) + (height - z)
        path = loop((-reach, 0, z), (reach, 0, z), (0, 0, 1), peak, exponent=rng.uniform(2.0, 3.0), count=60)
        parts["handle"] = tube(path, (0, 1, 0), width, thick, exponent=2.3)
        touch = Touch("handle", (0, 0, z + peak + thick), (0, 0, 1), "pour")
    return Design(parts, ("handle",), touch)


def kettle(rng: Generator) -> Design:
    """Return a kettle: a stove kettle with a bail, or an electric one with a D handle."""
    return _electric_kettle(rng) if rng.random() < 0.5 else _stove_kettle(rng)


def _stove_kettle(rng: Generator) -> Design:
    radius, height = rng.uniform(0.088, 0.105), rng.uniform(0.115, 0.145)
    body = side(
        height,
        [radius * k for k in (1.0, rng.uniform(0.98, 1.03), rng.uniform(0.86, 0.95), 0.68, 0.42)],
        base=0.003,
        fillet=0.012,
        count=26,
    )
    top, opening = body[-1, 1], radius * 0.42
    rise = opening * rng.uniform(0.2, 0.4)
    root = height * rng.uniform(0.45, 0.6)
    x = radius_at(body, root)
    reach = rng.uniform(0.05, 0.075)
    spout = np.array(
        [
            (x - 0.016, 0, root),
            (x + 0.4 * reach, 0, root + 0.4 * reach),
            (x + reach, 0, root + rng.uniform(0.9, 1.2) * reach),
        ]
    )
    foot = height * rng.uniform(0.74, 0.84)
    span = radius_at(body, foot) - SINK
    peak = rng.uniform(0.105, 0.125) + height - foot
    path = loop((-span, 0, foot), (span, 0, foot), (0, 0, 1), peak, exponent=rng.uniform(2.2, 3.6), count=64)
    bar = rng.uniform(0.009, 0.012)
    grip = path[22:42]
    swell = rng.uniform(0.020, 0.028) * (0.85 + 0.15 * np.sin(np.linspace(0, np.pi, len(grip))))
    parts = {
        "body": lathe(body),
        "lid": _dome(opening + 0.004, top, rise),
        "knob": _knob(0.011, top + 0.003 + rise * 0.98, 0.020),
        "spout": _spout(spout, rng.uniform(0.044, 0.056), rng.uniform(0.022, 0.028)),
        "handle": tube(path, (0, 1, 0), bar * rng.uniform(1.0, 1.8), bar),
        "base": ring(radius - 0.006, 0.0045, 0.014, 0.009),
    }
    graspable: tuple[str, ...] = ("handle",)
    held = "handle"
    if rng.random() < 0.6:
        parts["grip"] = tube(grip, (0, 1, 0), swell, 0.75 * swell, exponent=2.4)
        graspable, held = ("handle", "grip"), "grip"
    return Design(parts, graspable, Touch(held, (0, 0, foot + peak + 0.02), (0, 0, 1), "pour"))


def _electric_kettle(rng: Generator) -> Design:
    radius, height = rng.uniform(0.070, 0.082), rng.uniform(0.17, 0.205)
    taper = rng.uniform(0.66, 0.82)
    base = 0.022
    body = side(
        height,
        [radius * k for k in (1.0, rng.uniform(0.95, 1.03), (1 + taper) / 2, taper)],
        base=base,
        fillet=0.006,
        shoulder=0.006,
        count=24,
    )
    top = body[-1, 1]
    opening = radius * taper - 0.008
    rise = 0.012
    x = radius_at(body, top - 0.025)
    spout = np.array([(x - 0.02, 0, top - 0.045), (x + 0.006, 0, top - 0.026), (x + 0.026, 0, top - 0.004)])
    path = _side_handle(
        body,
        base + height * rng.uniform(0.14, 0.32),
        base + height * rng.uniform(0.86, 0.92),
        rng.uniform(0.050, 0.062),
        rng.uniform(2.6, 4.2),
        rng.uniform(0.0, 0.2),
    )
    width, thick = rng.uniform(0.022, 0.030), rng.uniform(0.014, 0.020)
    grip = path[int(np.argmin(path[:, 0]))]
    knob_z = top + 0.004 + rise * 0.85
    switch = np.stack(
        [
            np.linspace(path[6, 0] + 0.01, path[6, 0] - 0.012, 14),
            np.zeros(14),
            np.full(14, path[6, 2] + 0.5 * thick),
        ],
        1,
    )
    parts = {
        "body": lathe(body),
        "lid": _dome(opening, top, rise),
        "knob": _knob(0.009, knob_z - 0.001, 0.013),
        "spout": _spout(spout, 0.05, 0.030),
        "handle": tube(path, (0, 1, 0), width, thick, exponent=2.8),
        "base": lathe(
            [(radius + 0.006, 0), (radius + 0.010, 0.004), (radius + 0.008, 0.017), (radius - 0.004, 0.0225)],
            step=0.006,
        ),
        "switch": tube(switch, (0, 1, 0), 0.013, 0.009, exponent=3),
    }
    return Design(parts, ("handle",), Touch("handle", grip - np.array((thick, 0, 0)), (-1, 0, 0), "pour"))


def watering_can(rng: Generator) -> Design:
    """Return a watering can with a long spout and a rose, its handle over the top or behind."""
    radius, height = rng.uniform(0.075, 0.095), rng.uniform(0.15, 0.20)
    taper = rng.uniform(0.86, 1.0)
    wall = 0.003
    outline = side(height, (radius, radius * (1 + taper) / 2 * rng.uniform(1.0, 1.04), radius * taper), fillet=0.008)
    reach, rise = rng.uniform(0.16, 0.22), rng.uniform(0.95, 1.15) * height
    root = height * rng.uniform(0.16, 0.28)
    x = radius_at(outline, root)
    spout = smooth(
        [
            (x - 0.002, 0, root),
            (x + 0.30 * reach, 0, root + 0.22 * (rise - root)),
            (x + 0.7 * reach, 0, root + 0.66 * (rise - root)),
            (x + reach, 0, rise),
        ],
        44,
    )
    end = spout[-1] - spout[-2]
    end /= np.linalg.norm(end)
    rose_radius = rng.uniform(0.022, 0.032)
    rose = lathe(
        [
            (0.007, -0.012),
            (0.009, 0),
            (rose_radius, 0.028),
            (rose_radius + 0.001, 0.033),
            (rose_radius * 0.8, 0.037),
            (rose_radius * 0.4, 0.039),
        ],
        step=0.003,
    )
    brace_at = spout[26]
    brace = np.linspace((radius_at(outline, height - 0.015) - 0.002, 0, height - 0.015), brace_at, 16)
    thick, width = rng.uniform(0.011, 0.015), rng.uniform(0.015, 0.024)
    parts = {
        "body": vessel(outline, wall, 0.004),
        "rim": ring(outline[-1, 0] - 0.001, height, 0.008, 0.008),
        "spout": tube(spout, (0, 1, 0), np.linspace(0.036, 0.017, 44), dome=False),
        "rose": rose.moved(spout[-1], facing(end)),
        "brace": tube(brace, (0, 1, 0), 0.007),
    }
    behind = bool(rng.random() < 0.5)
    if not behind:
        front = outline[-1, 0] - 0.004
        low = height * rng.uniform(0.4, 0.6)
        back = 0.002 - radius_at(outline, low)
        line = [
            (front, 0, height),
            (0.45 * radius, 0, height + 0.075),
            (-0.35 * radius, 0, height + 0.085),
            (-radius - 0.035, 0, height + 0.02),
            (-radius - 0.035, 0, 0.5 * (height + low)),
            (back, 0, low),
        ]
        path = smooth(line, 64)
        crown = path[int(np.argmax(path[:, 2]))]
        touch = Touch("handle", crown + np.array((0, 0, thick)), (0, 0, 1), "pour")
    else:
        path = loop(
            (0.002 - radius_at(outline, 0.9 * height), 0, 0.9 * height),
            (0.002 - radius_at(outline, 0.25 * height), 0, 0.25 * height),
            (-1, 0, 0),
            rng.uniform(0.055, 0.07),
            exponent=rng.uniform(2.0, 3.2),
            skew=0.15,
            count=56,
        )
        grip = path[int(np.argmin(path[:, 0]))]
        touch = Touch("handle", grip - np.array((thick, 0, 0)), (-1, 0, 0), "pour")
    parts["handle"] = tube(path, (0, 1, 0), width, thick, exponent=2.4)
    if behind:
        parts["handle"] = seated(parts["handle"], outline, 0.002)
    return Design(parts, ("handle",), touch)

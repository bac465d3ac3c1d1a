"""Hand tools as they lie on a table: hammer, screwdriver, knife, scissors, flashlight. Metres, along x."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from graft.objects import Floats
from graft.zoo.curves import rectangle, smooth, spline, superellipse
from graft.zoo.design import Design, Touch
from graft.zoo.surfaces import Mesh, facing, lathe, merged, ring, side, slab, tube, widened

ALONG = facing((1, 0, 0))
"""Turns a lathe from z to x."""


def _straight(x0: float, x1: float, count: int = 40) -> Floats:
    """Return (count, 3) points along x."""
    x = np.linspace(x0, x1, count)
    return np.stack([x, np.zeros(count), np.zeros(count)], axis=1)


def hammer(rng: Generator) -> Design:
    """Return a hammer: claw, cross-peen or ball-peen, with a plain or a sleeved handle."""
    length, size = rng.uniform(0.25, 0.34), rng.uniform(0.022, 0.030)
    t = np.linspace(0, 1, 44)
    sleeved = bool(rng.random() < 0.5)
    thick = 0.024 * spline((1.0, 1.12, 1.0, 0.8, 0.78, 0.8), t)
    if sleeved:
        thick = np.full(44, 0.017)
    shaft = _straight(-length, size * 0.55, 44)
    reach = rng.uniform(0.040, 0.055)
    cheek = np.stack([np.zeros(24), np.linspace(-0.025, 0.035, 24), np.zeros(24)], axis=1)
    face_radius = size * rng.uniform(0.52, 0.62)
    face = side(
        reach - 0.022,
        (face_radius * 0.72, face_radius * 0.74, face_radius, face_radius),
        shoulder=0.002,
        base=0.03,
        count=18,
    )
    parts: dict[str, Mesh] = {
        "handle": tube(shaft, (0, 1, 0), thick * 1.25, thick, exponent=2.3),
        "head": tube(cheek, (0, 0, 1), size, size * 1.1, exponent=4.0, dome=False),
        "face": lathe(face).moved(rotation=facing((0, 1, 0))),
    }
    form = rng.choice(3)
    back = -0.022
    if form == 0:
        prongs = []
        curl, tip = rng.uniform(0.014, 0.028), rng.uniform(0.050, 0.064)
        for sign in (-1.0, 1.0):
            line = smooth(
                [
                    (0, back + 0.012, sign * 0.004),
                    (0, back - 0.4 * tip, sign * 0.007),
                    (-0.35 * curl, back - 0.75 * tip, sign * 0.009),
                    (-curl, back - tip, sign * 0.011),
                ],
                30,
            )
            prongs.append(
                tube(
                    line,
                    (0, 0, 1),
                    np.linspace(0.014, 0.011, 30),
                    np.linspace(size * 0.95, 0.004, 30),
                    exponent=3.0,
                    segments=18,
                )
            )
        parts["claw"] = merged(*prongs)
    elif form == 1:
        line = np.stack([np.zeros(26), np.linspace(back + 0.006, back - 0.045, 26), np.zeros(26)], axis=1)
        parts["peen"] = tube(line, (0, 0, 1), size * 0.95, np.linspace(size, 0.005, 26), exponent=3.4, dome=False)
    else:
        ball = np.linspace(-1.15, np.pi / 2 - 0.06, 18)
        r = size * 0.55
        outline = np.stack([r * np.cos(ball), 0.030 + r + r * np.sin(ball)], axis=1)
        parts["peen"] = lathe(np.vstack([[(r * 0.62, 0.012)], outline]), step=0.004).moved(rotation=facing((0, -1, 0)))
    held = "handle"
    if sleeved:
        grip = _straight(-length - 0.004, -length * rng.uniform(0.45, 0.6), 40)
        swell = rng.uniform(0.025, 0.030) * spline((1.08, 0.95, 1.05, 1.0, 0.9), np.linspace(0, 1, 40))
        parts["grip"] = tube(grip, (0, 1, 0), swell * 1.15, swell, exponent=2.4)
        held = "grip"
    graspable = ("handle", "grip") if sleeved else ("handle",)
    near = (-0.78 * length, 0, 0.03)
    return Design(parts, graspable, Touch(held, near, (0, 0, 1), "strike"), stands=False)


def screwdriver(rng: Generator) -> Design:
    """Return a screwdriver: fluted handle, collar, shaft, and a flat or a cross tip."""
    grip, radius = rng.uniform(0.085, 0.115), rng.uniform(0.0125, 0.017)
    reach, rod = rng.uniform(0.075, 0.15), rng.uniform(0.0026, 0.0036)
    flutes = int(rng.integers(5, 9))
    outline = side(
        grip, [radius * k for k in (0.8, 1.0, 0.98, 1.02, 0.74, 0.82)], fillet=0.006, shoulder=0.003, count=26
    )
    handle = lathe(outline, section=superellipse(56))

    def flute(vertices: Floats) -> Floats:
        angle = np.arctan2(vertices[:, 1], vertices[:, 0])
        along = np.clip(np.sin(np.pi * (vertices[:, 2] / grip - 0.06) / 0.72), 0, 1) * (vertices[:, 2] < 0.78 * grip)
        scale = 1 - 0.11 * along * (0.5 + 0.5 * np.cos(flutes * angle))
        return widened(vertices, scale)

    tip = grip + reach
    end = _straight(tip - 0.004, tip + 0.012, 24)
    blade = np.linspace(0, 1, 24)
    parts = {
        "handle": handle.warped(flute).moved(rotation=ALONG),
        "collar": lathe(side(0.012, (radius * 0.66, radius * 0.6, rod * 1.5), base=grip - 0.003, count=16)).moved(
            rotation=ALONG
        ),
        "shaft": lathe(side(reach, (rod, rod), base=grip - 0.002, count=24)).moved(rotation=ALONG),
    }
    if rng.random() < 0.5:
        parts["tip"] = tube(
            end,
            (0, 1, 0),
            2 * rod * spline((0.9, 1.5, 1.5, 1.3), blade),
            2 * rod * (1 - 0.82 * blade),
            exponent=4,
            dome=False,
        )
    else:
        taper = 2 * rod * (1 - 0.75 * blade**1.3)
        cross = [tube(end, axis, taper, 0.42 * taper, exponent=4, dome=False) for axis in ((0, 1, 0), (0, 0, 1))]
        parts["tip"] = merged(*cross)
    return Design(parts, ("handle",), Touch("handle", (0.45 * grip, 0, radius), (0, 0, 1), "turn"), stands=False)


def knife(rng: Generator) -> Design:
    """Return a kitchen knife: blade with a belly, bolster, handle with rivets, butt."""
    reach, tall = rng.uniform(0.13, 0.22), rng.uniform(0.026, 0.046)
    grip, height = rng.uniform(0.105, 0.125), rng.uniform(0.022, 0.028)
    t = np.linspace(0, 1, 48)
    point = rng.uniform(0.5, 0.9)
    run = np.clip((t - 0.35) / 0.65, 0, 1)
    spine = height * 0.42 - 0.45 * tall * point * run**2
    width = np.maximum(tall * (1 - run**2.4), 0.0014)
    blade = np.stack([0.004 + reach * t, spine - width / 2, 0 * t], axis=1)
    s = np.linspace(0, 1, 40)
    drop = rng.uniform(-0.004, 0.008)
    line = np.stack([-grip * s, -drop * np.sin(np.pi * s / 2) ** 2, 0 * s], axis=1)
    swell = height * spline((0.92, 0.86, 1.0, 0.96, 1.12), s)
    thick = rng.uniform(0.013, 0.017) * spline((0.9, 1.0, 1.05, 1.0), s)
    parts = {
        "blade": tube(blade, (0, 1, 0), width, 0.0024 - 0.0012 * t, exponent=1.6, dome=False),
        "bolster": tube(
            _straight(-0.006, 0.008, 16),
            (0, 1, 0),
            np.linspace(height * 0.98, height * 0.8, 16),
            np.linspace(0.015, 0.007, 16),
            exponent=2.8,
            dome=False,
            segments=28,
        ),
        "handle": tube(line, (0, 1, 0), swell, thick, exponent=rng.uniform(2.2, 3.4)),
    }
    if rng.random() < 0.6:
        pins = []
        for share in (0.22, 0.5, 0.78):
            i = int(share * 39)
            half = thick[i] / 2 + 0.0003
            pins.append(
                lathe(side(2 * half, (0.003, 0.003), base=-half, count=8), section=superellipse(18)).moved(line[i])
            )
        parts["rivets"] = merged(*pins)
    i = 14  # between two rivets
    near = line[i] + np.array((0, 0, thick[i]))
    return Design(parts, ("handle",), Touch("handle", near, (0, 0, 1), "cut"), stands=False)


def scissors(rng: Generator) -> Design:
    """Return scissors a little open: two blades that cross at a pivot, two finger loops, equal or unequal."""
    reach, back = rng.uniform(0.07, 0.11), rng.uniform(0.035, 0.055)
    opening = rng.uniform(0.10, 0.24)
    thick = 0.003
    parts: dict[str, Mesh] = {}
    labels: dict[str, str] = {}
    large = rng.uniform(1.15, 1.6) if rng.random() < 0.6 else 1.0
    rod = rng.uniform(0.008, 0.011)
    for name, sign in (("left", 1.0), ("right", -1.0)):
        spread = sign * (0.010 + 0.25 * opening * back)
        line = smooth(
            [
                (-back, -spread * 1.2, 0),
                (-0.5 * back, -spread * 0.7, 0),
                (0, 0, 0),
                (reach, sign * opening * reach / 2, 0),
            ],
            48,
        )
        t = np.linspace(0, 1, 48)
        width = spline((0.007, 0.009, 0.016, 0.014, 0.010, 0.0018), t)
        z = sign * thick * 0.5
        blade = tube(line, (0, 1, 0), width, thick, exponent=2.6, dome=False)
        parts[f"blade_{name}"] = blade.moved((0, 0, z))
        scale = large if name == "right" else 1.0
        a, b = 0.017 * scale, 0.0125 * (1 + 0.4 * (scale - 1))
        angle = np.linspace(0, 2 * np.pi, 56, endpoint=False)
        middle = line[0] + np.array((-a * 0.92, -sign * 0.55 * b, 0))
        tilt = -sign * -0.25
        x, y = a * np.cos(angle), b * np.sin(angle)
        bow = middle + np.stack(
            [x * np.cos(tilt) - y * np.sin(tilt), x * np.sin(tilt) + y * np.cos(tilt), 0 * x], axis=1
        )
        parts[f"handle_{name}"] = tube(bow, (0, 0, 1), rod, rod * 0.72, closed=True, exponent=2.4)
        labels |= {f"blade_{name}": "blade", f"handle_{name}": "handle"}
        if name == "right":
            held, outer = bow, middle
    parts["pivot"] = lathe(side(0.008, (0.0052, 0.0055, 0.005), base=-0.004, fillet=0.001, shoulder=0.001, count=10))
    i = int(np.argmax(np.linalg.norm(held - outer, axis=1) * (held[:, 0] < outer[0])))
    touch = Touch("handle_right", held[i] + np.array((0, 0, rod)), (0, 0, 1), "cut")
    return Design(parts, ("handle_left", "handle_right"), touch, labels, stands=False)


def flashlight(rng: Generator) -> Design:
    """Return a flashlight: knurled barrel, flared head, lens, switch and tail cap."""
    length, radius = rng.uniform(0.10, 0.17), rng.uniform(0.0125, 0.018)
    flare = rng.uniform(1.25, 1.9)
    head = rng.uniform(0.035, 0.055)
    outline = side(length, (radius, radius, radius), count=38)
    knurl = int(rng.integers(16, 24))

    def knurled(vertices: Floats) -> Floats:
        angle = np.arctan2(vertices[:, 1], vertices[:, 0])
        on = (vertices[:, 2] > 0.1 * length) & (vertices[:, 2] < 0.72 * length)
        scale = 1 - 0.035 * on * (0.5 + 0.5 * np.cos(knurl * angle))
        return widened(vertices, scale)

    wide = radius * flare
    bezel = length + head - 0.004
    parts = {
        "body": lathe(outline, section=superellipse(64)).warped(knurled).moved(rotation=ALONG),
        "head": lathe(
            side(
                head,
                (radius * 1.08, radius * 1.1, wide, wide, wide),
                base=length - 0.004,
                fillet=0.002,
                shoulder=0.001,
                count=22,
            )
        ).moved(rotation=ALONG),
        "bezel": ring(wide - 0.001, bezel, 0.006, 0.007).moved(rotation=ALONG),
        "lens": lathe(
            [
                (wide - 0.004, bezel - 0.003),
                (wide - 0.004, bezel + 0.001),
                (wide * 0.6, bezel + 0.0018),
                (wide * 0.2, bezel + 0.002),
            ],
            step=0.0025,
        ).moved(rotation=ALONG),
        "tail_cap": lathe(
            side(
                0.020,
                (radius * 0.98, radius * 1.1, radius * 1.1),
                base=-0.014,
                fillet=0.003,
                shoulder=0.001,
                count=14,
            )
        ).moved(rotation=ALONG),
        "switch": slab(rectangle(40, 0.016, 0.009, 0.004), 0.005, 0.0015).moved((0.82 * length, 0, radius - 0.0025)),
    }
    return Design(parts, ("body",), Touch("body", (0.45 * length, 0, radius), (0, 0, 1), "light"), stands=False)

"""Bottles: wine, detergent, shampoo and spray. Metres, z up; nozzles point along +x."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from graft.objects import Floats
from graft.zoo.curves import loop, smooth, spline, superellipse
from graft.zoo.design import Design, Touch
from graft.zoo.surfaces import SEGMENTS, Mesh, facing, lathe, loft, radius_at, ring, side, slab, tube, widened


def _ribbed(mesh: Mesh, ribs: int, depth: float) -> Mesh:
    """Return a lathe about z with `ribs` grooves of `depth` around it, as on a screw cap."""

    def groove(vertices: Floats) -> Floats:
        angle = np.arctan2(vertices[:, 1], vertices[:, 0])
        radius = np.linalg.norm(vertices[:, :2], axis=1)
        edge = radius > 0.9 * radius.max()
        scale = 1 - edge * depth * (0.5 + 0.5 * np.cos(ribs * angle)) / np.maximum(radius, depth)
        return widened(vertices, scale)

    return mesh.warped(groove)


def _cap(radius: float, z: float, height: float, *, taper: float = 1.0, ribs: int = 20) -> Mesh:
    """Return a screw cap standing at height `z`."""
    outline = side(height, (radius, radius * taper), base=z, fillet=0.001, shoulder=min(0.003, height / 4), count=10)
    return _ribbed(lathe(outline, section=superellipse(80)), ribs, 0.0012)


def wine_bottle(rng: Generator) -> Design:
    """Return a wine bottle of the Bordeaux, the Burgundy or the flute form."""
    radius, tall = rng.uniform(0.034, 0.0385), rng.uniform(0.285, 0.33)
    neck = rng.uniform(0.0135, 0.0155)
    form = rng.choice(3)
    low, high = ((0.545, 0.66), (0.45, 0.665), (0.40, 0.70))[form]
    low, high = low * tall, high * tall
    body = side(low, (radius, radius, radius), fillet=0.005, count=14)
    power = (1.15, 1.1, 1.0)[form]
    t = np.linspace(0, 1, 16)[1:]
    blend = 0.5 * (1 + np.cos(np.pi * t ** (1 / power)))
    shoulder = np.stack([neck + 0.0012 + (radius - neck - 0.0012) * blend, low + (high - low) * t], axis=1)
    neck_line = side(tall - high + 0.004, (neck + 0.0012, neck, neck * 0.97), base=high - 0.004, count=22)
    lip = tall - 0.012
    parts = {
        "body": lathe(np.vstack([body, shoulder]), step=0.012),
        "neck": lathe(neck_line),
        "lip": ring(neck - 0.0005, lip, 0.0075, rng.uniform(0.006, 0.012)),
        "cork": lathe(side(0.022, (0.0095, 0.0098, 0.0095), base=tall - 0.010, shoulder=0.002, count=12)),
    }
    if rng.random() < 0.6:
        z, h = low * rng.uniform(0.22, 0.3), low * rng.uniform(0.4, 0.55)
        parts["label"] = lathe(
            np.array([(radius - 0.001, z), (radius + 0.0005, z), (radius + 0.0005, z + h), (radius - 0.001, z + h)]),
            step=0.008,
            closed=True,
        )
    # By the body, above the label, as one pours; also what an open hand of 8 cm takes.
    return Design(parts, ("body", "neck"), Touch("body", (radius, 0, 0.92 * low), (1, 0, 0), "pour"))


def detergent(rng: Generator) -> Design:
    """Return a laundry-detergent jug: flattened body with a hollow at one side that the handle bridges."""
    height, right = rng.uniform(0.20, 0.255), rng.uniform(0.070, 0.085)
    left = right * rng.uniform(0.95, 1.15)
    notch = rng.uniform(0.50, 0.62)
    z = np.linspace(0, 1, 40)
    r = spline([right * k for k in (0.94, 1.0, 1.0, 0.96, 0.74, 0.36)], z)
    hollow = rng.uniform(0.50, 0.60)
    inner = spline([left * k for k in (0.94, 1.0, 0.98, 0.9, 0.62, 0.36)], z)
    inner = inner - notch * left * np.exp(-(((z - hollow) / 0.17) ** 2)) * (z < 0.99)
    x0, x1 = -np.maximum(inner, 0.020), r
    depth = spline([k * rng.uniform(0.036, 0.042) for k in (0.95, 1.0, 1.0, 0.95, 0.78, 0.5)], z)
    edge = 0.010
    heights = z * height
    near = np.clip(1 - heights / edge, 0, 1)
    inset = edge * (1 - np.sqrt(1 - near**2))
    half, middle = (x1 - x0) / 2 - inset, (x1 + x0) / 2
    section = superellipse(SEGMENTS, exponent=rng.uniform(2.6, 3.6))
    rings = np.empty((len(z), SEGMENTS, 3))
    rings[:, :, 0] = middle[:, None] + half[:, None] * section[:, 0]
    rings[:, :, 1] = (depth - inset)[:, None] * section[:, 1]
    rings[:, :, 2] = heights[:, None]
    mouth = float(middle[-1])
    upper, lower = hollow + 0.30, hollow - 0.30
    start = (float(np.interp(upper, z, x0)) + 0.010, 0, upper * height)
    end = (float(np.interp(lower, z, x0)) + 0.012, 0, lower * height)
    width, thick = rng.uniform(0.024, 0.032), rng.uniform(0.018, 0.024)
    chord = (np.array(end) - start) / np.linalg.norm(np.array(end) - start)
    # Across the chord, away from the body (-x): the chord runs downwards.
    out: Floats = np.cross((0.0, 1.0, 0.0), chord)
    path = loop(start, end, out, rng.uniform(0.012, 0.024), exponent=rng.uniform(2.2, 3.0), count=52)
    cap = rng.uniform(0.019, 0.024)
    cap_height = rng.uniform(0.030, 0.050)
    parts = {
        "body": loft(rings),
        "neck": lathe(side(0.024, (0.020, 0.018, 0.018), base=height - 0.006, count=12)).moved((mouth, 0, 0)),
        "collar": ring(cap - 0.002, height + 0.006, 0.006, 0.005).moved((mouth, 0, 0)),
        "cap": _cap(cap, height + 0.007, cap_height, taper=rng.uniform(0.86, 1.0)).moved((mouth, 0, 0)),
        "handle": tube(path, (0, 1, 0), width, thick, exponent=2.3),
    }
    grip = path[len(path) // 2] + out * thick
    return Design(parts, ("handle",), Touch("handle", grip, out, "pour"))


def shampoo(rng: Generator) -> Design:
    """Return a shampoo bottle, oval or round, with a flip cap or a pump."""
    height, half = rng.uniform(0.14, 0.19), rng.uniform(0.031, 0.038)
    flat = rng.uniform(0.62, 1.0)
    section = superellipse(SEGMENTS, 1.0, flat, rng.uniform(2.0, 3.0))
    waist, shoulder = rng.uniform(0.88, 1.04), rng.uniform(0.72, 0.95)
    body = side(height, [half * k for k in (0.96, 1.0, waist, 0.98, shoulder)], fillet=0.006, shoulder=0.012, count=24)
    shape: dict[str, Mesh] = {"body": lathe(body, section=section)}
    label = superellipse(40, half * 0.62, height * 0.27, 5.0)
    bend = rng.uniform(0.45, 0.5) * height

    def onto_front(vertices: Floats) -> Floats:
        x, z = vertices[:, 0], vertices[:, 1] + bend
        radius = np.interp(z, body[:, 1], body[:, 0])
        edge = _reach(x / radius, section) * radius
        return np.stack([x, -(edge + vertices[:, 2]), z], axis=1)

    shape["label"] = slab(label, 0.0022, 0.0004).moved((0, 0, -0.0014)).warped(onto_front)
    if rng.random() < 0.5:
        radius = rng.uniform(0.45, 0.8) * half
        shape["neck"] = lathe(side(0.012, (radius * 0.8, radius * 0.8), base=height - 0.005, count=12))
        cap_height = rng.uniform(0.022, 0.034)
        oval = superellipse(SEGMENTS, 1.0, max(flat, 0.8), 2.2)
        cap = side(cap_height, (radius, radius * 0.97), base=height + 0.003, fillet=0.001, shoulder=0.004, count=12)
        shape["cap"] = lathe(cap, section=oval)
    else:
        radius = rng.uniform(0.013, 0.017)
        shape["collar"] = _cap(radius, height - 0.003, 0.018)
        stem = height + 0.013
        rise = rng.uniform(0.020, 0.030)
        shape["stem"] = lathe(side(rise, (0.005, 0.005), base=stem, count=18), step=0.003)
        top = stem + rise
        reach = rng.uniform(0.030, 0.042)
        path = smooth(
            [
                (-0.010, 0, top + 0.004),
                (0.010, 0, top + 0.005),
                (reach * 0.8, 0, top + 0.003),
                (reach, 0, top - 0.006),
            ],
            32,
        )
        shape["nozzle"] = tube(
            path, (0, 1, 0), np.linspace(0.022, 0.009, 32), np.linspace(0.013, 0.008, 32), exponent=2.5
        )
    touch = Touch("body", (0, half * flat, 0.55 * height), (0, 1, 0), "squeeze")
    return Design(shape, ("body",), touch)


def _reach(x: Floats, section: Floats) -> Floats:
    """Return how far (y > 0) the loop `section` (m, 2) reaches at each `x`."""
    upper = section[section[:, 1] >= 0]
    order = np.argsort(upper[:, 0])
    reach: Floats = np.interp(x, upper[order, 0], upper[order, 1])
    return reach


def spray(rng: Generator) -> Design:
    """Return a trigger spray: bottle, waisted neck that the hand takes to spray, collar, head, trigger, nozzle."""
    height, half = rng.uniform(0.125, 0.165), rng.uniform(0.033, 0.0385)
    flat, corner = rng.uniform(0.66, 1.0), rng.uniform(2.0, 3.0)
    section = superellipse(SEGMENTS, 1.0, flat, corner)
    waist = rng.uniform(0.9, 1.04)
    body = side(height, [half * k for k in (0.97, 1.0, waist, 0.97, 0.62)], fillet=0.006, shoulder=0.006, count=24)
    grip, low = rng.uniform(0.0145, 0.018), height - 0.008
    tall = rng.uniform(0.045, 0.062)
    neck = side(tall, (half * 0.62 * max(flat, 0.75), grip * 1.12, grip, grip * 1.02), base=low, count=24)
    top = low + tall
    head = top + rng.uniform(0.030, 0.036)
    back, front = rng.uniform(0.022, 0.032), rng.uniform(0.038, 0.050)
    t = np.linspace(0, 1, 34)
    path = np.stack([-back + (back + front) * t, 0 * t, head - 0.004 * t], axis=1)
    thick = spline((0.024, 0.032, 0.034, 0.027, 0.022), t)
    reach = rng.uniform(0.030, 0.040)
    trigger = smooth(
        [
            (0.6 * front, 0, head - 0.008),
            (0.72 * front, 0, head - 0.022),
            (0.66 * front, 0, head - 0.022 - 0.5 * reach),
            (0.86 * front, 0, head - 0.020 - reach),
        ],
        32,
    )
    parts = {
        "body": lathe(body, section=section),
        "neck": lathe(neck),
        "collar": _cap(grip + 0.003, top - 0.004, 0.020),
        "head": tube(path, (0, 1, 0), spline((0.022, 0.026, 0.026, 0.024, 0.020), t), thick, exponent=4.2),
        "trigger": tube(trigger, (0, 1, 0), np.linspace(0.014, 0.011, 32), np.linspace(0.009, 0.005, 32), exponent=2.8),
        "nozzle": lathe(
            [(0.0085, -0.003), (0.0085, 0.008), (0.0070, 0.011), (0.0035, 0.0115), (0.0030, 0.009)],
            step=0.0015,
            section=superellipse(24, exponent=3.0),
        ).moved((front + 0.006, 0, head - 0.004), facing((1, 0, 0))),
    }
    at = low + 0.55 * tall
    return Design(parts, ("neck", "body"), Touch("neck", (-radius_at(neck, at), 0, at), (-1, 0, 0), "spray"))

"""Bags that stand: briefcase and handbag. Metres, z up, wide along x, the front towards -y."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from graft.objects import Floats
from graft.zoo.curves import loop, rectangle, spline, superellipse
from graft.zoo.design import Design, Touch
from graft.zoo.surfaces import Mesh, facing, lathe, loft, merged, slab, tube

SEGMENTS = 64
"""Points around a bag."""

STANDING = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
"""Turns a slab that lies in x-y so that its outline stands in x-z and its thickness runs towards -y."""


def _standing(outline: Floats, thickness: float, edge: float, y: float, z: float) -> Mesh:
    """Return a slab that stands with its back at `y` and its middle at height `z`."""
    return slab(outline, thickness, edge).moved((0, y, z), STANDING)


def briefcase(rng: Generator) -> Design:
    """Return a hard briefcase of two shells, with a handle on two mounts, latches and feet."""
    width, height = rng.uniform(0.38, 0.46), rng.uniform(0.27, 0.34)
    thick = rng.uniform(0.085, 0.13)
    outline = rectangle(SEGMENTS * 2, width, height, rng.uniform(0.02, 0.05))
    split = rng.uniform(0.35, 0.5) * thick
    edge = rng.uniform(0.010, 0.018)
    foot = 0.006
    z = foot + height / 2
    top = foot + height
    span, rise = rng.uniform(0.055, 0.070), rng.uniform(0.036, 0.048)
    path = loop(
        (-span, 0, top + 0.004),
        (span, 0, top + 0.004),
        (0, 0, 1),
        rise,
        exponent=rng.uniform(2.6, 5.0),
        count=56,
    )
    swell = 0.75 + 0.25 * np.sin(np.linspace(0, np.pi, 56)) ** 0.8
    grip = rng.uniform(0.018, 0.026)
    mount = slab(rectangle(40, 0.032, 0.026, 0.006), 0.010, 0.003)
    latch = slab(rectangle(40, 0.036, 0.024, 0.005), 0.010, 0.003)
    reach = width * rng.uniform(0.28, 0.36)
    feet = [
        lathe([(0.009, 0), (0.010, 0.002), (0.010, 0.009)], step=0.003).moved((x, y, 0))
        for x in (-0.38 * width, 0.38 * width)
        for y in (-0.26 * thick, 0.26 * thick)
    ]
    parts = {
        "body": _standing(outline, thick - split, edge, thick / 2, z),
        "lid": _standing(outline, split + 0.001, edge, split - thick / 2, z),
        "handle": tube(path, (0, 1, 0), grip * swell, 0.72 * grip * swell, exponent=2.4),
        "mount_left": mount.moved((-span, 0, top - 0.002)),
        "mount_right": mount.moved((span, 0, top - 0.002)),
        "latch_left": latch.moved((-reach, split - thick / 2, top - 0.006)),
        "latch_right": latch.moved((reach, split - thick / 2, top - 0.006)),
        "feet": merged(*feet),
    }
    labels = {"mount_left": "mount", "mount_right": "mount", "latch_left": "latch", "latch_right": "latch"}
    return Design(parts, ("handle",), Touch("handle", (0, 0, top + rise + grip), (0, 0, 1), "carry"), labels)


def handbag(rng: Generator) -> Design:
    """Return a soft handbag with one or two arched handles, a flap or a zip, a clasp and a base."""
    width, height = rng.uniform(0.25, 0.34), rng.uniform(0.17, 0.24)
    deep = rng.uniform(0.09, 0.13)
    t = np.linspace(0, 1, 32)
    lean, puff = rng.uniform(0.74, 1.06), rng.uniform(1.0, 1.12)
    top_deep = rng.uniform(0.26, 0.45)
    half = width / 2 * spline((0.98, (1 + lean) / 2 * puff, lean), t)
    half_deep = deep / 2 * spline((0.95, 1.04, 0.82 * (0.4 + top_deep), top_deep), t)
    turn = np.minimum(t, 0.08) / 0.08
    soft = 0.012 * (1 - np.sqrt(1 - (1 - turn) ** 2))
    section = superellipse(SEGMENTS, exponent=rng.uniform(3.2, 5.0))
    rings = np.empty((len(t), SEGMENTS, 3))
    rings[:, :, 0] = (half - soft)[:, None] * section[:, 0]
    rings[:, :, 1] = (half_deep - soft)[:, None] * section[:, 1]
    rings[:, :, 2] = 0.004 + height * t[:, None]
    top = 0.004 + height
    mouth, lip = float(half[-1]), float(half_deep[-1])
    base = superellipse(SEGMENTS, width / 2 * 0.94, deep / 2 * 0.90, 4.0)
    parts = {"body": loft(rings), "base": slab(base, 0.008, 0.003)}
    clasp = lathe([(0.011, 0), (0.012, 0.003), (0.010, 0.007), (0.004, 0.009)], step=0.003)
    double = bool(rng.random() < 0.45)
    if not double and rng.random() < 0.7:
        over = rng.uniform(0.45, 0.6)
        parts["flap"] = _flap(0.93 * mouth, lip, half_deep, t, height, over)
        fall = 1 - over
        y = float(np.interp(fall, t, half_deep))
        parts["clasp"] = clasp.moved((0, -y - 0.003, 0.004 + height * fall + 0.016), facing((0, -1, 0)))
    else:
        line = np.stack([np.linspace(-0.95 * mouth, 0.95 * mouth, 40), np.zeros(40), np.full(40, top)], axis=1)
        parts["zip"] = tube(line, (0, 1, 0), 0.012, 0.006, exponent=3.0)
        parts["clasp"] = clasp.moved((0.95 * mouth, 0, top), facing((0.6, 0, 1)))
    span = mouth * rng.uniform(0.42, 0.62)
    rise = rng.uniform(0.09, 0.15)
    strap = rng.uniform(0.011, 0.017)
    wide = strap * rng.uniform(1.0, 1.9)
    labels: dict[str, str] = {}
    if double:
        gap = lip + 0.001
        low = top - 0.035
        low_gap = float(np.interp(1 - 0.035 / height, t, half_deep)) + 0.001
        for name, sign in (("front", -1.0), ("back", 1.0)):
            out = np.array([0.0, sign * 0.18, 1.0]) / np.hypot(0.18, 1.0)
            path = loop(
                (-span, sign * low_gap, low),
                (span, sign * low_gap, low),
                out,
                rise + 0.035,
                exponent=rng.uniform(2.2, 2.8),
                count=60,
            )
            lifted = np.where(
                path[:, 2] < top, sign * (low_gap + (gap - low_gap) * (path[:, 2] - low) / 0.035), path[:, 1]
            )
            path[:, 1] = np.where(sign * path[:, 1] < sign * lifted, lifted, path[:, 1])
            parts[f"handle_{name}"] = tube(path, (0, 1, 0), 0.72 * strap, strap, exponent=2.4)
            labels[f"handle_{name}"] = "handle"
        crown = path[30] + out * strap
        return Design(parts, ("handle_front", "handle_back"), Touch("handle_back", crown, out, "carry"), labels)
    path = loop(
        (-span, 0, top - 0.004),
        (span, 0, top - 0.004),
        (0, 0, 1),
        rise,
        exponent=rng.uniform(2.0, 2.8),
        count=60,
    )
    parts["handle"] = tube(path, (0, 1, 0), wide, 0.8 * strap, exponent=2.4)
    for name, x in (("left", -span), ("right", span)):
        parts[f"ring_{name}"] = lathe([(wide * 0.8, 0), (wide * 0.8, 0.006), (wide * 0.62, 0.014)], step=0.002).moved(
            (x, 0, top - 0.003)
        )
        labels[f"ring_{name}"] = "ring"
    return Design(parts, ("handle",), Touch("handle", (0, 0, top + rise + strap), (0, 0, 1), "carry"), labels)


def _flap(half: float, lip: float, half_deep: Floats, t: Floats, height: float, over: float) -> Mesh:
    """Return a flap: from the back edge over the top and down the front by the share `over` of the height."""
    down = np.linspace(1.0, 1 - over, 24)
    front = np.stack([-np.interp(down, t, half_deep) - 0.002, 0.004 + height * down], axis=1)
    back = np.stack([np.interp([0.9, 1.0], t, half_deep) + 0.001, 0.004 + height * np.array([0.9, 1.0])], axis=1)
    over_top = np.array([(lip * 0.4, 0.004 + height + 0.004), (-lip * 0.4, 0.004 + height + 0.004)])
    line = np.vstack([back, over_top, front])
    reach = np.concatenate([np.zeros(4), np.linspace(0, 1, 24)])
    wide = 2 * half * (1 - 0.35 * np.clip(reach - 0.55, 0, 1) ** 1.5)
    path = np.stack([np.zeros(len(line)), line[:, 0], line[:, 1]], axis=1)
    return tube(path, (1, 0, 0), wide, 0.006, exponent=7.0, segments=56, dome=False)

"""Vessels that one looks into: bucket, mug, jug, pan and basket. Metres, z up; handles stick out along x."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from graft.objects import Floats
from graft.zoo.curves import loop, superellipse
from graft.zoo.design import Design, Touch
from graft.zoo.surfaces import (
    Mesh,
    facing,
    lathe,
    radius_at,
    ring,
    seated,
    side,
    tube,
    vessel,
    widened,
)

SINK = 0.6
"""How deep a handle's end goes into a wall, as a share of the wall, so that it does not come out inside."""


def water_bucket(rng: Generator) -> Design:
    """Return a tapered bucket with a rim, two ears and a bail, with or without a grip."""
    height, top = rng.uniform(0.21, 0.30), rng.uniform(0.125, 0.16)
    bottom = top * rng.uniform(0.68, 0.86)
    wall = rng.uniform(0.002, 0.0035)
    bulge = rng.uniform(0.0, 0.05)
    body = side(height, (bottom, (bottom + top) / 2 * (1 + bulge), top), fillet=0.008)
    parts = {
        "body": vessel(body, wall, 0.004),
        "rim": ring(top + 0.001, height, 0.009, rng.uniform(0.007, 0.014)),
        "base": ring(radius_at(body, 0.004) - 0.002, 0.004, 0.008, 0.012),
    }
    z = height - rng.uniform(0.018, 0.03)
    x = radius_at(body, z)
    lean = (radius_at(body, z + 0.01) - radius_at(body, z - 0.01)) / 0.02
    ear = lathe([(0.015, -0.001), (0.015, 0.007), (0.011, 0.010), (0.008, 0.014)], step=0.003)
    parts["ear_left"] = ear.moved((-x, 0, z), facing((-1, 0, -lean)))
    parts["ear_right"] = ear.moved((x, 0, z), facing((1, 0, -lean)))
    has_grip = bool(rng.random() < 0.6)
    wire = rng.uniform(0.004, 0.006) if has_grip else rng.uniform(0.009, 0.013)
    fall = rng.uniform(0.0, 0.35)
    out = np.array([0.0, np.sin(fall), np.cos(fall)])
    depth = (x + 0.01) * rng.uniform(0.85, 1.15)
    hinge = x + 0.010
    bail = loop((-hinge, 0, z), (hinge, 0, z), out, depth, exponent=rng.uniform(1.9, 2.5), count=60)
    across = np.cross((1.0, 0, 0), out)
    parts["handle"] = tube(bail, across, wire if has_grip else wire * rng.uniform(1.0, 2.0), wire)
    labels = {"ear_left": "ear", "ear_right": "ear"}
    crown = np.array([0.0, 0.0, z]) + out * depth
    held = "handle"
    if has_grip:
        middle = bail[24:36]
        thick = rng.uniform(0.018, 0.028)
        swell = thick * (0.8 + 0.2 * np.sin(np.linspace(0, np.pi, 24)))
        line = np.stack([np.interp(np.linspace(0, 11, 24), np.arange(12), c) for c in middle.T], axis=1)
        parts["grip"] = tube(line, across, swell)
        held = "grip"
    graspable = ("handle", "grip") if has_grip else ("handle",)
    return Design(parts, graspable, Touch(held, crown + out * 0.01, out, "lift"), labels)


def mug(rng: Generator) -> Design:
    """Return a mug with an ear, a round or a D-shaped handle."""
    height, radius = rng.uniform(0.08, 0.11), rng.uniform(0.037, 0.046)
    waist = rng.uniform(-0.08, 0.10)
    taper = rng.uniform(0.86, 1.0)
    wall = rng.uniform(0.003, 0.0045)
    body = side(height, (radius * taper, radius * (1 + waist), radius), base=0.003, fillet=rng.uniform(0.004, 0.012))
    top, low = height * rng.uniform(0.76, 0.9), height * rng.uniform(0.16, 0.34)
    start = (radius_at(body, top) - SINK * wall, 0, top)
    end = (radius_at(body, low) - SINK * wall, 0, low)
    depth = rng.uniform(0.027, 0.036)
    form = rng.choice(3)
    path = loop(
        start,
        end,
        (1, 0, 0),
        depth,
        exponent=(2.0, 3.4, 2.1)[form],
        skew=(0.0, 0.0, rng.uniform(0.2, 0.4))[form],
    )
    width, thick = rng.uniform(0.009, 0.016), rng.uniform(0.006, 0.009)
    flare = 1 + 0.35 * np.abs(np.linspace(-1, 1, len(path))) ** 4
    parts = {
        "body": vessel(body, wall, 0.005),
        "handle": seated(tube(path, (0, 1, 0), width * flare, thick, exponent=2.5), body, SINK * wall),
        "base": ring(radius_at(body, 0.004) - 0.003, 0.0035, 0.005, 0.007),
    }
    if rng.random() < 0.4:
        parts["rim"] = ring(radius_at(body, height) - wall / 2, height + 0.003, wall * 1.7, wall * 1.5)
    grip = path[int(np.argmax(path[:, 0]))]
    return Design(parts, ("handle",), Touch("handle", grip + np.array((thick, 0, 0)), (1, 0, 0), "drink"))


def jug(rng: Generator) -> Design:
    """Return an open pouring jug: belly, neck, a lip drawn out of the rim, and a large handle opposite."""
    height, radius = rng.uniform(0.20, 0.27), rng.uniform(0.055, 0.072)
    neck, mouth = rng.uniform(0.62, 0.85), rng.uniform(0.75, 0.95)
    wall = rng.uniform(0.0032, 0.0045)
    belly = rng.uniform(0.92, 1.0)
    radii = [radius * k for k in (0.72, belly, 1.0, (1 + neck) / 2, neck, mouth)]
    body = side(height, radii, base=0.004, fillet=0.008, count=22)
    reach = rng.uniform(0.3, 0.5) * radius

    def draw_lip(vertices: Floats) -> Floats:
        angle = np.arctan2(vertices[:, 1], vertices[:, 0])
        rise = np.clip((vertices[:, 2] - 0.78 * height) / (0.22 * height), 0.0, 1.2) ** 2
        near = np.exp(-((angle / 0.38) ** 2)) * rise
        moved = vertices.copy()
        moved[:, 0] += reach * near
        moved[:, 2] += 0.25 * reach * near
        return moved

    top, low = height * rng.uniform(0.84, 0.93), height * rng.uniform(0.26, 0.46)
    start = (SINK * wall - radius_at(body, top), 0, top)
    end = (SINK * wall - radius_at(body, low), 0, low)
    depth = rng.uniform(0.045, 0.06)
    path = loop(start, end, (-1, 0, 0), depth, exponent=rng.uniform(2.0, 3.0), skew=rng.uniform(0.0, 0.35), count=56)
    width, thick = rng.uniform(0.018, 0.026), rng.uniform(0.010, 0.016)
    parts = {
        "body": vessel(body, wall, 0.006).warped(draw_lip),
        "handle": seated(tube(path, (0, 1, 0), width, thick, exponent=2.4), body, SINK * wall),
        "base": lathe(
            [(radii[0] - 0.004, 0), (radii[0], 0.003), (radii[0] - 0.001, 0.009), (radii[0] - 0.01, 0.0095)],
            step=0.006,
        ),
    }
    if rng.random() < 0.4:
        band = height * rng.uniform(0.45, 0.6)
        parts["band"] = ring(radius_at(body, band), band, 0.005, rng.uniform(0.006, 0.012))
    grip = path[int(np.argmin(path[:, 0]))]
    return Design(parts, ("handle",), Touch("handle", grip - np.array((thick, 0, 0)), (-1, 0, 0), "pour"))


def pan(rng: Generator) -> Design:
    """Return a frying pan or a saucepan with a long handle, a bracket and a hanging ring."""
    radius = rng.uniform(0.10, 0.14)
    deep = bool(rng.random() < 0.4)
    radius = radius * 0.72 if deep else radius
    height = rng.uniform(0.08, 0.11) if deep else rng.uniform(0.04, 0.055)
    wall = 0.003
    flare = rng.uniform(0.94, 1.0) if deep else rng.uniform(0.74, 0.86)
    body = side(height, (radius * flare, radius * (0.45 + 0.57 * flare), radius), base=0.003, fillet=0.010)
    z = height * rng.uniform(0.7, 0.85)
    x = radius_at(body, z)
    length, rise = rng.uniform(0.16, 0.21), rng.uniform(0.02, 0.06)
    t = np.linspace(0, 1, 40)
    path = np.stack([x + 0.028 + length * t, 0 * t, z + 0.008 + rise * np.sin(t * np.pi / 2)], axis=1)
    width = rng.uniform(0.020, 0.028) * (0.72 + 0.28 * np.sin(np.pi * (0.15 + 0.75 * t)) ** 2)
    thick = rng.uniform(0.012, 0.018) * (0.85 + 0.15 * t)
    bracket = np.stack(
        [np.linspace(x - SINK * wall, x + 0.036, 16), np.zeros(16), z + 0.008 * np.linspace(0, 1, 16)], 1
    )
    hang = path[-1] + np.array((0.011, 0, 0))
    angle = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    eye = hang + 0.010 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    parts = {
        "body": vessel(body, wall, 0.005),
        "handle": tube(path, (0, 1, 0), width, thick, exponent=2.8),
        "bracket": tube(bracket, (0, 1, 0), np.linspace(0.034, 0.016, 16), 0.009, exponent=3, dome=False),
        "base": lathe(
            [(radius * flare - 0.014, 0), (radius * flare - 0.012, 0.002), (radius * flare - 0.012, 0.004)],
            step=0.01,
        ),
        "hanging_ring": tube(eye, (0, 0, 1), 0.005, 0.0045, closed=True),
    }
    if rng.random() < 0.45:
        short = loop((SINK * wall - x, -0.035, z), (SINK * wall - x, 0.035, z), (-1, 0, 0.0), 0.035, exponent=2.8)
        parts["helper_handle"] = tube(short, (0, 0, 1), 0.009, 0.011)
    middle = path[22] + np.array((0, 0, 0.02))
    labels = {"helper_handle": "handle"} if "helper_handle" in parts else {}
    return Design(parts, ("handle",), Touch("handle", middle, (0, 0, 1), "lift"), labels)


def basket(rng: Generator) -> Design:
    """Return a woven basket, oval or round, with a bail over it or a handle at each end."""
    height, length = rng.uniform(0.13, 0.18), rng.uniform(0.13, 0.18)
    squeeze, corner = rng.uniform(0.68, 1.0), rng.uniform(2.0, 3.2)
    section = superellipse(56, 1.0, squeeze, corner)
    body = side(height, (0.78 * length, rng.uniform(0.9, 1.0) * length, length), base=0.004, fillet=0.012, count=21)
    strands, rows = 28, 11

    def weave(vertices: Floats) -> Floats:
        angle = np.arctan2(vertices[:, 1] / squeeze, vertices[:, 0])
        depth = 0.0016 * np.cos(strands / 2 * angle) * np.sin(2 * np.pi * rows / 2 * vertices[:, 2] / height)
        off_floor = vertices[:, 2] > 0.02
        scale = 1 + depth * off_floor / length
        return widened(vertices, scale)

    low = radius_at(body, 0.006)
    parts: dict[str, Mesh] = {
        "body": vessel(body, 0.006, 0.007, section=section).warped(weave),
        "rim": ring(length - 0.003, height + 0.004, 0.013, 0.014, section=section),
        "base": ring(low - 0.002, 0.006, 0.010, 0.012, section=section),
    }
    thick = rng.uniform(0.010, 0.015)
    if rng.random() < 0.6:
        rise = rng.uniform(0.13, 0.18)
        foot = height * 0.72
        reach = radius_at(body, foot) - 0.008
        path = loop(
            (-reach, 0, foot),
            (reach, 0, foot),
            (0, 0, 1),
            rise + height - foot,
            exponent=rng.uniform(2.0, 2.6),
            count=60,
        )
        parts["handle"] = tube(path, (0, 1, 0), thick * rng.uniform(1.0, 2.2), thick, exponent=2.4)
        touch = Touch("handle", (0, 0, height + rise + thick), (0, 0, 1), "carry")
        return Design(parts, ("handle",), touch)
    half = rng.uniform(0.045, 0.06) * squeeze
    x = length * 0.985
    tilt = rng.uniform(0.25, 1.1)
    out = np.array([np.sin(tilt), 0, np.cos(tilt)])
    path = loop((x, -half, height), (x, half, height), out, rng.uniform(0.045, 0.06), exponent=2.6)
    right = tube(path, np.cross(out, (0, 1, 0)), thick)
    parts["handle_left"] = right.moved(rotation=np.diag([-1.0, -1.0, 1.0]))
    parts["handle_right"] = right
    labels = {"handle_left": "handle", "handle_right": "handle"}
    crown = path[len(path) // 2] + out * thick
    return Design(parts, ("handle_left", "handle_right"), Touch("handle_right", crown, out, "carry"), labels)

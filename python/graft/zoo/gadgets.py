"""Devices: phone, remote control and headphones. Metres."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from graft.objects import Floats
from graft.zoo.curves import loop, rectangle, superellipse
from graft.zoo.design import Design, Touch
from graft.zoo.surfaces import Mesh, facing, lathe, merged, ring, side, slab, tube

PROUD = 0.0003
"""How far a screen or a panel stands out of the case it is set into, metres."""


def phone(rng: Generator) -> Design:
    """Return a phone on its back: case, screen, camera, power and volume buttons, perhaps a home button."""
    width, length = rng.uniform(0.066, 0.077), rng.uniform(0.138, 0.165)
    thick, corner = rng.uniform(0.0075, 0.010), rng.uniform(0.006, 0.013)
    edge = thick * rng.uniform(0.2, 0.48)
    case = rectangle(120, length, width, corner)
    home = bool(rng.random() < 0.35)
    border, chin = (0.003, 0.018) if home else (0.003, 0.003)
    screen = rectangle(120, length - 2 * chin, width - 2 * border, corner - 0.002)
    block = float(rng.uniform(0.018, 0.030))
    camera = rectangle(60, block * rng.uniform(0.7, 1.3), block, 0.005)
    up = thick * 0.5
    button = rectangle(40, 0.010, 0.0028, 0.0013)
    rocker = rectangle(40, rng.uniform(0.018, 0.026), 0.0028, 0.0013)
    hand = rng.choice([-1.0, 1.0])
    side_on = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    other = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
    power_at = length * rng.uniform(0.08, 0.14)
    volume_at = min(power_at + 0.026, length / 2 - 0.028)
    corner_at = (
        length / 2 - 0.007 - block * 0.65,
        (width / 2 - 0.007 - block / 2) * rng.choice([-1.0, 1.0]),
        0,
    )
    centred = bool(rng.random() < 0.25)
    bump = slab(camera, 0.003, 0.0008).moved((corner_at[0], 0.0 if centred else corner_at[1], -0.0016))
    same = bool(rng.random() < 0.5)

    def on_edge(outline: Floats, x: float, sign: float) -> Mesh:
        plate = slab(outline, 0.0022, 0.0006)
        turn = other if sign > 0 else side_on
        return plate.moved((x, sign * (width / 2 - 0.0012), up), turn)

    parts = {
        "body": slab(case, thick, edge),
        "screen": slab(screen, 0.0012 + PROUD, 0.0002).moved((0, 0, thick - 0.0012)),
        "camera": bump,
        "power_button": on_edge(button, power_at, hand),
        "volume_button": on_edge(rocker, volume_at, hand if same else -hand),
    }
    labels = {"power_button": "button", "volume_button": "button"}
    if home:
        parts["home_button"] = lathe(
            [(0.0055, 0), (0.0055, 0.0012), (0.0045, 0.0016), (0.003, 0.0014)], step=0.0008
        ).moved((-length / 2 + 0.009, 0, thick - 0.001))
        labels["home_button"] = "button"
    touch = Touch("body", (-0.05 * length, width / 2, up), (0, 1, 0), "hold")
    return Design(parts, ("body",), touch, labels, stands=False)


def remote(rng: Generator) -> Design:
    """Return a remote control: long case, keypad, ring of arrows, power button, emitter and battery cover."""
    length, width = rng.uniform(0.15, 0.215), rng.uniform(0.038, 0.052)
    thick = rng.uniform(0.016, 0.024)
    corner = rng.uniform(0.006, 0.49 * width / 1.05)
    taper, arch = rng.uniform(-0.12, 0.12), rng.uniform(0.0, 0.012)

    def shaped(vertices: Floats) -> Floats:
        x = vertices[:, 0] / (length / 2)
        y = vertices[:, 1] * (1 + taper * x)
        z = vertices[:, 2] - arch * x**2 * 0.5
        return np.stack([vertices[:, 0], y, z], axis=1)

    case = slab(rectangle(140, length, width, corner), thick, thick * rng.uniform(0.22, 0.42), top=thick * 0.2)
    top = thick - 0.0016
    columns, rows = (3, int(rng.integers(3, 5)))
    pitch = min(0.0125, 0.78 * width / columns)
    key_size = pitch * rng.uniform(0.62, 0.75)
    round_keys = bool(rng.random() < 0.5)
    outline = (
        superellipse(16, key_size / 2, key_size / 2) if round_keys else rectangle(16, key_size, 0.75 * key_size, 0.0015)
    )
    start = -length * rng.uniform(0.36, 0.40)
    key = slab(outline, 0.0036, 0.001)
    keys = [key.moved((start + i * pitch, (j - 1) * pitch, top)) for i in range(rows) for j in range(columns)]
    dpad_at = length * rng.uniform(0.13, 0.19)
    keys_end = start + (rows - 1) * pitch + key_size / 2
    rocker_at = (keys_end + dpad_at - min(0.36 * width, 0.017)) / 2
    rocker = rectangle(40, min(0.020, 0.7 * (dpad_at - 0.017 - keys_end)), 0.26 * width, 0.003)
    dpad = min(0.36 * width, 0.017)
    parts = {
        "body": case,
        "keypad": merged(*keys),
        "rockers": merged(
            *(slab(rocker, 0.0034, 0.001).moved((rocker_at, y, top)) for y in (-0.24 * width, 0.24 * width))
        ),
        "dpad": merged(
            ring(dpad * 0.76, thick + 0.0002, dpad * 0.46, 0.0036).moved((dpad_at, 0, 0)),
            lathe(
                [(dpad * 0.42, 0), (dpad * 0.42, 0.003), (dpad * 0.34, 0.0038)],
                step=0.0015,
                section=superellipse(24),
            ).moved((dpad_at, 0, top)),
        ),
        "power_button": lathe(
            [(0.0042, 0), (0.0042, 0.0030), (0.0034, 0.0038), (0.0015, 0.0038)],
            step=0.0008,
            section=superellipse(28),
        ).moved((0.42 * length, -0.22 * width * rng.choice([-1.0, 0.0, 1.0]), top)),
        "emitter": lathe(
            [(0.006, -0.004), (0.0055, 0.0), (0.0035, 0.0025), (0.001, 0.003)],
            step=0.0012,
            section=superellipse(28, 1.0, 0.55),
        ).moved((length / 2, 0, 0.5 * thick), facing((1, 0, 0))),
        "battery_cover": slab(rectangle(80, length * 0.34, width * 0.66, 0.004), 0.0012, 0.0003).moved(
            (-0.22 * length, 0, -PROUD)
        ),
    }
    shaped_parts = {name: mesh.warped(shaped) for name, mesh in parts.items()}
    touch = Touch("body", (-0.08 * length, width / 2, thick / 2), (0, 1, 0), "point")
    return Design(shaped_parts, ("body",), touch, {"power_button": "button"}, stands=False)


def headphones(rng: Generator) -> Design:
    """Return headphones that stand on their cups: band, band pad, yokes, cups and cushions, round or oval."""
    half, rise = rng.uniform(0.072, 0.084), rng.uniform(0.10, 0.125)
    cup, deep = rng.uniform(0.032, 0.042), rng.uniform(0.018, 0.026)
    oval = rng.uniform(0.74, 1.0)
    z = cup + 0.002
    low = z + 0.052
    band = loop(
        (-half - 0.004, 0, low),
        (half + 0.004, 0, low),
        (0, 0, 1),
        z + cup + rise - low,
        exponent=rng.uniform(2.0, 2.5),
        count=64,
    )
    width, thick = rng.uniform(0.018, 0.032), rng.uniform(0.006, 0.010)
    pad = band[18:46] - np.array([0, 0, 0.55 * thick])
    section = superellipse(SECTION, oval, 1.0, 2.2)
    shell = side(deep, (cup * 0.94, cup, cup * 0.9), fillet=0.004, shoulder=0.007, count=18)
    inward = side(0.022, (cup * 0.97, cup * 1.02, cup * 0.93), fillet=0.004, shoulder=0.007, count=16)
    hollow = cup * 0.52
    cushion = np.vstack([inward, [(hollow, inward[-1, 1] - 0.001), (hollow * 0.96, inward[-1, 1] - 0.012)]])
    parts = {
        "band": tube(band, (0, 1, 0), width, thick, exponent=2.8),
        "band_pad": tube(pad, (0, 1, 0), width * 0.86, thick * 1.1, exponent=2.6),
    }
    labels: dict[str, str] = {}
    for name, sign in (("left", -1.0), ("right", 1.0)):
        outer, inner = facing((sign, 0, 0)), facing((-sign, 0, 0))
        spin = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
        x = sign * (half - 0.006)
        parts[f"yoke_{name}"] = _yoke(x + sign * 0.010, z, low, cup, oval, sign)
        parts[f"cup_{name}"] = lathe(shell, section=section).moved((x, 0, z), outer @ spin)
        parts[f"cushion_{name}"] = lathe(cushion, section=section, step=0.006).moved(
            (x + sign * 0.001, 0, z), inner @ spin
        )
        labels |= {f"yoke_{name}": "yoke", f"cup_{name}": "cup", f"cushion_{name}": "cushion"}
    crown = (0, 0, z + cup + rise + thick)
    return Design(parts, ("band",), Touch("band", crown, (0, 0, 1), "hang"), labels)


SECTION = 36
"""Points around an ear cup."""


def _yoke(x: float, z: float, low: float, cup: float, oval: float, sign: float) -> Mesh:
    """Return the fork that holds a cup at both sides and ends in the slider that goes into the band."""
    wide = cup * oval + 0.002
    fork = loop((x, -wide, z), (x, wide, z), (0, 0, 1), cup + 0.010, exponent=2.4, count=48)
    stem = np.linspace((x, 0, z + cup + 0.010), (x + sign * 0.002, 0, low + 0.014), 14)
    return merged(
        tube(fork, (1, 0, 0), 0.008, 0.005, exponent=2.8, segments=16),
        tube(stem, (0, 1, 0), 0.011, 0.005, exponent=3.0, segments=16),
    )

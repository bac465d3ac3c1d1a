"""Parallel grippers as data: boxes, a stroke, a force. The planner, the planner of motions and the simulator read it.

The gripper frame, here and everywhere in graft: the origin is the TCP, midway between the centres of the pads; z is the
approach, out of the palm towards the object; y is the direction in which the fingers close; x = y cross z. It is the
frame of Franka's hand. Other conventions are converted where files are read and written.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from graft.checks import Floats, checked_array, is_rotation
from graft.errors import InputError

MIRROR = np.diag([1.0, -1.0, 1.0])
"""Takes the finger at +y to the finger at -y."""

OPENING_CLEARANCE = 0.005
"""Room between an open pad and the surface while the hand comes in, metres: a wide open finger would not fit into the
loop of a mug's handle, and an arm places a hand to a millimetre or two."""

PAD_TOLERANCE = 1e-4
"""The pad's inner surface is where it should be to this, metres: what a part of a hand is made to."""


@dataclass(frozen=True, eq=False)
class Box:
    """A box of the gripper.

    Attributes:
        center: (3,) metres, in the frame of what it belongs to.
        half_extents: (3,) metres, positive, along the box's own axes.
        rotation: (3, 3) columns are the box's axes in the frame of what it belongs to.
    """

    center: Floats
    half_extents: Floats
    rotation: Floats = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", checked_array("box center", self.center, (3,)))
        object.__setattr__(self, "half_extents", checked_array("box half_extents", self.half_extents, (3,)))
        object.__setattr__(self, "rotation", checked_array("box rotation", self.rotation, (3, 3)))
        if (self.half_extents <= 0).any():
            raise InputError(f"box half_extents: expected positive numbers, got {self.half_extents.tolist()}")
        if not is_rotation(self.rotation):
            raise InputError("box rotation: expected a rotation matrix")

    @classmethod
    def spanning(cls, low: ArrayLike, high: ArrayLike) -> Box:
        """Return the box along the axes between two opposite corners (3,), metres."""
        lowest: Floats = checked_array("box low", low, (3,))
        highest: Floats = checked_array("box high", high, (3,))
        return cls((lowest + highest) / 2.0, (highest - lowest) / 2.0)

    @property
    def corners(self) -> Floats:
        """(8, 3) corners, metres; the k-th bit of a corner's index tells the side along the k-th axis."""
        signs = np.array([[1.0 if i >> k & 1 else -1.0 for k in range(3)] for i in range(8)])
        placed: Floats = self.center + (signs * self.half_extents) @ self.rotation.T
        return placed

    def mirrored(self) -> Box:
        """Return the box reflected in the plane y = 0."""
        return Box(MIRROR @ self.center, self.half_extents, MIRROR @ self.rotation @ MIRROR)

    def moved(self, offset: Floats) -> Box:
        """Return the box moved by `offset` (3,), metres."""
        return Box(self.center + offset, self.half_extents, self.rotation)


@dataclass(frozen=True, eq=False)
class Gripper:
    """A parallel gripper with two mirrored fingers.

    Attributes:
        name: For people and files.
        stroke: Largest opening between the pads, metres.
        palm: Boxes of the hand that do not move, gripper frame (z < 0).
        finger: Boxes of the finger at +y, in its own frame: axes as the gripper's, origin on the inner surface of the
            pad at the TCP, so that an opening w puts it at y = w / 2. The first box is the pad: its inner surface is
            y = 0. The other finger is its mirror image.
        flange: (4, 4) T_flange_tcp: from where the gripper is mounted to the TCP.
        force: Closing force that a finger gives by default, newtons.
        max_force: The most a finger gives, newtons.
        mass: Of the whole gripper, kilograms.
    """

    name: str
    stroke: float
    palm: tuple[Box, ...]
    finger: tuple[Box, ...]
    flange: Floats = field(default_factory=lambda: np.eye(4))
    force: float = 15.0
    max_force: float = 70.0
    mass: float = 0.73

    def __post_init__(self) -> None:
        where = f"gripper {self.name!r}"
        if not self.name:
            raise InputError("gripper name: expected a name, got an empty string")
        object.__setattr__(self, "palm", tuple(self.palm))
        object.__setattr__(self, "finger", tuple(self.finger))
        object.__setattr__(self, "flange", checked_array(f"{where} flange", self.flange, (4, 4)))
        for what in ("stroke", "force", "max_force", "mass"):
            value = getattr(self, what)
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"{where} {what}: expected a positive number, got {value}")
        if not self.finger:
            raise InputError(f"{where} finger: expected at least one box, the pad; got none")
        if self.force > self.max_force:
            raise InputError(f"{where} force: expected at most max_force {self.max_force:g} N, got {self.force:g} N")
        if not is_rotation(self.flange[:3, :3]) or not np.array_equal(self.flange[3], (0.0, 0.0, 0.0, 1.0)):
            raise InputError(f"{where} flange: expected a rotation and a translation")
        inner = float(self.pad.corners[:, 1].min())
        if abs(inner) > PAD_TOLERANCE:
            raise InputError(
                f"{where} finger: expected the inner surface of the first box, the pad, at y = 0, got y = {inner:g}"
            )

    def is_like(self, other: Gripper) -> bool:
        """Whether another gripper is the same in all but its name, force and mass."""
        mine, theirs = (self.palm + self.finger, other.palm + other.finger)
        return (
            self.stroke == other.stroke
            and len(self.palm) == len(other.palm)
            and len(self.finger) == len(other.finger)
            and np.array_equal(self.flange, other.flange)
            and all(np.array_equal(a.corners, b.corners) for a, b in zip(mine, theirs, strict=True))
        )

    @property
    def pad(self) -> Box:
        """The box of the finger at +y that touches, in the finger's frame."""
        return self.finger[0]

    @property
    def tip(self) -> float:
        """How far the fingertips reach beyond the TCP along the approach, metres."""
        return float(max(box.corners[:, 2].max() for box in self.finger))

    @property
    def reach(self) -> float:
        """How far the TCP lies beyond the flange along the approach, metres."""
        return float(self.flange[:3, 2] @ self.flange[:3, 3])

    def opening_for(self, width: float, clearance: float = OPENING_CLEARANCE) -> float:
        """Return how far the pads are apart while the hand comes in to close to `width`, metres.

        Args:
            width: Between the pads when they touch, metres.
            clearance: Room on either side, metres.
        """
        return min(width + 2.0 * clearance, self.stroke)

    def boxes(self, opening: float) -> tuple[Box, ...]:
        """Return palm, finger at +y, finger at -y in the gripper frame, `opening` metres between the pads."""
        away = np.array([0.0, opening / 2.0, 0.0])
        right = tuple(box.moved(away) for box in self.finger)
        return self.palm + right + tuple(box.mirrored() for box in right)


def _ahead(distance: float) -> Floats:
    """Return T_flange_tcp (4, 4) of a TCP `distance` metres before the flange, axes alike."""
    flange = np.eye(4)
    flange[2, 3] = distance
    return flange


PANDA_HAND = Gripper(
    name="panda_hand",
    stroke=0.08,
    palm=(Box.spanning((-0.0315, -0.1025, -0.1034), (0.0315, 0.1025, -0.0374)),),
    finger=(
        Box.spanning((-0.009, 0.0, -0.009), (0.009, 0.0145, 0.009)),
        Box.spanning((-0.0105, 0.008, -0.039), (0.0105, 0.0254, -0.009)),
    ),
    flange=_ahead(0.1034),
    force=15.0,
    max_force=70.0,
    mass=0.73,
)
"""Franka's hand.

Stroke, force (70 N continuous), mass and the TCP .1034 m from the flange: Franka's data sheet. Boxes: around the meshes
of franka_description, `hand` (x +-.0315, y -.104 to .1006, z 0 to .066 from the flange; without the connector that lies
behind the flange) and `finger` (its pad is 18 mm wide, 14.5 mm thick and 18 mm long with the TCP in its middle; behind
it a shank from y = .008, where the mesh bends back, to .0254).
"""

ROBOTIQ_2F85 = Gripper(
    name="robotiq_2f85",
    stroke=0.085,
    palm=(
        Box.spanning((-0.0375, -0.0425, -0.1449), (0.0375, 0.0425, -0.0822)),
        Box.spanning((-0.0241, -0.0414, -0.0822), (0.0241, 0.0414, -0.0522)),
    ),
    finger=(
        Box.spanning((-0.011, 0.0, -0.01875), (0.011, 0.00635, 0.01875)),
        Box.spanning((-0.0075, 0.00635, -0.0264), (0.0075, 0.0307, 0.01875)),
        Box.spanning((-0.0195, 0.0, -0.0948), (0.0195, 0.0456, -0.0264)),
    ),
    flange=_ahead(0.1422),
    force=20.0,
    max_force=235.0,
    mass=0.925,
)
"""Robotiq's 2F-85.

Stroke, forces (20 to 235 N) and mass: its data sheet. Boxes: around the meshes of ROS-Industrial's
robotiq_2f_85 description (base, pads of 22 x 6.35 x 37.5 mm, links) with the linkage half closed, where the pads are
.1422 m before the base. The real pads travel on an arc: against these boxes they lie 12 mm further back when wide open,
3 mm at an opening of 60 mm, and 2 mm further ahead when closed.
"""

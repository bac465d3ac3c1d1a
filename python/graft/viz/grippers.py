"""Grippers as shapes: as their boxes where one grasp is looked at, as sticks where many are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graft.checks import Floats, Ints
from graft.errors import InputError
from graft.grasp.grasps import Grasp, GraspSet
from graft.grasp.gripper import Box
from graft.viz.colors import GOOD, UNKNOWN
from graft.viz.shapes import Shape, rod

PALM, FINGER, PAD = (84, 90, 102), (128, 136, 150), (44, 48, 58)
"""Colours of a gripper: greys, which no part has but one that matches nothing."""

BEST = "best/"
"""How the names of the best grasp's boxes begin in pages and models."""

BOX_OPACITY = 0.6
"""Of a gripper's boxes where they may be seen through: a palm is larger than a mug."""

STICK_RADIUS = 0.006
"""Radius of sticks in diagonals of the object."""

STEM = 0.5
"""A stick gripper's fingers and stem are this share of the real way from the palm to the tips, each."""

BOX_FACES: Ints = np.array(
    [
        (0, 2, 3),
        (0, 3, 1),
        (4, 5, 7),
        (4, 7, 6),
        (0, 1, 5),
        (0, 5, 4),
        (2, 6, 7),
        (2, 7, 3),
        (0, 4, 6),
        (0, 6, 2),
        (1, 3, 7),
        (1, 7, 5),
    ]
)
"""Outward triangles of a box whose corners are in the order of `Box.corners`."""


def require_grasps(grasps: GraspSet) -> None:
    """Raise `InputError` when there is nothing to draw."""
    if not len(grasps):
        raise InputError("grasps: expected at least one, got none")


def gripper_shapes(grasp: Grasp) -> list[Shape]:
    """Return the gripper's boxes where it closes, object frame, metres: palm, then both fingers."""
    gripper = grasp.gripper
    n_finger = len(gripper.finger)
    fingers = ["pad", *(f"link_{i}" for i in range(1, n_finger))]
    names = [f"palm_{i}" for i in range(len(gripper.palm))]
    names += [f"{side}_{finger}" for side in ("right", "left") for finger in fingers]
    colors = [PALM] * len(gripper.palm) + 2 * ([PAD] + [FINGER] * (n_finger - 1))
    return [
        _box(name, box, grasp.pose, color)
        for name, box, color in zip(names, gripper.boxes(grasp.width), colors, strict=True)
    ]


def _box(name: str, box: Box, pose: Floats, color: tuple[int, int, int]) -> Shape:
    return Shape(name, box.corners @ pose[:3, :3].T + pose[:3, 3], BOX_FACES, color)


def stick_shapes(grasps: GraspSet, size: float) -> list[Shape]:
    """Return one stick figure per grasp for an object of diagonal `size`: two fingers, a bar and a stem.

    The best is green, others fade to grey with their score.
    """
    low, high = grasps.scores.min(), grasps.scores.max()
    shares = (grasps.scores - low) / (high - low) if high > low else np.ones(len(grasps))
    return [
        _stick(f"grasp_{i}", grasp, share, size) for i, (grasp, share) in enumerate(zip(grasps, shares, strict=True))
    ]


def _stick(name: str, grasp: Grasp, share: float, size: float) -> Shape:
    gripper = grasp.gripper
    tip = gripper.tip
    back = -STEM * max((tip - float(box.corners[:, 2].min()) for box in gripper.finger), default=0.0)
    aside = grasp.width / 2.0 + STICK_RADIUS * size
    lines = [
        ((0, aside, tip), (0, aside, back)),
        ((0, -aside, tip), (0, -aside, back)),
        ((0, aside, back), (0, -aside, back)),
        ((0, 0, back), (0, 0, 2.0 * back)),
    ]
    vertices, faces = _merged([rod(np.array(a, float), np.array(b, float), STICK_RADIUS * size) for a, b in lines])
    blend = np.round(np.array(UNKNOWN) + share * (np.array(GOOD) - np.array(UNKNOWN))).astype(int)
    color = (int(blend[0]), int(blend[1]), int(blend[2]))
    return Shape(name, vertices @ grasp.pose[:3, :3].T + grasp.pose[:3, 3], faces, color)


def _merged(meshes: Sequence[tuple[Floats, Ints]]) -> tuple[Floats, Ints]:
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in meshes[:-1])])
    faces = np.concatenate([faces + offset for (_, faces), offset in zip(meshes, offsets, strict=True)])
    return np.concatenate([vertices for vertices, _ in meshes]), faces

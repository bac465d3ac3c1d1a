"""What is drawn: coloured triangles and points, and the marks of contacts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from graft.objects import Contact, Floats, Ints, PartObject
from graft.viz.colors import CONTACT, Colors

BALL_RADIUS = 0.026
"""Radius of a contact's ball in diagonals of the object: seen at a glance, and no handle vanishes in it."""

ARROW_LENGTH = 0.17
"""Length of a contact's normal arrow in the same unit."""

POINT_RADIUS = 0.9
"""Radius of a cloud's points in mean distances between neighbours, for a surface without holes."""

SEGMENTS = 24
"""Corners of the circles that marks are made of."""


@dataclass(frozen=True, eq=False)
class Shape:
    """A coloured piece of surface, or a cloud when it has no faces.

    Attributes:
        name: Of the part, or what it marks.
        vertices: (v, 3).
        faces: (f, 3).
        color: (3,) sRGB, 0 to 255.
        radius: Of a cloud's points, in units of the vertices.
    """

    name: str
    vertices: Floats
    faces: Ints
    color: tuple[int, int, int]
    radius: float = 0.0

    def scaled(self, scale: float) -> Shape:
        """Return the shape `scale` times as large."""
        return replace(self, vertices=scale * self.vertices, radius=scale * self.radius)


def rgb(row: Colors) -> tuple[int, int, int]:
    """Return one colour (3,) as plain integers."""
    red, green, blue = (int(x) for x in row)
    return red, green, blue


def diagonal(obj: PartObject) -> float:
    """Return the length of the diagonal of the axis-aligned bounding box; 1 for a single point."""
    low, high = obj.bounds
    return float(np.linalg.norm(high - low)) or 1.0


def object_shapes(obj: PartObject, colors: Colors) -> list[Shape]:
    """Return one shape per part."""
    shapes = []
    for part, color in zip(obj.parts, colors, strict=True):
        # A surface of side d sampled by n points has neighbours about d / sqrt(n) apart.
        radius = POINT_RADIUS * float(np.ptp(part.vertices, axis=0).max()) / np.sqrt(len(part.vertices))
        radius = max(radius, 0.002 * diagonal(obj))
        shapes.append(Shape(part.name, part.vertices, part.faces, rgb(color), radius))
    return shapes


def contact_shapes(contact: Contact, size: float) -> list[Shape]:
    """Return a ball at the contact and an arrow along its normal, for an object of diagonal `size`."""
    ball = sphere(BALL_RADIUS * size)
    arrow = turned_profile(
        np.array([[0.0, 0.0], [0.0075, 0.0], [0.0075, 0.7], [0.02, 0.7], [0.0, 1.0]])
        * np.array([size, ARROW_LENGTH * size])
    )
    pose = np.eye(4)
    pose[:3, :3] = frame_along(contact.normal)
    pose[:3, 3] = contact.point
    return [
        Shape(name, vertices @ pose[:3, :3].T + pose[:3, 3], faces, CONTACT)
        for name, (vertices, faces) in (("contact", ball), ("normal", arrow))
    ]


def frame_along(direction: Floats) -> Floats:
    """Return a right-handed rotation (3, 3) whose third column is the unit vector `direction`."""
    helper = np.eye(3)[int(np.argmin(np.abs(direction)))]
    first = np.cross(helper, direction)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(direction, first), direction], axis=1)


def turned_profile(profile: Sequence[Sequence[float]] | Floats) -> tuple[Floats, Ints]:
    """Turn a profile (k, 2) of (radius, height) about the z axis; faces look outward where it rises."""
    rows = np.asarray(profile, np.float64)
    angles = 2 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rings = rows[:, None, :1] * circle[None]
    heights = np.broadcast_to(rows[:, None, 1:], (*rings.shape[:2], 1))
    vertices = np.concatenate([rings, heights], axis=2).reshape(-1, 3)
    faces = []
    for ring in range(len(rows) - 1):
        for i in range(SEGMENTS):
            a, b = ring * SEGMENTS + i, ring * SEGMENTS + (i + 1) % SEGMENTS
            if rows[ring, 0] > 0:
                faces.append((a, b, b + SEGMENTS))
            if rows[ring + 1, 0] > 0:
                faces.append((a, b + SEGMENTS, a + SEGMENTS))
    return vertices, np.array(faces, np.int64)


def sphere(radius: float) -> tuple[Floats, Ints]:
    """Return vertices and faces of a sphere."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, SEGMENTS // 2 + 1)
    profile = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    profile[[0, -1], 0] = 0.0
    return turned_profile(profile)


def rod(start: Floats, end: Floats, radius: float) -> tuple[Floats, Ints]:
    """Return vertices and faces of a closed cylinder between two different points."""
    length = float(np.linalg.norm(end - start))
    vertices, faces = turned_profile([[0.0, 0.0], [radius, 0.0], [radius, length], [0.0, length]])
    moved: Floats = vertices @ frame_along((end - start) / length).T + start
    return moved, faces

"""Small rotations, without the cost of an object for each: a controller needs thousands a second."""

from __future__ import annotations

import numpy as np

from graft.checks import Floats

SMALL = 1e-9
"""Radians below which a rotation has no axis."""


def rotation_vector(rotation: Floats) -> Floats:
    """Return axis times angle (3,), radians in [0, pi], of a rotation (3, 3)."""
    skew = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    sine, cosine = float(np.linalg.norm(skew)) / 2, (float(np.trace(rotation)) - 1) / 2
    angle = float(np.arctan2(sine, cosine))
    if angle < SMALL:
        return skew / 2
    if sine < 1e-6:  # half a turn: the axis is the column of the symmetric part that is longest
        outer = (rotation + np.eye(3)) / 2
        column: Floats = outer[:, int(np.argmax(np.diag(outer)))]
        return angle * column / np.linalg.norm(column)
    vector: Floats = angle * skew / (2 * sine)
    return vector


def rotation_about(vector: Floats) -> Floats:
    """Return the rotation (3, 3) about a vector (3,) by its length in radians (Rodrigues' formula)."""
    angle = float(np.linalg.norm(vector))
    if angle < SMALL:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: Floats = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return rotation


def interpolated(begin: Floats, end: Floats, steps: int) -> Floats:
    """Return (steps, 4, 4) poses that go evenly from `begin` (excluded) to `end` (included)."""
    turn = rotation_vector(end[:3, :3] @ begin[:3, :3].T)
    poses = np.tile(np.eye(4), (steps, 1, 1))
    for i in range(steps):
        share = (i + 1) / steps
        poses[i, :3, :3] = rotation_about(share * turn) @ begin[:3, :3]
        poses[i, :3, 3] = begin[:3, 3] + share * (end[:3, 3] - begin[:3, 3])
    poses[-1] = end
    return poses

"""Where to look from: fixed views of an object, and the view that shows a contact."""

from __future__ import annotations

import numpy as np

from graft import _core
from graft.objects import Contact, Floats, PartObject
from graft.viz.shapes import BALL_RADIUS, diagonal, frame_along

UP = (0.0, 0.0, 1.0)
"""Up in pictures of objects that lie as they are."""

STANDARD_VIEWS = ((30.0, 22.0), (120.0, 22.0), (210.0, 22.0), (30.0, 72.0))
"""(azimuth, elevation) in degrees of an object's views: three sides and the top."""

AZIMUTHS = tuple(range(0, 360, 15))
ELEVATIONS = (20.0, 38.0, 4.0, 58.0, -22.0)
"""Candidate views of a contact, in degrees, those that people take of objects first."""

FACING = 0.35
"""Cosine of normal and direction to the viewer that shows a contact best: the arrow nearly in full."""

ENOUGH = 0.5
"""Share of the contact's ball that is seen from the side; seeing more is no gain."""

VISIBLE_WEIGHT, FACING_WEIGHT, BROAD_WEIGHT, LEVEL_WEIGHT = 4.0, 0.8, 2.5, 0.6
"""What a view gains by seeing the ball, by facing it, by showing the object broadly, by a usual height."""

LEVEL = 24.0
"""The usual elevation, in degrees."""


def look_from(azimuth: float, elevation: float, up: Floats | None) -> Floats:
    """Return the rotation (3, 3) of a camera: rows are right, down and forward, in the object frame.

    Args:
        azimuth: Degrees about the up axis.
        elevation: Degrees above the horizon.
        up: (3,) unit vector; None for `UP`.
    """
    above = np.asarray(UP if up is None else up, np.float64)
    # Turn from the object axis that is most level, so that standard views of upright objects agree.
    ahead = np.eye(3)[int(np.argmin(np.round(np.abs(above), 6)))]
    ahead = ahead - above * (above @ ahead)
    ahead /= np.linalg.norm(ahead)
    side = np.cross(above, ahead)
    turn, rise = np.radians(azimuth), np.radians(elevation)
    level = np.cos(turn) * ahead + np.sin(turn) * side
    toward = np.cos(rise) * level + np.sin(rise) * above
    right = np.cross(above, level)
    return np.stack([right, np.cross(right, toward), -toward])


def fit(rotation: Floats, points: Floats, width: int, height: int, margin: float = 0.06) -> Floats:
    """Return the camera (3, 4) that shows all `points` in a picture of this size, as large as possible.

    Args:
        rotation: (3, 3) rows right, down, forward.
        points: (p, 3) what must be seen, object frame.
        width: Pixels.
        height: Pixels.
        margin: Share of each side that stays empty.
    """
    seen = points @ rotation.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    # Pictures of a single point have a scale, too.
    wanted = float(np.max((high - low)[:2] / (width, height))) or 1.0 / min(width, height)
    scale = (1 - 2 * margin) / wanted
    return framed(rotation, (low + high) / 2, scale, width, height)


def framed(rotation: Floats, middle: Floats, scale: float, width: int, height: int) -> Floats:
    """Return the camera (3, 4) of `scale` pixels a unit that centres `middle` (3,), camera frame."""
    shift = np.array([width / 2, height / 2, 0.0]) - scale * middle
    return np.concatenate([scale * rotation, shift[:, None]], axis=1)


def contact_view(obj: PartObject, contact: Contact) -> tuple[float, float, float]:
    """Choose the view that shows a contact and the object around it.

    Returns:
        Azimuth and elevation in degrees, and the share of the contact's ball that is seen.
    """
    views = [(float(a), e) for e in ELEVATIONS for a in AZIMUTHS]
    rotations = np.array([look_from(a, e, obj.up) for a, e in views])
    toward = -rotations[:, 2]
    visible = _visible(obj, contact, toward)

    points = np.concatenate([part.vertices[:: 1 + len(part.vertices) // 500] for part in obj.parts])
    points = (points - points.mean(axis=0)) / diagonal(obj)
    covariance = rotations @ (points.T @ points / len(points)) @ rotations.transpose(0, 2, 1)
    breadth = np.sqrt(np.maximum(np.linalg.det(covariance[:, :2, :2]), 0.0))

    score = VISIBLE_WEIGHT * np.minimum(visible / ENOUGH, 1.0)
    score -= FACING_WEIGHT * np.abs(toward @ contact.normal - FACING)
    score += BROAD_WEIGHT * breadth / max(float(breadth.max()), 1e-12)
    score -= LEVEL_WEIGHT * np.array([abs(e - LEVEL) / 45.0 for _, e in views])
    # Rounded, so that the last bit of a sum does not choose between views that are equally good.
    best = int(np.argmax(np.round(score, 9)))
    return (*views[best], float(visible[best]))


def _visible(obj: PartObject, contact: Contact, toward: Floats) -> Floats:
    """Return (v,) the share of the contact's ball seen from each direction `toward` (v, 3) the viewer."""
    radius = 1.02 * BALL_RADIUS * diagonal(obj)
    turns = np.arange(12)
    heights = 1.0 - 0.9 * (turns + 0.5) / len(turns)
    angles = turns * np.pi * (3.0 - np.sqrt(5.0))  # the golden angle spreads points over the upper half of the ball
    sides = np.sqrt(1.0 - heights**2)
    local = np.stack([sides * np.cos(angles), sides * np.sin(angles), heights], axis=1)
    outward = local @ frame_along(contact.normal).T
    vertices = np.concatenate([part.vertices for part in obj.parts])
    offsets = np.cumsum([0, *(len(part.vertices) for part in obj.parts)])
    faces = np.concatenate([part.faces + o for part, o in zip(obj.parts, offsets[:-1], strict=True)])
    origins = np.broadcast_to(contact.point + radius * outward, (len(toward), *outward.shape))
    directions = np.broadcast_to(toward[:, None, :], origins.shape)
    free = np.isinf(
        _core.cast_rays(
            vertices,
            np.ascontiguousarray(faces),
            np.ascontiguousarray(origins).reshape(-1, 3),
            np.ascontiguousarray(directions).reshape(-1, 3),
        )
    ).reshape(len(toward), -1)
    # A point on the far side of the ball is hidden by the ball itself.
    near = toward @ outward.T > 0.0
    shares: Floats = (free & near).mean(axis=1)
    return shares

"""Contacts on surfaces: snap a point to a part, or choose one, and call it a demonstration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from graft.errors import InputError
from graft.objects import Contact, Demonstration, Floats, Ints, Part, PartObject

CENTER_SAMPLES = 512
"""Surface points among which the middle of a part is sought; on a bar eight times as long as
thick they are 3 % of its length apart."""

CENTER_NEIGHBOURS = 8
"""Nearest samples that a sample is connected to when distances along the surface are measured."""

CENTER_BAND = 1.1
"""Samples whose mean distance along the surface is within this factor of the least make up the middle. On a
bar these are the third of its length about the middle, all around."""


BAR_RATIO = 1.3
"""The middle is longer one way than the others when its variance along that axis is this many times the next.
The third of a bar eight times as long as thick has 4.7; the band around a round body has 1, where noise would
choose."""

SAME_PLACE = 1e-6
"""Points closer than this share of the object's size are at the same place."""

NO_SIDE = 0.01
"""A middle whose offset from the object's centroid is shorter than this share of the object's size faces nowhere."""

PLASTIC = 1.32471795724474602596
"""The plastic number; multiples of its inverse powers cover the square evenly (the R2 sequence, Roberts
2018)."""


def closest_surface_point(part: Part, point: ArrayLike) -> tuple[Floats, Floats, float]:
    """Return the point of a part's surface that is closest to a given one.

    Ties go to the lowest face (point clouds: point).

    Args:
        part: A piece of surface or a point cloud.
        point: (3,) in the object frame, object units.

    Returns:
        The point (3,), the outward unit normal (3,) there, and the distance. A face's side is told by its
        winding; a closed surface that is wound inside out is noticed and turned. A cloud without normals gets
        the normal of the plane through the neighbours, turned away from the cloud's middle.

    Raises:
        InputError: The point is not three finite numbers.
    """
    try:
        query = np.asarray(point, np.float64)
    except (TypeError, ValueError):
        raise InputError(f"point: expected three finite numbers, got {point!r}") from None
    if query.shape != (3,) or not np.isfinite(query).all():
        raise InputError(f"point: expected three finite numbers, got {point!r}")
    if part.is_point_cloud:
        distances = np.linalg.norm(part.vertices - query, axis=1)
        index = int(np.argmin(distances))
        return part.vertices[index].copy(), _cloud_normal(part, index), float(distances[index])
    closest = _closest_on_triangles(part.vertices[part.faces], query)
    squared = np.square(closest - query).sum(axis=1)
    # Points on an edge belong to two faces; rounding must not choose between them.
    tie = 1e-12 * (squared.min() + np.square(np.ptp(part.vertices, axis=0)).sum())
    tied = np.flatnonzero(squared <= squared.min() + tie)
    a, b, c = part.vertices[part.faces[tied]].transpose(1, 0, 2)
    face = int(tied[np.argmax(np.cross(b - a, c - a).any(axis=1))])  # the lowest that has an area
    return closest[face].copy(), _face_normal(part, face), float(np.sqrt(squared[face]))


def mark_contact(
    obj: PartObject,
    part: int | str,
    point: ArrayLike | None = None,
    *,
    approach: ArrayLike | None = None,
    name: str = "",
    metadata: Mapping[str, Any] | None = None,
) -> Demonstration:
    """Mark where an object is taken.

    Args:
        obj: The object.
        part: The part that is taken: index, name, or a label that only one part has.
        point: (3,) near the part, object frame and units; the contact is the closest point of the part's
            surface. Without it the contact lies in the part's middle, see `middle_point`.
        approach: (3,) direction in which the gripper comes, object frame.
        name: Of the demonstration; the object's name by default.
        metadata: Travels with the demonstration.

    Returns:
        The object with a contact on the part's surface and the outward normal there.

    Raises:
        InputError: There is no such part, or the point is further from the part than the object is large.
    """
    index = obj.part_index(part)
    chosen = obj.parts[index]
    where = middle_point(obj, index) if point is None else point
    place, normal, distance = closest_surface_point(chosen, where)
    size = float(np.linalg.norm(np.ptp(obj.bounds, axis=0)))
    if distance > size:
        raise InputError(
            f"point: {np.asarray(where).tolist()} is {distance:.4g} away from part {chosen.name!r}, "
            f"the whole object is {size:.4g} across; are the units the object's?"
        )
    direction = None if approach is None else np.asarray(approach, np.float64)
    return Demonstration(obj, Contact(place, normal, index, direction), name, dict(metadata or {}))


def middle_point(obj: PartObject, part: int | str) -> Floats:
    """Return a point (3,) on a part's surface in its middle: of a curved handle, the middle of the bar.

    The middle is where the mean distance along the surface to the rest of the part is least: within
    `CENTER_BAND`, among `CENTER_SAMPLES` evenly spread points, by shortest paths between neighbours, on the
    largest of several disconnected pieces. The point is the one on the side that faces away from the centroid
    of the object, square to the long axis of the part and to that of its middle if they have one (`BAR_RATIO`):
    the wall of a bottle, not its base. Where there is no such side (`NO_SIDE`) it is the sample of least mean
    distance, the first in the order of faces on a tie. No randomness.
    """
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import connected_components, shortest_path
    from scipy.spatial import cKDTree

    chosen = obj.parts[obj.part_index(part)]
    points = _spread_samples(chosen)
    near = min(CENTER_NEIGHBOURS + 1, len(points))
    lengths, neighbours = map(np.asarray, cKDTree(points).query(points, k=[*range(1, near + 1)]))
    # Coincident samples are joined by a tiny length: zero would mean no edge.
    floor = max(float(lengths.max()), 1e-300) * 1e-9
    rows = np.repeat(np.arange(len(points)), near)
    graph = csr_matrix((np.maximum(lengths, floor).ravel(), (rows, neighbours.ravel())), (len(points),) * 2)
    _, component = connected_components(graph, directed=False)
    members = np.flatnonzero(component == np.bincount(component).argmax())
    mean = shortest_path(graph[members][:, members], directed=False).mean(axis=1)
    middle = points[members[mean <= CENTER_BAND * mean.min()]]
    center = middle.mean(axis=0)
    reach = float(np.linalg.norm(middle - center, axis=1).max())
    outwards = center - _centroid(obj)
    for cloud in (points, middle):  # sideways from a bar, not towards its end
        spread, axes = np.linalg.eigh(np.cov((cloud - center).T)) if len(cloud) > 1 else (np.zeros(3), np.eye(3))
        if spread[2] > BAR_RATIO * spread[1]:
            outwards = outwards - (outwards @ axes[:, 2]) * axes[:, 2]
    length = float(np.linalg.norm(outwards))
    if length <= NO_SIDE * float(np.linalg.norm(np.ptp(obj.bounds, axis=0))):
        first = int(np.flatnonzero(mean <= mean.min() * (1 + SAME_PLACE))[0])
        return np.array(points[members[first]], np.float64)
    return closest_surface_point(chosen, center + outwards * (reach / length))[0]


def _centroid(obj: PartObject) -> Floats:
    """Return the centroid (3,) of the surface; of the vertices where parts are clouds, without area."""
    if any(part.is_point_cloud for part in obj.parts):
        middle: Floats = np.concatenate([part.vertices for part in obj.parts]).mean(axis=0)
        return middle
    corners = np.concatenate([part.vertices[part.faces] for part in obj.parts])
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(cross, axis=1)
    found: Floats = areas @ corners.mean(axis=1) / max(float(areas.sum()), 1e-300)
    return found


def _spread_samples(part: Part) -> Floats:
    """Return up to `CENTER_SAMPLES` points (s, 3) evenly spread over a part."""
    if part.is_point_cloud:
        return part.vertices[:: max(1, len(part.vertices) // CENTER_SAMPLES)]
    corners = part.vertices[part.faces]
    doubled = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    total = np.cumsum(doubled)
    if not total[-1] > 0:
        middles: Floats = corners.mean(axis=1)
        return middles
    steps = (np.arange(CENTER_SAMPLES) + 0.5) / CENTER_SAMPLES
    faces = np.minimum(np.searchsorted(total, steps * total[-1]), len(total) - 1)
    u, v = ((np.arange(1, CENTER_SAMPLES + 1)[:, None] / PLASTIC ** np.array([1, 2])) % 1.0).T
    over = u + v > 1  # fold the square onto the triangle
    u, v = np.where(over, 1 - u, u), np.where(over, 1 - v, v)
    a, b, c = corners[faces].transpose(1, 0, 2)
    points: Floats = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    return points


def _closest_on_triangles(corners: Floats, query: Floats) -> Floats:
    """Return (f, 3) the closest point of each triangle (f, 3, 3) to `query` (3,).

    Ericson, Real-Time Collision Detection (2005), section 5.1.5, for all triangles at once: the projection
    where it falls inside, else the best of the three clamped edges.
    """
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    squared = np.square(normal).sum(axis=1)
    safe = np.where(squared > 0, squared, 1.0)
    offset = query - a
    # Barycentric coordinates of the projection.
    v = (np.cross(offset, c - a) * normal).sum(axis=1) / safe
    w = (np.cross(b - a, offset) * normal).sum(axis=1) / safe
    inside = (squared > 0) & (v >= 0) & (w >= 0) & (v + w <= 1)
    best: Floats = a + v[:, None] * (b - a) + w[:, None] * (c - a)
    least = np.where(inside, np.square(best - query).sum(axis=1), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        edge = end - start
        length = np.square(edge).sum(axis=1)
        along = ((query - start) * edge).sum(axis=1) / np.where(length > 0, length, 1.0)
        point = start + np.clip(along, 0.0, 1.0)[:, None] * edge
        apart = np.square(point - query).sum(axis=1)
        closer = apart < least
        best = np.where(closer[:, None], point, best)
        least = np.where(closer, apart, least)
    closest: Floats = best
    return closest


def _face_normal(part: Part, face: int) -> Floats:
    """Return the outward unit normal (3,) of a face."""
    a, b, c = part.vertices[part.faces[face]]
    cross = np.cross(b - a, c - a)
    length = float(np.linalg.norm(cross))
    if length == 0:
        raise InputError(f"part {part.name!r} face {face}: it has no area and so no normal")
    normal: Floats = np.asarray(cross, np.float64) / (-length if _inside_out(part) else length)
    return normal


def _inside_out(part: Part) -> bool:
    """Tell whether a closed surface encloses a negative volume; open pieces are taken at their winding."""
    faces: Ints = part.faces
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    keys = edges[:, 0] * len(part.vertices) + edges[:, 1]
    back = edges[:, 1] * len(part.vertices) + edges[:, 0]
    if not np.array_equal(np.sort(keys), np.sort(back)):
        return False
    a, b, c = (part.vertices - part.vertices.mean(axis=0))[faces].transpose(1, 0, 2)
    return float((a * np.cross(b, c)).sum()) < 0


def _cloud_normal(part: Part, index: int) -> Floats:
    """Return the outward unit normal (3,) of a cloud's point."""
    if part.normals is not None and np.linalg.norm(part.normals[index]) > 0:
        given: Floats = part.normals[index] / np.linalg.norm(part.normals[index])
        return given
    offsets = part.vertices - part.vertices[index]
    near = np.argsort(np.square(offsets).sum(axis=1), kind="stable")[: CENTER_NEIGHBOURS + 1]
    patch = part.vertices[near] - part.vertices[near].mean(axis=0)
    normal: Floats = np.linalg.svd(patch, full_matrices=True)[2][-1]
    outwards = part.vertices[index] - part.vertices.mean(axis=0)
    side = float(normal @ outwards)
    outward: Floats = -normal if side < 0 else normal.copy()
    return outward

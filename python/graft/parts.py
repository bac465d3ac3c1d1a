"""Automatic parts: one fused mesh or point cloud in, an object made of parts out.

The work is the core's (`rust/graft-core/src/segment`); here meshes are gathered, clouds get neighbours and normals,
and what was repaired is told in notes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from graft import _core
from graft.errors import InputError
from graft.objects import Floats, Ints, Part, PartObject

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

MOST_NAMED = 32
"""An object of more parts than this is a soup whose pieces carry no meaning: they are fused before it is cut."""

FEWEST = 16
"""Fewer faces or points than this have no parts (the core's bound)."""

MOST_POINTS = 20_000
"""A larger cloud is cut on points spread evenly over it, and the others follow the nearest."""

NEIGHBOURS = 8
"""Neighbours of a cloud's point; fewer tear rims apart, more jump across gaps."""

PLANE = 16
"""Points that the normal of a cloud's point is fitted to."""

NOTED = 0.001
"""Faces wound inside out are told of above this share: the side of a few in a crevice cannot be told."""


@dataclass(frozen=True, eq=False)
class Cuts:
    """How a surface was cut.

    Attributes:
        levels: (l, e) part of each face or point, coarse to fine; parts are numbered by falling area.
        chosen: Which level people would make.
        kept: Log-odds that people make the least clear of the cuts.
        dropped: Log-odds that they make the clearest of those that were not made.
        notes: What was repaired or assumed.
    """

    levels: Ints
    chosen: int
    kept: float
    dropped: float
    notes: tuple[str, ...]

    @property
    def labels(self) -> Ints:
        """(e,) the chosen level."""
        found: Ints = self.levels[self.chosen]
        return found


def cut_part(part: Part, *, n_parts: int | None = None, hierarchy: bool = False, seed: int = 0) -> Cuts:
    """Cut one fused part.

    Args:
        part: A mesh of any quality, or a point cloud.
        n_parts: How many parts; as many as people would make when None. Fewer come out where the surface
            cannot be cut further, more where components that carry meaning do not touch.
        hierarchy: All levels from the coarsest to twice as many parts as people would make.
        seed: Of the points that the measures are taken at.

    Raises:
        InputError: `n_parts` is below 1 or given with `hierarchy`, `seed` is below 0, or there is no extent.
    """
    if n_parts is not None and (n_parts < 1 or hierarchy):
        raise InputError(f"n_parts: expected at least 1, and no hierarchy with it, got {n_parts}")
    if seed < 0:
        raise InputError(f"seed: expected at least 0, got {seed}")
    count, kind = (len(part.vertices), "points") if part.is_point_cloud else (len(part.faces), "faces")
    if count < FEWEST:
        note = f"{count} {kind if count > 1 else kind[:-1]}: too few to tell parts, one part"
        return Cuts(np.zeros((1, count), np.int64), 0, 0.0, 0.0, (note,))
    try:
        if part.is_point_cloud:
            return _cut_cloud(part, n_parts, hierarchy, seed)
        found = _core.segment_mesh(part.vertices, part.faces, parts=n_parts, hierarchy=hierarchy, seed=seed)
    except ValueError as error:
        raise InputError(f"part {part.name!r}: {error}") from None
    levels, chosen, (kept, dropped), repairs = found
    return Cuts(levels, chosen, kept, dropped, _notes(repairs, len(part.faces), levels[chosen]))


def _notes(repairs: tuple[int, int, int, int, int, int], count: int, labels: Ints) -> tuple[str, ...]:
    """Say what the core repaired."""
    open_edges, crowded, turned, components, joined, coarse = repairs
    cut = coarse or count
    notes = []
    if coarse:
        notes.append(f"cut on a copy of {coarse} faces, {count} follow it")
    if open_edges:
        notes.append(f"{open_edges} open edges")
    if crowded:
        notes.append(f"{crowded} edges of more than two faces")
    if turned > NOTED * cut:
        notes.append(f"{turned} of {cut} faces turned outward")
    if joined:
        notes.append(f"{joined} of {components} loose components joined to what lies nearest")
    if not labels.any():
        notes.append("no cut that people would make: one part")
    return tuple(notes)


def _cut_cloud(part: Part, n_parts: int | None, hierarchy: bool, seed: int) -> Cuts:
    """Cut a cloud on points spread evenly over it."""
    from scipy.spatial import cKDTree

    chosen = _spread(part.vertices, MOST_POINTS)
    points = np.ascontiguousarray(part.vertices[chosen])
    tree = cKDTree(points)
    width = min(NEIGHBOURS, len(points) - 1)
    near = np.asarray(tree.query(points, k=width + 1)[1], np.int64)
    # Of coinciding points a point need not be its own nearest: it is taken out of its row, else the last is.
    own = near == np.arange(len(points))[:, None]
    own[~own.any(axis=1), -1] = True
    neighbours = np.ascontiguousarray(near[~own].reshape(len(points), width))
    normals = part.normals[chosen] if part.normals is not None else _plane_normals(points, tree)
    levels, level, (kept, dropped), repairs = _core.segment_cloud(
        points, np.ascontiguousarray(normals), neighbours, parts=n_parts, hierarchy=hierarchy, seed=seed
    )
    nothing_open = (0, 0, 0, *repairs[3:])
    notes = _notes(nothing_open, len(points), levels[level])
    if len(points) < len(part.vertices):
        notes = (f"cut on {len(points)} of {len(part.vertices)} points", *notes)
        levels = levels[:, np.asarray(tree.query(part.vertices)[1])]
    return Cuts(levels, level, kept, dropped, notes)


def _spread(points: Floats, most: int) -> Ints:
    """Return the indices of at most `most` points, the first in each cell of the finest grid that leaves so few."""
    if len(points) <= most:
        return np.arange(len(points))
    low = points.min(axis=0)
    cell = float(np.linalg.norm(np.ptp(points, axis=0))) / np.sqrt(most)
    while True:
        first: Ints = np.sort(np.unique(np.floor((points - low) / cell).astype(np.int64), axis=0, return_index=True)[1])
        if len(first) <= most:
            return first
        cell *= 1.25


def _plane_normals(points: Floats, tree: cKDTree) -> Floats:
    """Return unit normals of planes fitted to each point's neighbours; their side is found in the core."""
    near = np.asarray(tree.query(points, k=min(PLANE, len(points)))[1])
    offsets = points[near] - points[near].mean(axis=1, keepdims=True)
    covariance: Floats = np.einsum("nki,nkj->nij", offsets, offsets)
    normals: Floats = np.linalg.eigh(covariance)[1][:, :, 0]
    return normals


def fused(obj: PartObject) -> Part:
    """Return all parts of an object as one.

    Raises:
        InputError: Some parts are meshes and others are point clouds.
    """
    if len(obj.parts) == 1:
        return obj.parts[0]
    clouds = [part.is_point_cloud for part in obj.parts]
    if any(clouds) and not all(clouds):
        raise InputError(f"object {obj.name!r}: expected meshes only or point clouds only, got both")
    starts = np.cumsum([0, *(len(part.vertices) for part in obj.parts[:-1])])
    normals = [part.normals for part in obj.parts if part.normals is not None]
    return Part(
        obj.name,
        np.concatenate([part.vertices for part in obj.parts]),
        np.concatenate([part.faces + start for part, start in zip(obj.parts, starts, strict=True)]),
        normals=np.concatenate(normals) if len(normals) == len(obj.parts) else None,
    )


def with_labels(obj: PartObject, part: Part, labels: Ints, notes: tuple[str, ...] = ()) -> PartObject:
    """Return `obj` with the pieces of `part` (all of it, fused) that labels tell, called part_0, part_1 and so on."""
    pieces = []
    for number in np.unique(labels).tolist():
        rows = np.flatnonzero(labels == number)
        if part.is_point_cloud:
            normals = None if part.normals is None else part.normals[rows]
            pieces.append(Part(f"part_{number}", part.vertices[rows], normals=normals))
        else:
            used, faces = np.unique(part.faces[rows], return_inverse=True)
            pieces.append(Part(f"part_{number}", part.vertices[used], faces.reshape(-1, 3)))
    return replace(obj, parts=tuple(pieces), joints=(), graspable=(), notes=(*obj.notes, *notes))


def cut_object(obj: PartObject, *, n_parts: int | None = None, fuse: bool = False, seed: int = 0) -> PartObject:
    """Return `obj` with automatic parts; see `graft.segment`."""
    if not fuse and (1 < len(obj.parts) <= MOST_NAMED or obj.joints):
        return replace(obj, notes=(*obj.notes, f"the {len(obj.parts)} parts it has are kept"))
    whole = fused(obj)
    cuts = cut_part(whole, n_parts=n_parts, seed=seed)
    told = [] if len(obj.parts) == 1 else [f"{len(obj.parts)} pieces fused before they were cut"]
    if obj.graspable:
        told.append("which of the new parts are graspable is not known")
    return with_labels(obj, whole, cuts.labels, (*told, *cuts.notes))


def cut_hierarchy(obj: PartObject, *, seed: int = 0) -> tuple[tuple[PartObject, ...], int]:
    """Return `obj` cut coarse to fine, and which level people would make; see `graft.segment_hierarchy`."""
    whole = fused(obj)
    cuts = cut_part(whole, hierarchy=True, seed=seed)
    return tuple(with_labels(obj, whole, labels, cuts.notes) for labels in cuts.levels), cuts.chosen

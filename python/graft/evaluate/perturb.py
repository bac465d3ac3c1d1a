"""Parts as a segmentation might give them: merged, split, with boundaries in the wrong place."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.random import Generator
from scipy.spatial import cKDTree

from graft.evaluate.metrics import sample_surface
from graft.objects import Floats, Ints, Part, PartObject

Defect = Literal["merged", "split", "shifted"]

SPLIT_RANGE = (0.3, 0.7)
"""A part is cut across its longest direction at a place drawn from this range of its elements."""

SHIFT = 0.03
"""A boundary moves by up to this share of the diagonal: a centimetre on an object of a foot."""

RAGGED = 0.01
"""Standard deviation of what each element adds to the boundary's move, same unit."""

LEAST_ELEMENTS = 16
"""Fewer faces or points are no part: a defect that would leave less is not applied."""

CONTACT_SAMPLES = 1024
"""Surface points by which parts that lie next to each other are found."""


@dataclass(frozen=True, eq=False)
class _Elements:
    """Faces (or points) of a whole object, each with the part it belongs to.

    Attributes:
        centers: (e, 3) of each element.
        areas: (e,) of the faces; 1 for points.
        drawn: (e,) part as drawn, whose corners the element has.
        owner: (e,) part now.
    """

    centers: Floats
    areas: Floats
    drawn: Ints
    owner: Ints

    @classmethod
    def of(cls, obj: PartObject) -> _Elements:
        centers, areas, drawn = [], [], []
        for index, part in enumerate(obj.parts):
            if part.is_point_cloud:
                centers.append(part.vertices)
                areas.append(np.ones(len(part.vertices)))
            else:
                corners = part.vertices[part.faces]
                centers.append(corners.mean(axis=1))
                normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
                areas.append(np.linalg.norm(normals, axis=1) / 2.0)
            drawn.append(np.full(len(centers[-1]), index, np.int64))
        owners = np.concatenate(drawn)
        return cls(np.concatenate(centers), np.concatenate(areas), owners, owners.copy())


def perturb_parts(obj: PartObject, diagonal: float, rng: Generator) -> tuple[PartObject, Defect | None]:
    """Give an object one defect of segmentation, drawn by `rng`.

    * merged: two neighbouring parts become one. Parts of which only one is graspable are never merged: no
      answer at the level of parts would exist;
    * split: a part, drawn by area, is cut in two across its longest direction;
    * shifted: the boundary between two neighbours moves by up to `SHIFT` of the diagonal and is ragged.

    A defect that the object does not allow (a merge of a two-part mug) gives way to the next one in this
    order. A new part is graspable when at least half of its area was, or, when that is true of none, the part
    with the largest share. Joints are dropped: their parts are not the same any more.

    Args:
        obj: With parts as drawn.
        diagonal: Of the object's box, object units.
        rng: Draws defect, part and place.

    Returns:
        The object with other parts in the same place, and what was done; None when no defect was possible.
    """
    elements = _Elements.of(obj)
    order: tuple[Defect, ...] = ("merged", "split", "shifted")
    start = int(rng.integers(len(order)))
    for defect in order[start:] + order[:start]:
        if defect == "merged":
            owner = _merged(obj, elements, diagonal, rng)
        elif defect == "split":
            owner = _split(elements, rng)
        else:
            owner = _shifted(obj, elements, diagonal, rng)
        counts = np.bincount(owner)
        if (owner != elements.drawn).any() and counts[counts > 0].min() >= LEAST_ELEMENTS:
            return _rebuilt(obj, replace(elements, owner=owner)), defect
    return obj, None


def _neighbours(obj: PartObject, diagonal: float) -> list[tuple[int, int]]:
    """Return the pairs of parts whose surfaces come closer than `SHIFT` of the diagonal."""
    surface = sample_surface(obj, CONTACT_SAMPLES)
    trees = [
        cKDTree(surface.points[surface.part == i]) if (surface.part == i).any() else None for i in range(len(obj.parts))
    ]
    pairs = []
    for i, first in enumerate(trees):
        for j in range(i + 1, len(trees)):
            second = trees[j]
            if first is None or second is None:
                continue
            if np.min(first.query(second.data)[0]) < SHIFT * diagonal:
                pairs.append((i, j))
    return pairs


def _merged(obj: PartObject, elements: _Elements, diagonal: float, rng: Generator) -> Ints:
    pairs = [(i, j) for i, j in _neighbours(obj, diagonal) if (i in obj.graspable) == (j in obj.graspable)]
    if not pairs:
        return elements.owner
    kept, gone = pairs[int(rng.integers(len(pairs)))]
    return np.where(elements.owner == gone, kept, elements.owner)


def _split(elements: _Elements, rng: Generator) -> Ints:
    areas = np.bincount(elements.owner, weights=elements.areas)
    part = int(rng.choice(len(areas), p=areas / areas.sum()))
    rows = np.flatnonzero(elements.owner == part)
    offsets = elements.centers[rows] - elements.centers[rows].mean(axis=0)
    longest = np.linalg.svd(offsets, full_matrices=False)[2][0]
    along = offsets @ longest
    owner = elements.owner.copy()
    owner[rows[along > np.quantile(along, rng.uniform(*SPLIT_RANGE))]] = len(areas)
    return owner


def _shifted(obj: PartObject, elements: _Elements, diagonal: float, rng: Generator) -> Ints:
    pairs = _neighbours(obj, diagonal)
    if not pairs:
        return elements.owner
    taker, giver = rng.permutation(pairs[int(rng.integers(len(pairs)))])
    rows = np.flatnonzero(elements.owner == giver)
    tree = cKDTree(elements.centers[elements.owner == taker])
    away = np.asarray(tree.query(elements.centers[rows])[0])
    move = rng.uniform(0.0, SHIFT) + RAGGED * rng.standard_normal(len(rows))
    owner = elements.owner.copy()
    # Distances are taken from the nearest element there is, so that a coarse mesh's boundary moves as well.
    owner[rows[away - away.min() < move * diagonal]] = taker
    return owner


def _rebuilt(obj: PartObject, elements: _Elements) -> PartObject:
    """Return `obj` with the parts that `elements.owner` tells, numbered in its order."""
    parts, shares = [], []
    mask = np.isin(elements.drawn, obj.graspable)
    for new in np.unique(elements.owner):
        rows = elements.owner == new
        pieces = [_piece(obj, elements, int(old), rows) for old in np.unique(elements.drawn[rows])]
        offsets = np.cumsum([0] + [len(piece.vertices) for piece in pieces[:-1]])
        normals = [piece.normals for piece in pieces if piece.normals is not None]
        parts.append(
            Part(
                name=obj.parts[new].name if new < len(obj.parts) else f"piece_{new}",
                vertices=np.concatenate([piece.vertices for piece in pieces]),
                faces=np.concatenate([piece.faces + o for piece, o in zip(pieces, offsets, strict=True)]),
                normals=np.concatenate(normals) if len(normals) == len(pieces) else None,
            )
        )
        areas = elements.areas[rows]
        shares.append(float(areas[mask[rows]].sum() / max(float(areas.sum()), np.finfo(float).tiny)))
    graspable = [i for i, share in enumerate(shares) if share >= 0.5] or [int(np.argmax(shares))]
    return replace(obj, parts=tuple(parts), joints=(), graspable=tuple(graspable) if obj.graspable else ())


def _piece(obj: PartObject, elements: _Elements, old: int, rows: np.ndarray) -> Part:
    """Return what part `old` gives to the elements `rows`, without the vertices that nobody uses."""
    part = obj.parts[old]
    chosen = np.flatnonzero(rows[elements.drawn == old])
    if part.is_point_cloud:
        normals = None if part.normals is None else part.normals[chosen]
        return replace(part, vertices=part.vertices[chosen], normals=normals, sweeps=())
    used, faces = np.unique(part.faces[chosen], return_inverse=True)
    return replace(part, vertices=part.vertices[used], faces=faces.reshape(-1, 3), sweeps=())

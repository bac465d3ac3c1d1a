"""From bodies with pieces of geometry to parts and joints: what MJCF, URDF and PartNet-Mobility share.

A body (MJCF) or link (URDF) moves as one; its pieces are geoms or visuals. Which of the two become parts is
the caller's choice; "auto" takes bodies when at least two carry geometry, and pieces when only one does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from graft.errors import InputError
from graft.objects import Floats, Ints, Joint, JointType, Part, unique_names

SURFACE_POINTS = 1000
"""Points on a part that tell which parts of two bodies come closest; on a cube 5 % of its diagonal apart."""

PLASTIC = 1.3247179572447460
"""The plastic number: its inverse powers give the evenly spread sequence R2 (Roberts 2018) on a square."""


@dataclass(frozen=True, eq=False)
class RigidPiece:
    """A rigid piece of a body: vertices (v, 3) and faces (f, 3) in the object frame.

    `named` is False where the file gives no name and one was made up.
    """

    name: str
    vertices: Floats
    faces: Ints
    label: str = ""
    notes: tuple[str, ...] = ()
    named: bool = True


@dataclass(frozen=True, eq=False)
class Freedom:
    """A joint of a body against its parent; axis (3,) and origin (3,) in the object frame."""

    kind: JointType
    name: str
    origin: Floats
    axis: Floats | None = None
    limits: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class Body:
    """A body: its parent's index in the list (None at the root), its joints to the parent, its pieces.

    A parent comes before its children. A body without freedoms is fixed to its parent.
    """

    name: str
    parent: int | None
    origin: Floats
    freedoms: tuple[Freedom, ...] = ()
    pieces: tuple[RigidPiece, ...] = ()
    fixed_name: str = ""


def check_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    """Raise `InputError` unless `value` is one of `choices`."""
    if value not in choices:
        raise InputError(f"{name}: expected one of {', '.join(choices)}, got {value!r}")


def parts_and_joints(bodies: Sequence[Body], *, whole: bool | None) -> tuple[tuple[Part, ...], tuple[Joint, ...]]:
    """Make parts and joints of `bodies`.

    Bodies without geometry disappear: the first body fixed to one stands for it, and where there is none its
    joints pass on to its descendants. Joints link the parts of two bodies whose surfaces come closest (of
    equals the first in the order of the file).

    Args:
        bodies: Parents before children.
        whole: True for one part per body, False for one per piece, None for bodies when several carry
            geometry.

    Raises:
        InputError: No body carries any geometry.
    """
    carrying = [index for index, body in enumerate(bodies) if body.pieces]
    if not carrying:
        raise InputError("expected some geometry, found none")
    if whole is None:
        whole = len(carrying) > 1
    pieces: list[RigidPiece] = []
    owned: dict[int, list[int]] = {}
    for index in carrying:
        body = bodies[index]
        new = [merged_piece(body.name, body.pieces)] if whole else body.pieces
        owned[index] = list(range(len(pieces), len(pieces) + len(new)))
        pieces.extend(new)
    names = unique_names(piece.name for piece in pieces)
    parts = tuple(
        Part(name, piece.vertices, piece.faces, label=piece.label or piece.name, notes=piece.notes)
        for name, piece in zip(names, pieces, strict=True)
    )
    joints: list[Joint] = []
    stands = _stand_ins(bodies)
    surfaces = _Surfaces(parts)
    for index in carrying:
        ancestor, freedoms = _to_ancestor(bodies, stands, index)
        if ancestor is None:
            continue
        parent, child = surfaces.closest(owned[ancestor], owned[index])
        if not freedoms:
            joints.append(Joint(parent, child, "fixed", bodies[index].fixed_name, origin=bodies[index].origin))
        joints.extend(
            Joint(parent, child, f.kind, f.name, axis=f.axis, origin=f.origin, limits=f.limits) for f in freedoms
        )
    return parts, tuple(joints)


def merged_piece(name: str, pieces: Sequence[RigidPiece]) -> RigidPiece:
    """Join `pieces` into one called `name`."""
    offsets = np.cumsum([0, *(len(piece.vertices) for piece in pieces[:-1])])
    faces = [piece.faces + offset for piece, offset in zip(pieces, offsets, strict=True)]
    return RigidPiece(
        name=name,
        vertices=np.concatenate([piece.vertices for piece in pieces]),
        faces=np.concatenate(faces),
        notes=tuple(note for piece in pieces for note in piece.notes),
    )


def _stand_ins(bodies: Sequence[Body]) -> list[int | None]:
    """Return for every body itself, or the first body with geometry that is fixed below it, or None."""
    stands: list[int | None] = [index if body.pieces else None for index, body in enumerate(bodies)]
    for index in range(len(bodies) - 1, 0, -1):  # children before parents; the first child is the last to write
        parent = bodies[index].parent
        if parent is not None and not bodies[parent].pieces and not bodies[index].freedoms:
            stands[parent] = stands[index] if stands[index] is not None else stands[parent]
    return stands


def _to_ancestor(bodies: Sequence[Body], stands: Sequence[int | None], index: int) -> tuple[int | None, list[Freedom]]:
    """Return the nearest ancestor with geometry (or its stand-in) and the joints from there to `index`."""
    freedoms = list(bodies[index].freedoms)
    ancestor = bodies[index].parent
    while ancestor is not None and stands[ancestor] in (None, index):
        freedoms[:0] = bodies[ancestor].freedoms
        ancestor = bodies[ancestor].parent
    return (None if ancestor is None else stands[ancestor]), freedoms


class _Surfaces:
    """Tells which parts come closest; keeps what it has sampled."""

    def __init__(self, parts: Sequence[Part]) -> None:
        self._parts = parts
        self._trees: dict[int, cKDTree] = {}
        self._boxes = [(part.vertices.min(axis=0), part.vertices.max(axis=0)) for part in parts]

    def closest(self, first: Sequence[int], second: Sequence[int]) -> tuple[int, int]:
        """Return the pair of parts, one of `first` and one of `second`, whose surfaces come closest."""
        pairs = sorted((self._box_gap(i, j), i, j) for i in first for j in second)
        best = (np.inf, *pairs[0][1:])
        for bound, i, j in pairs if len(pairs) > 1 else ():
            if bound > best[0]:
                break
            best = min(best, (float(np.min(self._tree(i).query(self._tree(j).data)[0])), i, j))
        return best[1], best[2]

    def _box_gap(self, i: int, j: int) -> float:
        """Return the distance of two bounding boxes, which that of the surfaces in them cannot be below."""
        (low, high), (other_low, other_high) = self._boxes[i], self._boxes[j]
        return float(np.linalg.norm(np.maximum(0.0, np.maximum(low - other_high, other_low - high))))

    def _tree(self, i: int) -> cKDTree:
        if i not in self._trees:
            self._trees[i] = cKDTree(_surface_points(self._parts[i]))
        return self._trees[i]


def _surface_points(part: Part) -> Floats:
    """Return the vertices of `part` and `SURFACE_POINTS` points spread over its faces by area."""
    corners = part.vertices[part.faces]
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.cumsum(np.linalg.norm(doubled, axis=1))
    if not len(areas) or areas[-1] == 0:
        return part.vertices
    count = np.arange(SURFACE_POINTS) + 0.5
    chosen = corners[np.searchsorted(areas, count * (areas[-1] / SURFACE_POINTS))]
    u, v = (count * PLASTIC**-1) % 1, (count * PLASTIC**-2) % 1
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    first, second, third = chosen[:, 0], chosen[:, 1], chosen[:, 2]
    spread = first + u[:, None] * (second - first) + v[:, None] * (third - first)
    return np.concatenate([part.vertices, spread])

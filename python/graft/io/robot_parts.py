"""From bodies with pieces of geometry to parts and joints: what MJCF, URDF and PartNet-Mobility share.

A body (MJCF) or link (URDF) moves as one; its pieces are geoms or visuals. Which of the two become parts is
the caller's choice; "auto" takes bodies when at least two of them carry geometry, and pieces when only one does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from graft.errors import InputError
from graft.objects import Floats, Ints, Joint, JointType, Part, unique_names


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


def parts_and_joints(
    bodies: Sequence[Body], *, whole: bool | None
) -> tuple[tuple[Part, ...], tuple[Joint, ...]]:
    """Make parts and joints of `bodies`.

    Bodies without geometry disappear; their joints pass on to the next descendant that has some. Joints link
    the parts of two bodies that lie closest to each other (the first such pair in the order of the file).

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
    for index in carrying:
        ancestor, freedoms, fixed_name = _to_ancestor(bodies, index)
        if ancestor is None:
            continue
        parent, child = _closest(parts, owned[ancestor], owned[index])
        if not freedoms:
            joints.append(Joint(parent, child, "fixed", fixed_name, origin=bodies[index].origin))
        joints.extend(
            Joint(parent, child, f.kind, f.name, axis=f.axis, origin=f.origin, limits=f.limits)
            for f in freedoms
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


def _to_ancestor(bodies: Sequence[Body], index: int) -> tuple[int | None, list[Freedom], str]:
    """Return the nearest ancestor with geometry, the joints down from it, the name if all are fixed."""
    freedoms = list(bodies[index].freedoms)
    ancestor = bodies[index].parent
    while ancestor is not None and not bodies[ancestor].pieces:
        freedoms[:0] = bodies[ancestor].freedoms
        ancestor = bodies[ancestor].parent
    return ancestor, freedoms, bodies[index].fixed_name


def _closest(parts: Sequence[Part], first: Sequence[int], second: Sequence[int]) -> tuple[int, int]:
    """Return the pair of parts, one of `first` and one of `second`, with the closest vertices."""
    if len(first) == 1 and len(second) == 1:
        return first[0], second[0]
    trees = {i: cKDTree(parts[i].vertices) for i in first}
    gaps = [(float(np.min(trees[i].query(parts[j].vertices)[0])), i, j) for i in first for j in second]
    _, parent, child = min(gaps)
    return parent, child

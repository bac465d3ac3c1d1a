"""A piece: what a mesh file holds under one name, before it becomes a part."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from graft.errors import InputError
from graft.objects import Floats, Ints

Mask = NDArray[np.bool_]

FLAT_TRIANGLE = 1e-12
"""A triangle whose doubled area is below this share of its longest edge squared has no area in double
precision."""


FARTHEST = 1e100
"""A coordinate beyond this counts as infinite: no unit makes it a place, and its square would overflow."""


class Piece(NamedTuple):
    """A named piece of surface, or of a point cloud when it has no faces; cleaned.

    Attributes:
        name: As in the file; not necessarily unique.
        vertices: (v, 3) finite, file units; every vertex of a surface is used by a face.
        faces: (f, 3) in range, none without area; (0, 3) for a point cloud.
        normals: (v, 3) of a point cloud's points; None for surfaces and where the file has none.
        notes: What was dropped.
    """

    name: str
    vertices: Floats
    faces: Ints
    normals: Floats | None
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class RawMesh:
    """What a file says under one name, in the file's order, before anything is dropped.

    Attributes:
        name: As in the file.
        vertices: (v, 3) float64, possibly with NaN.
        faces: (f, 3) int64, polygons cut into fans.
        polygon: (f,) number of the polygon each triangle was cut from; None when the file has triangles only.
        normals: (v, 3) or None.
        vertex_labels: (v,) int64 or None.
        face_labels: (p,) int64 per polygon, or None.
    """

    name: str
    vertices: Floats
    faces: Ints = field(default_factory=lambda: np.empty((0, 3), np.int64))
    polygon: Ints | None = None
    normals: Floats | None = None
    vertex_labels: Ints | None = None
    face_labels: Ints | None = None

    @property
    def n_polygons(self) -> int:
        """Number of faces as the file counts them."""
        return len(self.faces) if self.polygon is None else int(self.polygon[-1]) + 1 if len(self.polygon) else 0

    def with_faces(self, name: str, chosen: Ints) -> RawMesh:
        """Return the piece of surface made of the triangles `chosen`, under another name."""
        faces = self.faces[chosen]
        used, index = np.unique(faces, return_inverse=True)
        return RawMesh(name, self.vertices[used], index.reshape(-1, 3))

    def with_points(self, name: str, chosen: Ints) -> RawMesh:
        """Return the piece of cloud made of the points `chosen`, under another name."""
        normals = None if self.normals is None else self.normals[chosen]
        return RawMesh(name, self.vertices[chosen], normals=normals)


def fan(polygons: list[list[int]]) -> tuple[Ints, Ints]:
    """Cut polygons into triangle fans about their first corner.

    Polygons of fewer than three corners become a triangle without area, so that they are counted when it is
    dropped.

    Returns:
        (f, 3) triangles and (f,) the polygon each came from, which never skips one.
    """
    triangles = []
    origin = []
    for number, corners in enumerate(polygons):
        full = corners if len(corners) >= 3 else [*(corners or [0])[:1]] * 3
        for k in range(1, len(full) - 1):
            triangles.append((full[0], full[k], full[k + 1]))
            origin.append(number)
    return np.array(triangles, np.int64).reshape(-1, 3), np.array(origin, np.int64)


def check_range(faces: Ints, n_vertices: int, what: str = "face") -> None:
    """Refuse faces that name vertices which do not exist.

    Raises:
        InputError: Naming the first such face.
    """
    wrong = (faces < 0) | (faces >= n_vertices)
    if wrong.any():
        row = int(np.flatnonzero(wrong.any(axis=1))[0])
        raise InputError(f"{what} {row}: vertex index out of range, {faces[row].tolist()} of {n_vertices} vertices")


def merged(name: str, meshes: list[RawMesh]) -> RawMesh:
    """Return several meshes as one, in order."""
    if len(meshes) == 1:
        return replace(meshes[0], name=name)
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    counts = np.cumsum([0, *(m.n_polygons for m in meshes)])
    polygons = [
        (np.arange(len(m.faces)) if m.polygon is None else m.polygon) + n
        for m, n in zip(meshes, counts[:-1], strict=True)
    ]
    normals = [m.normals for m in meshes if m.normals is not None]
    return RawMesh(
        name,
        np.concatenate([m.vertices for m in meshes]),
        np.concatenate([m.faces + n for m, n in zip(meshes, starts[:-1], strict=True)]),
        polygon=np.concatenate(polygons),
        normals=np.concatenate(normals) if len(normals) == len(meshes) else None,
    )


def cleaned(mesh: RawMesh) -> Piece:
    """Drop what has no place on a surface, and count it: faces with NaN corners or without area, NaN points.

    Vertices that no face uses are left out without a word: they are not on the surface.

    Raises:
        InputError: Nothing is left, or a face is out of range.
    """
    vertices, faces, normals = mesh.vertices, mesh.faces, mesh.normals
    where = f"{mesh.name!r}"
    if len(vertices) == 0:
        raise InputError(f"{where}: no vertices")
    notes = []
    finite: Mask = np.asarray((np.abs(vertices) < FARTHEST).all(axis=1))  # NaN compares false
    if not len(faces):
        if normals is not None:
            finite &= np.isfinite(normals).all(axis=1)
        if not finite.all():
            notes.append(f"dropped {int((~finite).sum())} of {len(vertices)} points that are not finite")
        if not finite.any():
            raise InputError(f"{where}: none of the {len(vertices)} points is finite")
        normals = None if normals is None else _unit_normals(normals[finite])
        return Piece(mesh.name, vertices[finite], np.empty((0, 3), np.int64), normals, tuple(notes))

    check_range(faces, len(vertices), f"{where} face")
    good = finite[faces].all(axis=1)
    if not good.all():
        notes.append(
            f"dropped {int((~good).sum())} of {len(faces)} faces with corners that are not finite "
            f"({int((~finite).sum())} vertices)"
        )
    solid = np.zeros(len(faces), bool)
    solid[good] = has_area(vertices, faces[good])
    if (good & ~solid).any():
        notes.append(f"dropped {int((good & ~solid).sum())} of {len(faces)} faces without area")
    if not solid.any():
        raise InputError(f"{where}: none of the {len(faces)} faces has an area and finite corners")
    faces = faces[solid]
    used = np.zeros(len(vertices), bool)
    used[faces] = True
    if not used.all():
        faces = (np.cumsum(used) - 1)[faces]
        vertices = vertices[used]
    return Piece(mesh.name, vertices, faces, None, tuple(notes))


def has_area(vertices: Floats, faces: Ints) -> Mask:
    """Return (f,) whether each triangle has an area worth the name, in any unit."""
    corners = vertices[faces]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    # Scaled by the longest edge first, so that neither tiny nor huge units underflow or overflow.
    edges = np.stack([a, b, b - a])
    longest = np.abs(edges).max(axis=(0, 2))
    safe = np.where(longest > 0, longest, 1.0)[:, None]
    doubled = np.linalg.norm(np.cross(a / safe, b / safe), axis=1)
    found: Mask = (longest > 0) & (doubled > FLAT_TRIANGLE)
    return found


def _unit_normals(normals: Floats) -> Floats | None:
    """Return normals of length one, or None when some have no direction: half a set tells no side."""
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / length if (length > 0).all() else None

"""Watertight surfaces: lofts through rings, from which lathes, vessels, tubes and slabs are made. Metres."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from graft.objects import Floats, Ints
from graft.zoo.curves import spaced, spline, superellipse

SEGMENTS = 40
"""Points around a lathe."""

TUBE_SEGMENTS = 20
"""Points around a tube."""

CAP_RINGS = 3
"""Rings between a flat end's edge and its middle, so that no face reaches across a large flat end."""

SECTOR_SAGITTA = 0.0006
"""How far, metres, the chord of a sector of a vessel's wall may cut into the cavity (what a hull of it adds) ..."""

SECTOR_SAGITTA_SHARE = 0.008
"""... or this share of the vessel's radius, if that is more: no more sectors on a bucket than on a cup."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed triangle mesh whose normals point outwards.

    Attributes:
        vertices: (v, 3) metres.
        faces: (f, 3).
        sweeps: As in `graft.objects.Part`: (k, m) indices of the loops that solid pieces are swept through.
    """

    vertices: Floats
    faces: Ints
    sweeps: tuple[Ints, ...] = ()

    def moved(self, translation: ArrayLike = (0.0, 0.0, 0.0), rotation: Floats | None = None) -> Mesh:
        """Return the mesh turned by `rotation` (3, 3) and then shifted by `translation` (3,)."""
        turned = self.vertices if rotation is None else self.vertices @ rotation.T
        return replace(self, vertices=turned + np.asarray(translation, float))

    def warped(self, displace: Callable[[Floats], Floats]) -> Mesh:
        """Return the mesh with its vertices (v, 3) replaced by `displace` of them, which must not mirror."""
        return replace(self, vertices=displace(self.vertices))


def merged(*meshes: Mesh) -> Mesh:
    """Return several closed meshes as one."""
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    faces = [m.faces + start for m, start in zip(meshes, starts[:-1], strict=True)]
    sweeps = [sweep + start for m, start in zip(meshes, starts[:-1], strict=True) for sweep in m.sweeps]
    return Mesh(np.vstack([m.vertices for m in meshes]), np.vstack(faces), tuple(sweeps))


def widened(vertices: Floats, scale: Floats) -> Floats:
    """Return `vertices` (v, 3) with x and y multiplied by `scale` (v,)."""
    result = vertices.copy()
    result[:, :2] *= scale[:, None]
    return result


def turned(axis: ArrayLike, angle: float) -> Floats:
    """Return the (3, 3) rotation by `angle` radians about `axis` (3,) (Rodrigues' formula)."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation: Floats = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return rotation


def facing(direction: ArrayLike) -> Floats:
    """Return a (3, 3) rotation that carries +z to `direction` (3,), for lathes that do not stand upright."""
    z = np.asarray(direction, float) / np.linalg.norm(direction)
    hint = np.array([0.0, 1.0, 0.0]) if abs(z[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    x = np.cross(hint, z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def loft(rings: Floats, *, closed: bool = False) -> Mesh:
    """Return the surface through `rings` (k, m, 3), each a loop in the same sense.

    The ends are closed flat over `CAP_RINGS` rings, unless `closed` joins the last ring to the first.
    The winding is turned outwards by the sign of the enclosed volume. The one sweep goes through `rings` in order.
    """
    start = 0 if closed else CAP_RINGS - 1
    sweep = (start + np.arange(len(rings)))[:, None] * rings.shape[1] + np.arange(rings.shape[1])
    sweep = np.vstack([sweep, sweep[:1]]) if closed else sweep
    if not closed:
        inward = np.linspace(1.0, 0.0, CAP_RINGS + 1)[1:-1, None, None]
        first, last = rings[0].mean(axis=0), rings[-1].mean(axis=0)
        rings = np.concatenate(
            [
                first + (rings[0] - first) * inward[::-1],
                rings,
                last + (rings[-1] - last) * inward,
            ]
        )
    k, m, _ = rings.shape
    row = np.arange(k if closed else k - 1)[:, None] * m
    i, j = np.arange(m), (np.arange(m) + 1) % m
    a, b = row + i, row + j
    c, d = (row + m + j) % (k * m), (row + m + i) % (k * m)
    faces = [np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)]
    vertices = rings.reshape(-1, 3)
    if not closed:
        top = (k - 1) * m
        faces.append(np.stack([j, i, np.full(m, k * m)], -1))
        faces.append(np.stack([top + i, top + j, np.full(m, k * m + 1)], -1))
        vertices = np.vstack([vertices, rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    return _outward(vertices, np.vstack(faces), sweep)


def _outward(vertices: Floats, faces: Ints, sweep: Ints) -> Mesh:
    """Return the mesh wound so that it encloses a positive volume."""
    a, b, c = (vertices[faces[:, i]] - vertices.mean(axis=0) for i in range(3))
    volume = float(np.einsum("ij,ij->", a, np.cross(b, c)))
    return Mesh(vertices, faces if volume > 0 else faces[:, ::-1].copy(), (sweep,))


def side(
    height: float,
    radii: Sequence[float],
    *,
    base: float = 0.0,
    fillet: float = 0.0,
    shoulder: float = 0.0,
    count: int = 18,
) -> Floats:
    """Return a body's outline (n, 2) as (radius, z) from z = `base` to z = `base + height`.

    Args:
        height: Height of the outline.
        radii: Radii at equally spaced heights; a smooth curve goes through them.
        base: Height where it starts.
        fillet: Rounding of the lower edge.
        shoulder: Rounding of the upper edge.
        count: Number of points between the roundings.
    """
    turn = np.linspace(0.0, np.pi / 2, 6)[:-1]
    low = fillet * (1 - np.cos(turn))
    high = height - shoulder * (1 - np.cos(turn[::-1]))
    z = np.concatenate([low if fillet else [], np.linspace(fillet, height - shoulder, count), high if shoulder else []])
    r = spline(radii, z / height)
    if fillet:
        r = r - fillet * (1 - np.sqrt(1 - np.clip(1 - z / fillet, 0, 1) ** 2))
    if shoulder:
        r = r - shoulder * (1 - np.sqrt(1 - np.clip(1 - (height - z) / shoulder, 0, 1) ** 2))
    return np.stack([r, z + base], axis=1)


def radius_at(outline: Floats, z: float) -> float:
    """Return the radius of an outline (n, 2) of (radius, z) at height `z`."""
    return float(np.interp(z, outline[:, 1], outline[:, 0]))


def lathe(
    profile: ArrayLike, *, section: Floats | None = None, step: float | None = None, closed: bool = False
) -> Mesh:
    """Return the solid whose outline (k, 2) of (radius, z) is turned about z.

    Args:
        profile: Outline from its lower to its upper end, both closed flat; a loop when `closed`.
        section: (m, 2) loop that replaces the circle of radius 1.
        step: Longest segment along the outline; None takes the outline as it is.
        closed: Whether the outline is a loop off the axis (a ring).
    """
    line = np.asarray(profile, float)
    if closed:
        line = np.vstack([line, line[:1]]) if step else line
    if step:
        line = spaced(line, step)
    if closed and step:
        line = line[:-1]
    loop = superellipse(SEGMENTS) if section is None else section
    rings = np.empty((len(line), len(loop), 3))
    rings[:, :, :2] = line[:, :1, None] * loop
    rings[:, :, 2] = line[:, 1:]
    solid = loft(rings, closed=closed)
    if not closed:
        return solid
    # The rings of a ring lie around its hole: what is solid is swept through its sections, about z.
    sections = np.arange(rings.shape[0] * rings.shape[1]).reshape(rings.shape[:2]).T
    return replace(solid, sweeps=(np.vstack([sections, sections[:1]]),))


def vessel(outline: Floats, wall: float, floor: float, *, section: Floats | None = None) -> Mesh:
    """Return an open vessel with an inner wall.

    Args:
        outline: (n, 2) outside as (radius, z), upwards, as from `side`.
        wall: Thickness of the wall.
        floor: Thickness of the floor.
        section: As in `lathe`.
    """
    bottom, top = outline[0, 1] + floor, outline[-1, 1]
    half = wall / 2
    lip = np.linspace(0.0, np.pi, 7)[1:-1]
    rim = np.stack([outline[-1, 0] - half + half * np.cos(lip), top + half * np.sin(lip)], axis=1)
    z = np.linspace(top, bottom, max(8, len(outline) - 8))
    inside = np.stack([np.interp(z, outline[:, 1], outline[:, 0]) - wall, z], axis=1)
    solid = lathe(np.vstack([outline, rim, inside]), section=section)
    return replace(solid, sweeps=_wall_sweeps(solid.sweeps[0], outline, len(rim), z))


def _wall_sweeps(rows: Ints, outline: Floats, n_rim: int, z_inside: Floats) -> tuple[Ints, ...]:
    """Return a vessel's sweeps: its floor, then its wall as sectors, each swept upwards.

    Args:
        rows: (n + r + i, m) the vessel's own rings: up the outline (n, 2), over the rim, down the inside.
        outline: (n, 2) as (radius, z).
        n_rim: Number of rings of the rim.
        z_inside: (i,) heights of the inside's rings, downwards.
    """
    n, m = len(outline), rows.shape[1]
    inside = np.arange(len(rows) - 1, n + n_rim - 1, -1)
    outside = np.abs(outline[:, 1] - z_inside[::-1, None]).argmin(axis=1)
    lip = np.arange(n, n + (n_rim + 1) // 2)
    inner = np.concatenate([inside, (2 * n + n_rim - 1) - lip])
    outer = np.concatenate([outside, lip])
    share = max(SECTOR_SAGITTA_SHARE, SECTOR_SAGITTA / float(outline[:, 0].max()))
    angle = 2 * np.arccos(max(0.0, 1 - share))
    count = int(np.ceil(m / max(1, int(angle / (2 * np.pi / m) + 0.15))))
    edges = np.linspace(0, m, count + 1).round().astype(int)
    floor = np.vstack([rows[: outside[0] + 1], rows[inside[:1]]])
    sectors = []
    for a, b in itertools.pairwise(edges):
        arc = np.arange(a, b + 1) % m
        sectors.append(np.hstack([rows[outer][:, arc], rows[inner][:, arc[::-1]]]))
    return (floor, *sectors)


def ring(radius: float, z: float, width: float, height: float, *, section: Floats | None = None) -> Mesh:
    """Return a rounded ring about z: mean `radius` at height `z`, of `width` across and `height` along z."""
    loop = superellipse(14, width / 2, height / 2, 2.6)
    return lathe(loop + np.array((radius, z)), section=section, closed=True)


def seated(handle: Mesh, outline: Floats, depth: float) -> Mesh:
    """Return a handle whose ends lie in the wall: nothing is deeper than `depth` under the outline (n, 2)."""

    def pushed_out(vertices: Floats) -> Floats:
        radius = np.linalg.norm(vertices[:, :2], axis=1)
        least = np.interp(vertices[:, 2], outline[:, 1], outline[:, 0]) - depth
        scale = np.maximum(1.0, least / np.maximum(radius, depth))
        return widened(vertices, scale)

    return handle.warped(pushed_out)


def tube(
    path: Floats,
    across: ArrayLike,
    width: ArrayLike,
    thickness: ArrayLike | None = None,
    *,
    exponent: float = 2.0,
    dome: bool = True,
    bore: float = 0.0,
    closed: bool = False,
    segments: int = TUBE_SEGMENTS,
) -> Mesh:
    """Return a tube of superelliptic section along a curve.

    Args:
        path: (n, 3) centre line.
        across: (3,) direction of the section's width, never along the path; a flat curve's normal.
        width: Full width along `across`; one number or n.
        thickness: Full extent across both; as the width when None.
        exponent: Of the section: 2 is an ellipse, more is squarer.
        dome: Whether the ends bulge; flat otherwise.
        bore: Depth of a hole in the last end (a spout's mouth).
        closed: Whether the path is a loop (its first point not repeated).
        segments: Points around.
    """
    n = len(path)
    ahead = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    tangent = ahead if closed else np.gradient(path, axis=0)
    tangent = tangent / np.linalg.norm(tangent, axis=1, keepdims=True)
    normal = np.cross(tangent, np.asarray(across, float))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    binormal = np.cross(normal, tangent)
    half_width = np.broadcast_to(np.asarray(width, float), n) / 2
    half_thick = half_width if thickness is None else np.broadcast_to(np.asarray(thickness, float), n) / 2
    unit = superellipse(segments, exponent=exponent)
    offsets = (
        half_width[:, None, None] * unit[None, :, :1] * binormal[:, None]
        + half_thick[:, None, None] * unit[None, :, 1:] * normal[:, None]
    )
    rings = path[:, None] + offsets
    if closed:
        return loft(rings, closed=True)
    bulge = np.linspace(0.0, np.pi / 2, 5)[1:-1, None, None]
    ends = []
    for i, sign in ((0, -1.0), (-1, 1.0)):
        reach = sign * min(half_width[i], half_thick[i]) * tangent[i]
        ends.append(path[i] + offsets[i] * np.cos(bulge) + reach * np.sin(bulge))
    if bore:
        mouth = path[-1] + offsets[-1] * 0.74
        ends[1] = np.stack([mouth, mouth - bore * tangent[-1]])
    start = [ends[0][::-1]] if dome else []
    stop = [ends[1]] if dome or bore else []
    solid = loft(np.concatenate([*start, rings, *stop]))
    # A bore's rings lead back into the tube: pieces fill it.
    return replace(solid, sweeps=(solid.sweeps[0][: len(solid.sweeps[0]) - 2],)) if bore else solid


def slab(outline: Floats, thickness: float, edge: float, *, top: float | None = None) -> Mesh:
    """Return a plate with rounded edges, from z = 0 to z = `thickness`.

    Args:
        outline: (m, 2) loop around the origin.
        thickness: Along z.
        edge: Rounding of the edges, at most half the thickness.
        top: Rounding of the upper edge where it differs.
    """
    half = np.abs(outline).max(axis=0)
    turn = np.linspace(0.0, np.pi / 2, 5)
    upper = edge if top is None else top
    inset = np.concatenate([edge * (1 - np.sin(turn)), upper * (1 - np.sin(turn[::-1]))])
    z = np.concatenate([edge * (1 - np.cos(turn)), thickness - upper * (1 - np.cos(turn[::-1]))])
    if thickness - edge - upper < 1e-6:
        inset, z = np.delete(inset, 4), np.delete(z, 4)
    scale = 1 - inset[:, None] / half
    rings = np.empty((len(z), len(outline), 3))
    rings[:, :, :2] = outline * scale[:, None]
    rings[:, :, 2] = z[:, None]
    return loft(rings)

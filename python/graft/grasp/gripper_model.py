"""A parallel gripper from the MJCF or URDF of its hand: two fingers on slide joints, and what carries them.

Hands are rarely boxes, so fingers and palm are cut into slabs along the approach, and slabs that make up about one box
are joined again. On a Panda's hand that follows the shape closer than minimal boxes, which a bulge tilts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np

from graft.checks import Floats, Ints
from graft.errors import InputError
from graft.grasp.gripper import Box, Gripper
from graft.io.robot_parts import Body, Freedom, RigidPiece, merged_piece
from graft.io.robot_xml import read_description

SLABS = 16
"""Slabs that fingers and palm are cut into: 3.4 mm of a Panda's finger, a fifth of its pad."""

FILLED = 0.75
"""Slabs are joined while they fill this share of the box around them."""

PAD_DEPTH = 1.5e-3
"""Metres behind the innermost surface that still belong to the pad: grooves of rubber, rounded tips."""

ALIKE = 5e-3
"""Metres by which the boxes around two mirrored fingers may differ along the closing and the approach."""

PARALLEL = 0.999
"""Cosine of the angle between joint axes that are parallel, 2.6 degrees."""

THINNEST = 2e-4
"""Metres that a flat piece of geometry is thick."""


def gripper_from_model(path: Path, *, packages: Mapping[str, Path] | None = None) -> Gripper:
    """Return the gripper that a robot description ends in.

    Its two fingers are the only two bodies on parallel slide joints of one palm, which is what carries them with all
    that is fixed to it; the joints must be limited. y is the axis of the joints, z the axis of the model's root that
    leads best from the palm to the fingers, and the TCP lies in the middle of the pads, those slabs from the tip on
    that are innermost. The flange is the origin of the body that carries the fingers, its axes those of the gripper;
    forces and mass are `Gripper`'s defaults.

    Args:
        path: MJCF or URDF.
        packages: See `load_object`.

    Raises:
        InputError: The file cannot be read, or does not end in such a gripper.
        MissingExtraError: MuJoCo is not installed and the file is MJCF.
    """
    try:
        return _gripper(path.stem, _bodies(path, packages or {}))
    except InputError as error:
        raise (error if error.path is not None else InputError(str(error), path=path)) from None


def _bodies(path: Path, packages: Mapping[str, Path]) -> Sequence[Body]:
    root = read_description(path)
    if root.tag == "robot":
        from graft.io.urdf import read_scene
        from graft.io.urdf_file import parse_robot

        return read_scene(path, parse_robot(path, root), packages=packages, missing="error").bodies
    if root.tag == "mujoco":
        from graft.io.mjcf import read_bodies

        return read_bodies(path, packages=packages).bodies
    raise InputError(f"expected <mujoco> or <robot>, got <{root.tag}>", path=path)


def _gripper(name: str, bodies: Sequence[Body]) -> Gripper:
    groups = _rigid_groups(bodies)
    (first, joint), (second, other) = _fingers(bodies, groups)
    carrier = bodies[first].parent or 0
    palm = merged_piece("palm", _pieces(bodies, groups, int(groups[carrier]), "the palm"))
    sides = [
        merged_piece("finger", _pieces(bodies, groups, i, f"the finger {bodies[i].name!r}")) for i in (first, second)
    ]
    axes = _axes(palm.vertices, [side.vertices for side in sides], joint)

    # Both fingers wide open, the second one mirrored, so that both lie at +y of the plane between them.
    right = sides[0].vertices @ axes + [0.0, _furthest(joint, axes[:, 1]), 0.0]
    left = sides[1].vertices @ axes - [0.0, _furthest(other, -axes[:, 1]), 0.0]
    left[:, 1] *= -1.0
    inner, inner_left = (
        _pad(_slabs(points, side.faces)).low[1] for points, side in zip((right, left), sides, strict=True)
    )
    stroke = float(inner + inner_left)
    if stroke <= 0:
        raise InputError("the fingers touch or overlap when they are open")
    # One finger turned by half about the approach is as usual as one mirrored: boxes hold both, laid on each other.
    left[:, 1] += inner - inner_left
    ends = [np.stack([points.min(axis=0), points.max(axis=0)])[:, 1:] for points in (right, left)]
    difference = float(np.abs(ends[0] - ends[1]).max())
    if difference > ALIKE:
        raise InputError(f"the fingers are no mirror images of each other: they differ by {1000 * difference:.2g} mm")
    slabs = _slabs(np.concatenate([right, left]), np.concatenate([sides[0].faces, sides[1].faces + len(right)]))
    pad = _pad(slabs)

    center = (pad.low + pad.high) / 2.0
    origin = np.array([center[0], pad.low[1], center[2]])
    tcp = np.array([center[0], (inner - inner_left) / 2.0, center[2]])
    boxes = [pad, *_joined([slab for slab in slabs if slab.high[2] <= pad.low[2]])]
    flange = np.eye(4)
    flange[:3, 3] = tcp - bodies[carrier].origin @ axes
    return Gripper(
        name,
        stroke,
        tuple(box.placed(tcp) for box in _joined(_slabs(palm.vertices @ axes, palm.faces))),
        tuple(box.placed(origin) for box in boxes),
        flange,
    )


def _fingers(bodies: Sequence[Body], groups: Ints) -> list[tuple[int, Freedom]]:
    """Return the two bodies that slide on one palm along parallel axes, and their joints."""
    slides = [(i, body.freedoms[0]) for i, body in enumerate(bodies) if [f.kind for f in body.freedoms] == ["slide"]]
    pairs = [
        [first, second]
        for first, second in combinations(slides, 2)
        if _palm(bodies, groups, first[0]) == _palm(bodies, groups, second[0]) is not None
        and abs(np.asarray(first[1].axis) @ np.asarray(second[1].axis)) >= PARALLEL
    ]
    if len(pairs) != 1:
        hinges = sum(f.kind == "hinge" for body in bodies for f in body.freedoms)
        names = f" ({', '.join(f.name for _, f in slides)})" if slides else ""
        raise InputError(
            f"expected two fingers on parallel slide joints of one palm, found {len(pairs)} such pairs among "
            f"{len(slides)} slide joints{names} and {hinges} hinges; describe grippers with linkages in a .toml file"
        )
    for _, freedom in pairs[0]:
        if freedom.limits is None or not np.isfinite(freedom.limits).all() or np.ptp(freedom.limits) <= 0:
            raise InputError(f"joint {freedom.name!r}: expected limits, the stroke, got {freedom.limits}")
    return pairs[0]


def _palm(bodies: Sequence[Body], groups: Ints, finger: int) -> int | None:
    """Return the group of bodies that carries a finger."""
    carrier = bodies[finger].parent
    return None if carrier is None else int(groups[carrier])


def _rigid_groups(bodies: Sequence[Body]) -> Ints:
    """Return (b,) for every body the first one that it is fixed to, itself where it moves."""
    groups = np.arange(len(bodies))
    for i, body in enumerate(bodies):
        if body.parent is not None and not body.freedoms:
            groups[i] = groups[body.parent]
    return groups


def _pieces(bodies: Sequence[Body], groups: Ints, group: int, what: str) -> list[RigidPiece]:
    pieces = [piece for i in np.flatnonzero(groups == group).tolist() for piece in bodies[i].pieces]
    if not pieces:
        raise InputError(f"{what} has no geometry")
    return pieces


def _axes(palm: Floats, fingers: Sequence[Floats], joint: Freedom) -> Floats:
    """Return (3, 3) the gripper's axes in columns, in the model's root frame."""
    y = np.asarray(joint.axis)
    centers = [(p.min(axis=0) + p.max(axis=0)) / 2.0 for p in (palm, *fingers)]
    if y @ (centers[1] - centers[2]) < 0:
        y = -y
    ahead = (centers[1] + centers[2]) / 2.0 - centers[0]
    ahead -= y * (y @ ahead)
    candidates = np.concatenate([np.eye(3), -np.eye(3)])
    candidates = candidates[np.abs(candidates @ y) < np.sqrt(1.0 - PARALLEL**2)]
    best = candidates[int(np.argmax(candidates @ ahead))] if len(candidates) else ahead
    z = best - y * (y @ best)
    z /= np.linalg.norm(z)
    if z @ ahead < np.cos(np.radians(45.0)) * np.linalg.norm(ahead):
        raise InputError("no axis of the model leads from the palm to the fingers: the approach is not clear")
    return np.stack([np.cross(y, z), y, z], axis=1)


def _furthest(joint: Freedom, outward: Floats) -> float:
    """Return how far a finger slides along `outward` (3,) from where the file has it, metres."""
    sign = float(np.sign(np.asarray(joint.axis) @ outward))
    return max(sign * limit for limit in joint.limits or ())


@dataclass(frozen=True, eq=False)
class _Slab:
    """The box around a slice: two opposite corners (3,)."""

    low: Floats
    high: Floats

    def joined(self, other: _Slab) -> _Slab:
        return _Slab(np.minimum(self.low, other.low), np.maximum(self.high, other.high))

    def placed(self, origin: Floats) -> Box:
        """Return the box seen from `origin` (3,), a flat one thickened away from the pads."""
        high = np.maximum(self.high, self.low + THINNEST)
        return Box.spanning(self.low - origin, high - origin)

    @property
    def volume(self) -> float:
        return float(np.prod(self.high - self.low))


def _slabs(vertices: Floats, faces: Ints) -> list[_Slab]:
    """Return boxes around the slices of a mesh between planes of constant z, from the tip back."""
    levels = np.linspace(vertices[:, 2].max(), vertices[:, 2].min(), SLABS + 1)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    start, end = vertices[edges[:, 0]], vertices[edges[:, 1]]
    rims = [_crossings(start, end, level) for level in levels]
    slabs = []
    for i, (top, bottom) in enumerate(pairwise(levels)):
        inside = vertices[(vertices[:, 2] <= top) & (vertices[:, 2] >= bottom)]
        points = np.concatenate([inside, rims[i], rims[i + 1]])
        if len(points):
            slabs.append(_Slab(points.min(axis=0), points.max(axis=0)))
    return slabs


def _crossings(start: Floats, end: Floats, level: float) -> Floats:
    """Return (c, 3) where edges from `start` to `end` (e, 3) pass through the plane z = `level`."""
    crossing = (start[:, 2] - level) * (end[:, 2] - level) < 0
    a, b = start[crossing], end[crossing]
    share = (level - a[:, 2]) / (b[:, 2] - a[:, 2])
    points: Floats = a + share[:, None] * (b - a)
    points[:, 2] = level
    return points


def _pad(slabs: Sequence[_Slab]) -> _Slab:
    """Return the box around the slabs nearest to the tip that are innermost in the finger's front half."""
    front = slabs[: max(1, len(slabs) // 2)]
    inner = min(slab.low[1] for slab in front)
    start = next(i for i, slab in enumerate(front) if slab.low[1] <= inner + PAD_DEPTH)
    # What lies before the pad (a bevelled tip) belongs to its box.
    pad = slabs[0]
    for i, slab in enumerate(slabs[1:], start=1):
        if i > start and slab.low[1] > inner + PAD_DEPTH:
            break
        pad = pad.joined(slab)
    return pad


def _joined(slabs: Sequence[_Slab]) -> list[_Slab]:
    """Join neighbouring slabs while they fill `FILLED` of the box around them."""
    made: list[_Slab] = []
    volume = 0.0
    for slab in slabs:
        whole = made[-1].joined(slab) if made else slab
        if made and volume + slab.volume >= FILLED * whole.volume:
            made[-1], volume = whole, volume + slab.volume
        else:
            made.append(slab)
            volume = slab.volume
    return made

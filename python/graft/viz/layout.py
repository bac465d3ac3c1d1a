"""Where everything stands in a scene: each transfer in a cell of a grid, the source left of the target.

The world is right-handed, z up; the viewer looks along y. Every object is turned so that its contact is seen
from there, scaled to a diagonal of 1 and put on the ground.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from graft.errors import MissingExtraError
from graft.grasp.metric import contact_in_metres, in_metres
from graft.objects import Contact, Floats, PartObject
from graft.viz.camera import contact_view, look_from
from graft.viz.colors import Colors, part_colors
from graft.viz.grippers import BEST, gripper_shapes, require_grasps, stick_shapes
from graft.viz.shapes import Shape, diagonal, frame_along, object_shapes
from graft.viz.transfers import colors_of

if TYPE_CHECKING:
    from graft.contact.transfer import TransferredContact
    from graft.grasp.grasps import GraspSet

OBJECT_FACES = 50_000
"""No object is shown with more triangles: a browser draws that many smoothly, and more look no better."""

SCENE_FACES = 240_000
"""Triangles of a whole scene: about 4 MB of page."""

MIN_PART_FACES = 60
"""A part is not thinned below this."""

PAIR_GAP = 1.2
"""Distance between the middles of a source and its target."""

CELL = (2.75, 2.5)
"""Width and depth of a transfer's cell."""

SCENE_ASPECT = 0.8
"""Width to depth of the grid: seen from above at 33 degrees, it fills a window of 3 to 2."""

CAPTION_DISTANCE = 0.62
"""How far before the middle of its cell a caption lies."""

LINK_SHARE = 0.2
"""Parts are linked when this share of either part's mass goes from one to the other."""


@dataclass(frozen=True, eq=False)
class Placed:
    """An object in the scene.

    Attributes:
        name: Unique in the scene, with slashes between levels.
        title: For people.
        shapes: Its parts, object frame, in diagonals of the object, thinned to the scene's budget.
        pose: (4, 4) T_world_object, rigid.
        height: Of its top above the ground.
        contact: On it, object frame, in the same unit; None when there is none.
        centers: (n, 3) middles of its parts, world.
    """

    name: str
    title: str
    shapes: list[Shape]
    pose: Floats
    height: float
    contact: Contact | None
    centers: Floats

    def contact_pose(self, contact: Contact) -> Floats:
        """Return T_world_contact (4, 4), a rigid motion: z along the outward normal."""
        pose = np.eye(4)
        rotation = self.pose[:3, :3]
        pose[:3, :3] = rotation @ frame_along(contact.normal)
        pose[:3, 3] = rotation @ contact.point + self.pose[:3, 3]
        return pose


@dataclass(frozen=True, eq=False)
class Link:
    """A line between matched parts.

    Attributes:
        start: (3,) world.
        end: (3,) world.
        strength: In (0, 1], the share of mass that it stands for.
        color: Of the source part.
    """

    start: Floats
    end: Floats
    strength: float
    color: tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class Cell:
    """One transfer in the scene.

    Attributes:
        name: Unique in the scene.
        caption: For people, one line.
        front: (3,) where the caption lies, on the ground, world.
        source: The demonstrated object.
        target: The other one.
        links: Between their parts.
    """

    name: str
    caption: str
    front: Floats
    source: Placed
    target: Placed
    links: list[Link]


def lay_out(transfers: Sequence[TransferredContact]) -> list[Cell]:
    """Give every transfer a cell, row by row from the back.

    Raises:
        MissingExtraError: The meshes have to be thinned, and fast-simplification is not installed.
    """
    columns = max(1, round(float(np.sqrt(SCENE_ASPECT * len(transfers) * CELL[1] / CELL[0]))))
    rows = -(-len(transfers) // columns)
    budget = min(OBJECT_FACES, SCENE_FACES // (2 * len(transfers)))
    cells = []
    for place, transfer in enumerate(transfers):
        row, column = divmod(place, columns)
        middle = np.array([(column - (columns - 1) / 2) * CELL[0], ((rows - 1) / 2 - row) * CELL[1], 0.0])
        cells.append(_cell(transfer, f"{place:02d}", middle, budget))
    return cells


def _cell(transfer: TransferredContact, number: str, middle: Floats, budget: int) -> Cell:
    match = transfer.match
    aside = np.array([PAIR_GAP / 2, 0.0, 0.0])
    name = f"{number}_{match.target.object.name}".replace("/", "_")
    source_colors, target_colors = colors_of(transfer)
    source = place_object(
        match.source.object,
        source_colors,
        middle - aside,
        contact=match.demonstration.contact,
        name=f"{name}/source",
        title=match.demonstration.name,
        budget=budget,
    )
    target = place_object(
        match.target.object,
        target_colors,
        middle + aside,
        contact=transfer.contact,
        name=f"{name}/target",
        title=match.target.object.name,
        budget=budget,
    )
    parts = (
        match.source.object.part_names[transfer.source_part],
        match.target.object.part_names[transfer.target_part],
    )
    caption = f"{parts[0]} to {parts[1]}, cost {match.cost:.3f}, confidence {transfer.confidence:.2f}"
    front = middle - np.array([0.0, CAPTION_DISTANCE, 0.0])
    return Cell(name, caption, front, source, target, _links(match.transport.plan, source, target))


def place_object(
    obj: PartObject,
    colors: Colors,
    middle: Floats,
    *,
    contact: Contact | None,
    name: str,
    title: str,
    budget: int = OBJECT_FACES,
) -> Placed:
    """Turn an object's contact to the viewer, scale its diagonal to 1, put it on the ground at `middle`."""
    azimuth = 30.0 if contact is None else contact_view(obj, contact)[0]
    right, down, forward = look_from(azimuth, 0.0, obj.up)
    scale = 1.0 / diagonal(obj)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, forward, -down])
    turned = scale * np.concatenate([part.vertices for part in obj.parts]) @ pose[:3, :3].T
    low, high = turned.min(axis=0), turned.max(axis=0)
    pose[:3, 3] = middle - np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
    middles = [(part.vertices.min(axis=0) + part.vertices.max(axis=0)) / 2 for part in obj.parts]
    return Placed(
        name=name,
        title=title,
        shapes=thinned([s.scaled(scale) for s in object_shapes(obj, colors)], budget),
        pose=pose,
        height=float(high[2] - low[2]),
        contact=None if contact is None else replace(contact, point=scale * contact.point),
        centers=scale * np.array(middles) @ pose[:3, :3].T + pose[:3, 3],
    )


def place_alone(obj: PartObject) -> Placed:
    """Place one object without a contact at the origin."""
    colors = part_colors(len(obj.parts))
    return place_object(obj, colors, np.zeros(3), contact=None, name="object", title=obj.name)


def place_grasps(obj: PartObject, grasps: GraspSet, contact: Contact | None) -> tuple[Placed, list[Shape]]:
    """Place an object at the origin, with grasps in its frame and unit: the first as boxes, the others as sticks.

    Raises:
        InputError: There is no grasp, or the object has no size in metres.
    """
    require_grasps(grasps)
    metric = in_metres(obj)
    size = diagonal(metric)
    on_it = None if contact is None else contact_in_metres(contact, obj)
    colors = part_colors(len(obj.parts), None if contact is None else contact.part)
    placed = place_object(metric, colors, np.zeros(3), contact=on_it, name="object", title=obj.name)
    boxes = [replace(shape, name=BEST + shape.name) for shape in gripper_shapes(grasps[0])]
    # The best grasp's stick would lie inside its boxes.
    return placed, [shape.scaled(1.0 / size) for shape in boxes + stick_shapes(grasps, size)[1:]]


def _links(plan: Floats, source: Placed, target: Placed) -> list[Link]:
    """Return the lines between matched parts, the strongest first in the order of the plan."""
    rows, columns = plan.sum(axis=1, keepdims=True), plan.sum(axis=0, keepdims=True)
    tiny = np.finfo(np.float64).tiny
    strength = np.maximum(plan / np.maximum(rows, tiny), plan / np.maximum(columns, tiny))
    return [
        Link(source.centers[i], target.centers[j], float(strength[i, j]), source.shapes[i].color)
        for i, j in np.argwhere((strength >= LINK_SHARE) & (plan > 0))
    ]


def thinned(shapes: list[Shape], budget: int) -> list[Shape]:
    """Reduce shapes to `budget` triangles in all, and clouds to as many points.

    Raises:
        MissingExtraError: It has to be done, and fast-simplification is not installed.
    """
    faces = sum(len(s.faces) for s in shapes)
    points = sum(len(s.vertices) for s in shapes if not len(s.faces))
    if faces > budget:
        share = budget / faces
        shapes = [_decimated(s, max(MIN_PART_FACES, int(share * len(s.faces)))) for s in shapes]
    if points > budget:
        step = -(-points // budget)
        shapes = [s if len(s.faces) else replace(s, vertices=s.vertices[::step]) for s in shapes]
    return shapes


def _decimated(shape: Shape, wanted: int) -> Shape:
    """Return a mesh of about `wanted` triangles (quadric error, Garland and Heckbert 1997)."""
    if len(shape.faces) <= wanted:
        return shape
    try:
        import fast_simplification
    except ImportError:
        raise MissingExtraError("thinning meshes", package="fast-simplification", extra="viz") from None
    # Copies, because it refuses read-only arrays.
    vertices, faces = fast_simplification.simplify(
        shape.vertices.copy(), shape.faces.copy(), target_reduction=1.0 - wanted / len(shape.faces)
    )
    if not len(faces):
        return shape
    return replace(shape, vertices=np.asarray(vertices, np.float64), faces=np.asarray(faces, np.int64))

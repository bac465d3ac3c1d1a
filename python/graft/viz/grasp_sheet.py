"""`save_grasp_sheet`: grasps on an object, all as sticks and the best ones as grippers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from graft import _core
from graft.checks import Floats
from graft.grasp.grasps import Grasp, GraspSet
from graft.grasp.metric import contact_in_metres, in_metres
from graft.io.atomic import write_whole
from graft.objects import Contact, PartObject
from graft.viz.camera import AZIMUTHS, ELEVATIONS, LEVEL, contact_view, fit, look_from
from graft.viz.colors import part_colors
from graft.viz.files import check_output
from graft.viz.grippers import gripper_shapes, require_grasps, stick_shapes
from graft.viz.picture import Pixels, draw_shapes, encode_png, require_pillow
from graft.viz.shapes import Shape, contact_shapes, diagonal, object_shapes
from graft.viz.tile import BODY, FAINT, SMALL, TITLE, blank, paste, write

SHOWN = 5
"""Most grasps that get a picture of their own: with the overview two rows of three."""

SIZE, COLUMNS, EDGE = 400, 3, 14
"""Side of a picture, pictures in a row, empty pixels around everything."""

ACROSS_WEIGHT, BEHIND_WEIGHT, LEVEL_WEIGHT, SEEN_WEIGHT = 1.0, 0.5, 0.3, 1.5
"""What a view gains by looking across the closing plane, loses by looking over the palm's back, gains by a usual
height and by seeing both pads."""


def save_grasp_sheet(path: str | Path, obj: PartObject, grasps: GraspSet, contact: Contact | None = None) -> None:
    """Write a PNG: the object with all grasps as sticks (green is best), then the first five with the gripper's boxes.

    The part that has the contact is amber. Every gripper is drawn closed on the object, from where its pads are seen.

    Args:
        path: Ends in .png.
        obj: The object, in its own unit.
        grasps: In metres, best first.
        contact: Where the object was to be taken, object units; a red ball with its normal.

    Raises:
        InputError: There is no grasp, the object has no size in metres, or the file cannot be written.
        MissingExtraError: pillow is not installed.
    """
    path = check_output(path, ".png")
    require_grasps(grasps)
    require_pillow()
    metric = in_metres(obj)
    size = diagonal(metric)
    base = object_shapes(metric, part_colors(len(obj.parts), None if contact is None else contact.part))
    overlook = look_from(30.0, 22.0, metric.up)
    if contact is not None:
        on_it = contact_in_metres(contact, obj)
        base += contact_shapes(on_it, size)
        overlook = look_from(*contact_view(metric, on_it)[:2], metric.up)
    tiles: list[tuple[Pixels, str, str]] = []
    overview = base + stick_shapes(grasps, size)
    tiles.append((_drawn(overview, overlook), _count(len(grasps)), "green is best"))
    for i, grasp in enumerate(grasps[:SHOWN]):
        pixels = _drawn(base + gripper_shapes(grasp), _view(metric, grasp))
        numbers = f"width {1000 * grasp.width:.0f} mm"
        if contact is not None:
            numbers += f", {1000 * grasp.distance:.0f} mm from the contact"
        tiles.append((pixels, f"{i + 1}: score {grasp.score:.3f}", numbers))
    columns = min(COLUMNS, len(tiles))
    rows = -(-len(tiles) // columns)
    top, height = 2 * EDGE + TITLE, SIZE + BODY + SMALL + 18
    image = blank(columns * (SIZE + EDGE) + EDGE, top + rows * (height + EDGE))
    title = f"{obj.name}, grasped by {grasps.gripper.name}"
    write(image, EDGE, EDGE, title, size=TITLE, width=image.width - 2 * EDGE)
    for place, (pixels, first, second) in enumerate(tiles):
        x, y = EDGE + place % columns * (SIZE + EDGE), top + place // columns * (height + EDGE)
        paste(image, pixels, x, y)
        write(image, x, y + SIZE + 4, first, width=SIZE)
        write(image, x, y + SIZE + BODY + 10, second, size=SMALL, width=SIZE, color=FAINT)
    write_whole(path, encode_png(image))


def _count(n: int) -> str:
    return "1 grasp" if n == 1 else f"{n} grasps"


def _drawn(shapes: list[Shape], rotation: Floats) -> Pixels:
    camera = fit(rotation, np.concatenate([s.vertices for s in shapes]), SIZE, SIZE)
    return draw_shapes(shapes, camera, SIZE, SIZE)


def _view(obj: PartObject, grasp: Grasp) -> Floats:
    """Return the rotation (3, 3) of the camera that shows best how a gripper closes on the object."""
    views = [(float(a), e) for e in ELEVATIONS for a in AZIMUTHS]
    rotations = np.array([look_from(a, e, obj.up) for a, e in views])
    toward = -rotations[:, 2]
    score = ACROSS_WEIGHT * np.abs(toward @ grasp.pose[:3, 0])
    score -= BEHIND_WEIGHT * np.maximum(-toward @ grasp.pose[:3, 2], 0.0)
    score -= LEVEL_WEIGHT * np.array([abs(e - LEVEL) / 45.0 for _, e in views])
    score += SEEN_WEIGHT * _seen(obj, grasp, toward)
    # Rounded, so that the last bit of a sum does not choose between views that are equally good.
    return np.asarray(rotations[int(np.argmax(np.round(score, 9)))])


def _seen(obj: PartObject, grasp: Grasp, toward: Floats) -> Floats:
    """Return (v,) the share of the pads' corners that the object does not hide from each direction (v, 3)."""
    solid = [part for part in obj.parts if not part.is_point_cloud]
    if not solid:
        return np.ones(len(toward))
    corners = np.concatenate([s.vertices for s in gripper_shapes(grasp) if s.name.endswith("_pad")])
    offsets = np.cumsum([0, *(len(part.vertices) for part in solid[:-1])])
    faces = np.concatenate([part.faces + o for part, o in zip(solid, offsets, strict=True)])
    origins = np.broadcast_to(corners, (len(toward), *corners.shape)).reshape(-1, 3)
    directions = np.repeat(toward, len(corners), axis=0)
    free = np.isinf(
        _core.cast_rays(
            np.concatenate([part.vertices for part in solid]),
            np.ascontiguousarray(faces),
            np.ascontiguousarray(origins),
            np.ascontiguousarray(directions),
        )
    )
    shares: Floats = free.reshape(len(toward), -1).mean(axis=1)
    return shares

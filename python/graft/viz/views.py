"""`save_views`: one object from four directions, its parts in colours."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from graft.io.atomic import write_whole
from graft.objects import PartObject
from graft.viz.camera import STANDARD_VIEWS, fit, framed, look_from
from graft.viz.colors import part_colors
from graft.viz.files import check_output
from graft.viz.picture import draw_shapes, encode_png, require_pillow
from graft.viz.shapes import object_shapes, rgb
from graft.viz.tile import BODY, FAINT, SMALL, TITLE, blank, legend_rows, paste, write, write_legend

VIEW_SIZE = 440
"""Side of one view in pixels."""

EDGE = 14
"""Empty pixels around everything."""


def save_views(path: str | Path, obj: PartObject) -> None:
    """Write a PNG of an object from three sides and the top, with a legend of its parts.

    All views have one scale; graspable parts are marked in the legend.

    Args:
        path: Ends in .png.
        obj: The object.

    Raises:
        InputError: The file cannot be written.
        MissingExtraError: pillow is not installed.
    """
    path = check_output(path, ".png")
    require_pillow()
    colors = part_colors(len(obj.parts))
    shapes = object_shapes(obj, colors)
    points = np.concatenate([s.vertices for s in shapes])
    rotations = [look_from(azimuth, elevation, obj.up) for azimuth, elevation in STANDARD_VIEWS]
    cameras = [fit(rotation, points, VIEW_SIZE, VIEW_SIZE) for rotation in rotations]
    scale = min(float(np.linalg.norm(camera[0, :3])) for camera in cameras)

    width = 2 * VIEW_SIZE + 2 * EDGE
    entries = [
        (f"{part.name} (graspable)" if i in obj.graspable else part.name, rgb(colors[i]))
        for i, part in enumerate(obj.parts)
    ]
    rows = legend_rows(entries, width - 2 * EDGE)
    top = EDGE + TITLE + BODY + 16
    image = blank(width, top + 2 * VIEW_SIZE + len(rows) * (SMALL + 6) + EDGE)
    write(image, EDGE, EDGE, obj.name, size=TITLE, width=width - 2 * EDGE)
    write(image, EDGE, EDGE + TITLE + 6, describe(obj), width=width - 2 * EDGE, color=FAINT)
    for place, rotation in enumerate(rotations):
        seen = points @ rotation.T
        middle = (seen.min(axis=0) + seen.max(axis=0)) / 2
        camera = framed(rotation, middle, scale, VIEW_SIZE, VIEW_SIZE)
        x, y = EDGE + place % 2 * VIEW_SIZE, top + place // 2 * VIEW_SIZE
        paste(image, draw_shapes(shapes, camera, VIEW_SIZE, VIEW_SIZE), x, y)
    write_legend(image, EDGE, top + 2 * VIEW_SIZE, rows, width - 2 * EDGE)
    write_whole(path, encode_png(image))


def describe(obj: PartObject) -> str:
    """Return one line: category, size, how much there is of it."""
    extents = np.ptp(obj.bounds, axis=0)
    if obj.scale_to_metres is None:
        size = " x ".join(f"{x:.3g}" for x in extents) + " (scale unknown)"
    else:
        size = " x ".join(f"{100 * x * obj.scale_to_metres:.3g}" for x in extents) + " cm"
    points = sum(len(part.vertices) for part in obj.parts if part.is_point_cloud)
    amount = [f"{obj.n_faces} faces"] * (obj.n_faces > 0) + [f"{points} points"] * (points > 0)
    return ", ".join([obj.category or "no category", size, f"{len(obj.parts)} parts", *amount])

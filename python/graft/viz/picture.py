"""From shapes to pixels, and from pixels to PNG files. Pictures are (height, width, 3) sRGB on white."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graft import _core
from graft.errors import MissingExtraError
from graft.objects import Contact, Floats, PartObject
from graft.viz.camera import contact_view, fit, look_from
from graft.viz.colors import CONTACT, Colors
from graft.viz.shapes import Shape, contact_shapes, diagonal, object_shapes

if TYPE_CHECKING:
    from PIL import Image, ImageFont

Pixels = NDArray[np.uint8]

HIDDEN_BELOW = 0.15
"""A contact of whose ball less than this share is seen gets a ring drawn over the picture."""


def draw_shapes(shapes: Sequence[Shape], camera: Floats, width: int, height: int) -> Pixels:
    """Draw shapes through a camera (3, 4) on white; (height, width, 3)."""
    meshes = [(i, s) for i, s in enumerate(shapes) if len(s.faces)]
    clouds = [(i, s) for i, s in enumerate(shapes) if not len(s.faces)]
    offsets = np.cumsum([0, *(len(s.vertices) for _, s in meshes)])
    no_points, no_groups = np.empty((0, 3)), np.empty(0, np.int64)
    pixels = _core.render_scene(
        vertices=np.concatenate([no_points, *(s.vertices for _, s in meshes)]),
        faces=np.concatenate(
            [
                np.empty((0, 3), np.int64),
                *(s.faces + o for (_, s), o in zip(meshes, offsets[:-1], strict=True)),
            ]
        ),
        face_groups=np.concatenate([no_groups, *(np.full(len(s.faces), i) for i, s in meshes)]),
        centers=np.concatenate([no_points, *(s.vertices for _, s in clouds)]),
        radii=np.concatenate([np.empty(0), *(np.full(len(s.vertices), s.radius) for _, s in clouds)]),
        center_groups=np.concatenate([no_groups, *(np.full(len(s.vertices), i) for i, s in clouds)]),
        colors=np.array([s.color for s in shapes], np.uint8),
        camera=np.ascontiguousarray(camera),
        width=width,
        height=height,
    )
    alpha = pixels[..., 3:].astype(np.uint16)
    white = pixels[..., :3] * alpha + 255 * (255 - alpha) + 127
    return (white // 255).astype(np.uint8)


def draw_contact(obj: PartObject, colors: Colors, contact: Contact, size: int) -> tuple[Pixels, bool]:
    """Draw an object and a contact on it from where the contact is seen.

    Returns:
        (size, size, 3), and whether the contact is seen; when no view shows it, a ring marks its place.
    """
    azimuth, elevation, visible = contact_view(obj, contact)
    shapes = object_shapes(obj, colors) + contact_shapes(contact, diagonal(obj))
    camera = fit(look_from(azimuth, elevation, obj.up), _points(shapes), size, size)
    pixels = draw_shapes(shapes, camera, size, size)
    if visible >= HIDDEN_BELOW:
        return pixels, True
    column, row = project(camera, contact.point)
    rows, columns = np.mgrid[:size, :size] + 0.5
    away = np.hypot(columns - column, rows - row)
    pixels[np.abs(away - 0.04 * size) < 0.006 * size] = CONTACT
    return pixels, False


def project(camera: Floats, point: Floats) -> tuple[float, float]:
    """Return column and row, in pixels, where a camera (3, 4) sees a point (3,)."""
    column, row, _ = camera[:, :3] @ point + camera[:, 3]
    return float(column), float(row)


def _points(shapes: Sequence[Shape]) -> Floats:
    """Return (p, 3) what the frame of a picture has to hold."""
    return np.concatenate([s.vertices for s in shapes])


def require_pillow() -> None:
    """Raise `MissingExtraError` when pictures cannot be written."""
    try:
        import PIL  # noqa: F401
    except ImportError:
        raise MissingExtraError("writing pictures", package="pillow", extra="viz") from None


def encode_png(image: Image.Image) -> bytes:
    """Return the bytes of a PNG file."""
    buffer = io.BytesIO()
    image.save(buffer, "PNG")
    return buffer.getvalue()


def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return the font that Pillow brings along, so that pictures are the same everywhere."""
    from PIL import ImageFont

    return ImageFont.load_default(size)

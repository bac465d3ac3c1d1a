"""`save_thumbnails`: demonstrated objects side by side, each with its contact."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from graft.errors import InputError
from graft.io.atomic import write_whole
from graft.objects import Demonstration
from graft.viz.colors import part_colors
from graft.viz.files import check_output
from graft.viz.picture import draw_contact, encode_png, require_pillow
from graft.viz.tile import SMALL, blank, paste, write

SIDE = 180
"""Pixels of a picture."""

COLUMNS = 8
"""Pictures in a row."""

LINE = 22
"""Pixels of the line of text below."""


def save_thumbnails(path: str | Path, demonstrations: Sequence[Demonstration]) -> None:
    """Draw demonstrations as one PNG, in order, row by row: the taken part amber, the contact red.

    Raises:
        InputError: There is none, or the path does not end in .png.
        MissingExtraError: Pillow is not installed.
    """
    path = check_output(path, ".png")
    require_pillow()
    if not demonstrations:
        raise InputError("thumbnails: expected at least one demonstration, got none")
    columns = min(COLUMNS, len(demonstrations))
    rows = -(-len(demonstrations) // columns)
    image = blank(columns * SIDE, rows * (SIDE + LINE))
    for number, shown in enumerate(demonstrations):
        x, y = number % columns * SIDE, number // columns * (SIDE + LINE)
        colors = part_colors(len(shown.object.parts), shown.contact.part)
        pixels, _ = draw_contact(shown.object, colors, shown.contact, SIDE)
        paste(image, pixels, x, y)
        write(image, x + 4, y + SIDE + 2, shown.name, size=SMALL, width=SIDE - 8)
    write_whole(path, encode_png(image))

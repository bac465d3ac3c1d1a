"""`save_sheet`: transfers side by side, to judge by eye whether the contact is in the right place."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from graft.io.atomic import write_whole
from graft.viz.colors import BAD, GOOD, UNKNOWN, Colors
from graft.viz.files import check_output
from graft.viz.picture import draw_contact, encode_png, require_pillow
from graft.viz.shapes import rgb
from graft.viz.tile import (
    BODY,
    FAINT,
    SMALL,
    TITLE,
    Entry,
    blank,
    drawing,
    legend_rows,
    paste,
    text_width,
    write,
    write_arrow,
    write_legend,
)
from graft.viz.transfers import as_sequence, colors_of, in_mask

if TYPE_CHECKING:
    from PIL import Image

    from graft.contact.transfer import TransferredContact
    from graft.objects import PartObject

PICTURE_SIZES = {1: 520, 2: 420, 4: 420}
"""Up to so many transfers -> side of a picture in pixels."""

PICTURE_SIZE = 330
"""Side of a picture when there are more."""

COLUMNS = 3
"""Tiles in a row of a large sheet."""

EDGE = 12
"""Empty pixels around a tile's contents."""

FRAME = 4
"""Width of a tile's frame in pixels."""

KEY = "amber: demonstrated part and what matches it   red: contact and normal   *: graspable"
"""What the colours mean, below the tiles."""

Legend = list[list[Entry]]
"""Rows of entries."""

LEGEND_ROWS = 3
"""Most rows of a legend that a tile has room for."""


def save_sheet(path: str | Path, transfers: TransferredContact | Sequence[TransferredContact]) -> None:
    """Write a contact sheet as PNG: for each transfer the source and the target, side by side.

    The demonstrated part is amber, other parts have other colours, and every target part has the colour of
    the source part that sends it the most mass (grey: none does). Contacts are red balls with an arrow along
    the normal, seen from where they are visible. The frame is green when the contact lies in the target's
    graspable mask, red when it does not, grey when there is no mask.

    Args:
        path: Ends in .png.
        transfers: One or several.

    Raises:
        InputError: No transfer, or the file cannot be written.
        MissingExtraError: pillow is not installed.
    """
    path = check_output(path, ".png")
    several = as_sequence(transfers)
    require_pillow()
    size = next((s for n, s in PICTURE_SIZES.items() if len(several) <= n), PICTURE_SIZE)
    columns = 1 if len(several) == 1 else 2 if len(several) <= 4 else COLUMNS
    legends = [
        [_legend(graph.object, colors, size) for graph, colors in zip((m.source, m.target), c, strict=True)]
        for m, c in ((t.match, colors_of(t)) for t in several)
    ]
    lines = max(len(rows) for pair in legends for rows in pair)
    tiles = [_tile(t, size, pair, lines) for t, pair in zip(several, legends, strict=True)]
    rows = -(-len(tiles) // columns)
    width, height = tiles[0].size
    image = blank(columns * (width + EDGE) + EDGE, rows * (height + EDGE) + 2 * EDGE + SMALL)
    for place, tile in enumerate(tiles):
        image.paste(tile, (EDGE + place % columns * (width + EDGE), EDGE + place // columns * (height + EDGE)))
    room = image.width - 2 * EDGE
    write(image, EDGE, image.height - EDGE - SMALL, KEY, size=SMALL, width=room, color=FAINT)
    write_whole(path, encode_png(image))


def _tile(transfer: TransferredContact, size: int, legends: list[Legend], lines: int) -> Image.Image:
    """Draw one transfer: caption, two pictures, two legends, a frame."""
    match = transfer.match
    source, target = match.source.object, match.target.object
    inside = in_mask(transfer)
    color = {True: GOOD, False: BAD, None: UNKNOWN}[inside]
    top = EDGE + TITLE + BODY + 14
    width = 2 * size + 3 * EDGE
    image = blank(width, top + size + lines * (SMALL + 6) + EDGE)
    room = width - 2 * EDGE
    write_arrow(image, EDGE, EDGE - 2, match.demonstration.name, target.name, size=TITLE, width=room)
    verdict = {True: "in the mask", False: "outside the mask", None: "no mask"}[inside]
    parts = f"{source.part_names[transfer.source_part]} to {target.part_names[transfer.target_part]}"
    numbers = f"cost {match.cost:.3f}   confidence {transfer.confidence:.2f}   "
    write(image, EDGE, EDGE + TITLE + 5, f"{parts}   {numbers}", width=room - 120, color=FAINT)
    write(image, width - EDGE - text_width(verdict, BODY), EDGE + TITLE + 5, verdict, width=120, color=color)

    sides = zip((source, target), colors_of(transfer), (match.demonstration.contact, transfer.contact), strict=True)
    for side, (obj, colors, contact) in enumerate(sides):
        x = EDGE + side * (size + EDGE)
        pixels, seen = draw_contact(obj, colors, contact, size)
        paste(image, pixels, x, top)
        if not seen:
            write(image, x, top, "contact hidden", size=SMALL, width=size, color=FAINT)
        write_legend(image, x, top + size, legends[side], size)
    with drawing(image) as draw:
        middle = 2 * EDGE + size - EDGE // 2
        draw.line([(middle, top), (middle, image.height - EDGE)], fill=(228, 230, 234))
        draw.rectangle((0, 0, width - 1, image.height - 1), outline=color, width=FRAME)
    return image


def _legend(obj: PartObject, colors: Colors, width: int) -> Legend:
    """Return the rows of a legend, as many as there is room for; graspable parts have a star."""
    entries = [(f"{name}*" if i in obj.graspable else name, rgb(colors[i])) for i, name in enumerate(obj.part_names)]
    rows = legend_rows(entries, width)
    if len(rows) > LEGEND_ROWS:
        shown = sum(len(row) for row in rows[:LEGEND_ROWS]) - 1
        rows = legend_rows(entries[:shown], width)
        rows[-1].append((f"and {len(entries) - shown} more", (255, 255, 255)))
    return rows

"""Text, legends and frames around pictures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from graft.viz.colors import INK
from graft.viz.picture import Pixels, font

if TYPE_CHECKING:
    from PIL import Image, ImageDraw

FAINT = (112, 118, 128)
"""Text of second rank."""

TITLE, BODY, SMALL = 19, 15, 13
"""Heights of text in pixels."""

SWATCH = 11
"""Side of a legend's coloured squares in pixels."""

Entry = tuple[str, tuple[int, int, int]]
"""A legend's text and its colour."""


def blank(width: int, height: int) -> Image.Image:
    """Return a white image."""
    from PIL import Image

    return Image.new("RGB", (width, height), (255, 255, 255))


def paste(image: Image.Image, pixels: Pixels, x: int, y: int) -> None:
    """Put a picture's top left corner at (x, y)."""
    from PIL import Image

    image.paste(Image.fromarray(pixels), (x, y))


@contextmanager
def drawing(image: Image.Image) -> Iterator[ImageDraw.ImageDraw]:
    """Draw on an image."""
    from PIL import ImageDraw

    yield ImageDraw.Draw(image)


def text_width(text: str, size: int) -> int:
    """Return how many pixels wide a line of text is."""
    return int(font(size).getlength(text) + 0.999)


def shortened(text: str, size: int, width: int) -> str:
    """Return `text`, its middle left out when it is wider than `width` pixels."""
    if text_width(text, size) <= width:
        return text
    for keep in range(len(text) - 1, 1, -1):
        candidate = f"{text[: (keep + 1) // 2]}...{text[len(text) - keep // 2 :]}"
        if text_width(candidate, size) <= width:
            return candidate
    return "..."


def write(
    image: Image.Image, x: int, y: int, text: str, *, size: int = BODY, width: int, color: Sequence[int] = INK
) -> None:
    """Write one line whose top left corner is (x, y), shortened to `width` pixels."""
    with drawing(image) as draw:
        draw.text((x, y), shortened(text, size, width), fill=tuple(color), font=font(size))


def write_arrow(image: Image.Image, x: int, y: int, first: str, second: str, *, size: int, width: int) -> None:
    """Write `first`, an arrow and `second`; the font has no arrow, so it is drawn."""
    gap = 2 * size
    half = (width - gap) // 2
    first, second = shortened(first, size, half), shortened(second, size, half)
    write(image, x, y, first, size=size, width=half)
    left = x + text_width(first, size) + size // 3
    right, middle, head = left + gap - 2 * (size // 3), y + round(0.62 * size), size // 4
    with drawing(image) as draw:
        draw.line([(left, middle), (right, middle)], fill=INK, width=max(1, size // 9))
        draw.line(
            [(right - head, middle - head), (right, middle), (right - head, middle + head)],
            fill=INK,
            width=max(1, size // 9),
        )
    write(image, right + size // 3, y, second, size=size, width=half)


def legend_rows(entries: Sequence[Entry], width: int) -> list[list[Entry]]:
    """Break a legend into rows no wider than `width` pixels."""
    rows: list[list[Entry]] = [[]]
    used = 0
    for entry in entries:
        needed = _entry_width(entry, width)
        if rows[-1] and used + needed > width:
            rows.append([])
            used = 0
        rows[-1].append(entry)
        used += needed
    return rows


def _entry_width(entry: Entry, width: int) -> int:
    return SWATCH + 5 + min(text_width(entry[0], SMALL), width - SWATCH - 5) + 12


def write_legend(image: Image.Image, x: int, y: int, rows: Sequence[Sequence[Entry]], width: int) -> None:
    """Write rows of a legend, `SMALL + 6` pixels each, from (x, y) down."""
    with drawing(image) as draw:
        for row in rows:
            left = x
            for entry in row:
                text, color = entry
                draw.rectangle((left, y + 2, left + SWATCH, y + 2 + SWATCH), fill=color, outline=INK)
                room = width - SWATCH - 5
                draw.text((left + SWATCH + 5, y), shortened(text, SMALL, room), fill=INK, font=font(SMALL))
                left += _entry_width(entry, width)
            y += SMALL + 6

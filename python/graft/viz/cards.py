"""`save_cards`: a page of captioned pictures that opens from a file, without a network."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from graft.io.atomic import write_whole
from graft.viz.files import check_output

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 92rem; padding: 0 1rem; color: #1a1a1a; }
pre { font: 13px/1.4 ui-monospace, monospace; overflow-x: auto; background: #f6f6f4; padding: .8rem; }
main { display: grid; grid-template-columns: repeat(auto-fill, minmax(30rem, 1fr)); gap: 1rem; }
figure { margin: 0; border: 1px solid #ddd; border-radius: 6px; overflow: hidden; }
img { width: 100%; display: block; }
figcaption { padding: .5rem .8rem; }
figcaption b { display: block; }
"""


@dataclass(frozen=True)
class Card:
    """A captioned picture.

    Attributes:
        title: In bold.
        text: Below it; one paragraph a line.
        picture: A PNG file's bytes; None where there is none.
    """

    title: str
    text: str
    picture: bytes | None


def save_cards(path: str | Path, title: str, text: str, cards: Sequence[Card]) -> None:
    """Write cards as one self-contained HTML page.

    Args:
        path: Ends in .html.
        title: Of the page.
        text: Above the cards, as it is, in letters of one width.
        cards: In order; none gives a page that says so by its text alone.

    Raises:
        InputError: The file cannot be written.
    """
    path = check_output(path, ".html")
    figures = "\n".join(_figure(card) for card in cards)
    write_whole(
        path,
        f"<!doctype html>\n<html lang=en><meta charset=utf-8><title>{escape(title)}</title><style>{STYLE}</style>\n"
        f"<h1>{escape(title)}</h1>\n<pre>{escape(text)}</pre>\n<main>\n{figures}\n</main></html>\n".encode(),
    )


def _figure(card: Card) -> str:
    picture = ""
    if card.picture is not None:
        data = base64.b64encode(card.picture).decode()
        picture = f'<img alt="{escape(card.title, quote=True)}" src="data:image/png;base64,{data}">'
    lines = "".join(f"{escape(line)}<br>" for line in card.text.splitlines())
    return f"<figure>{picture}<figcaption><b>{escape(card.title)}</b>{lines}</figcaption></figure>"

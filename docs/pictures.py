"""How the example gallery finds the pictures that an example writes."""

import shutil
from pathlib import Path
from typing import Any


def scrape(block: tuple[Any, ...], block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Copy the PNG that a block's variable `picture` names into the gallery, once."""
    from sphinx_gallery.scrapers import figure_rst

    written = block_vars["example_globals"].pop("picture", None)
    if not isinstance(written, Path) or not written.is_file():
        return ""
    copy = next(block_vars["image_path_iterator"])
    shutil.copy(written, copy)
    return figure_rst([copy], gallery_conf["src_dir"])


def _get_sg_image_scraper() -> Any:
    return scrape

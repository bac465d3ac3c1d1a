"""Sphinx configuration; `make docs` builds with warnings as errors."""

import sys
from pathlib import Path

from graft import __version__

sys.path.insert(0, str(Path(__file__).parent))  # pictures.py

project = "graft"
author = "The graft developers"
release = version = __version__
copyright = "2026, the graft developers"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "examples/*.ipynb", "examples/*.py", "examples/*.md5", "examples/*.json"]
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_default_options = {"members": True, "exclude-members": "__init__, __new__"}
napoleon_use_ivar = True
sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "examples",
    "filename_pattern": r"/\d\d_",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "abort_on_example_error": True,
    "image_scrapers": ("pictures",),
}
html_theme = "furo"
html_title = "graft"

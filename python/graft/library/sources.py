"""What a library is built from: folders of demonstrations and of labelled objects."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from graft.errors import InputError
from graft.io import load_demonstration, load_object
from graft.io.folder import DEMONSTRATION_FILE
from graft.marking import mark_contact
from graft.objects import Demonstration

OBJECT_FILE = "object.json"
"""In folders of labelled objects."""


def find_sources(folders: Iterable[str | Path]) -> list[Path]:
    """Return every folder at or below the given ones that holds a demonstration or a labelled object.

    In the order of their paths; hidden folders, and what lies below one that was found, are passed over.

    Raises:
        InputError: One of `folders` is no folder.
    """
    found: dict[Path, None] = {}
    for folder in folders:
        root = Path(folder)
        if not root.is_dir():
            raise InputError("expected a folder of demonstrations or labelled objects", path=root)
        own = []
        for where, below, files in os.walk(root.resolve()):
            if DEMONSTRATION_FILE in files or OBJECT_FILE in files:
                own.append(Path(where))
                below.clear()
            below[:] = [name for name in below if not name.startswith(".")]
        found |= dict.fromkeys(sorted(own))
    return list(found)


def read_source(folder: Path) -> list[Demonstration]:
    """Read a folder: its demonstration, or of a labelled object one for the middle of each graspable part.

    Raises:
        InputError: It cannot be read, or nothing is said to be graspable.
    """
    if (folder / DEMONSTRATION_FILE).is_file():
        return [load_demonstration(folder)]
    obj = load_object(folder)
    if not obj.graspable:
        raise InputError("expected graspable_parts, got none: there is no contact to learn from", path=folder)
    return [mark_contact(obj, part, name=f"{folder.name}:{obj.parts[part].name}") for part in obj.graspable]

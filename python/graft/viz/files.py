"""Checks of output files before anything is drawn."""

from __future__ import annotations

from pathlib import Path

from graft.errors import InputError


def check_output(path: str | Path, suffix: str) -> Path:
    """Refuse a path that cannot be written, before anything is drawn.

    Raises:
        InputError: Another suffix, a folder that does not exist, or a folder where the file should be.
    """
    path = Path(path)
    if path.suffix.lower() != suffix:
        raise InputError(f"expected a file name ending in {suffix}", path=path)
    if path.is_dir():
        raise InputError("expected a file to write, it is a folder", path=path)
    if not path.parent.is_dir():
        raise InputError(f"cannot be written, there is no folder {str(path.parent)!r}", path=path)
    return path

"""Output files that are whole or absent."""

from __future__ import annotations

import os
import secrets
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


def write_whole(path: Path, data: bytes) -> None:
    """Write `data` beside `path` and rename it into place, so that nobody ever sees half a file.

    Raises:
        InputError: The system refuses; the message says why.
    """
    # Not tempfile: its files are readable by their owner only, and the rename would keep that.
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with draft.open("xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", path=path) from error
    finally:
        draft.unlink(missing_ok=True)

"""Files that are whole or absent."""

from __future__ import annotations

import os
import secrets
from pathlib import Path

from graft.errors import InputError


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

"""The one place where mujoco is imported for physics, so that its absence is one clear line."""

from __future__ import annotations

import os
from types import ModuleType

from graft.errors import MissingExtraError


def load_mujoco() -> ModuleType:
    """Return the module mujoco.

    A GL backend is chosen before the import, because mujoco reads it only then: without a display the default, GLFW,
    cannot draw; EGL can. What the user has set stays.

    Raises:
        MissingExtraError: It is not installed.
    """
    if not os.environ.get("DISPLAY"):
        os.environ.setdefault("MUJOCO_GL", "egl")
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError("physics", package="mujoco", extra="sim") from None
    module: ModuleType = mujoco
    return module

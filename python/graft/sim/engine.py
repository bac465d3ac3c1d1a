"""The one place where mujoco is imported for physics, so that its absence is one clear line."""

from __future__ import annotations

import os
import sys
from ctypes.util import find_library
from types import ModuleType

from graft.errors import MissingExtraError


def load_mujoco() -> ModuleType:
    """Return the module mujoco.

    A GL backend is chosen before the import, because mujoco reads it only then: on Linux without a display the default,
    GLFW, cannot draw; EGL can, else OSMesa, where they are installed. What the user has set stays.

    Raises:
        MissingExtraError: It is not installed.
    """
    if sys.platform == "linux" and not os.environ.get("DISPLAY") and "MUJOCO_GL" not in os.environ:
        for backend, library in (("egl", "EGL"), ("osmesa", "OSMesa")):
            if find_library(library):
                os.environ["MUJOCO_GL"] = backend
                break
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError("physics", package="mujoco", extra="sim") from None
    module: ModuleType = mujoco
    return module

"""The one place where mujoco is imported for physics, so that its absence is one clear line."""

from __future__ import annotations

import os
import sys
from ctypes.util import find_library
from types import ModuleType

from graft.errors import MissingExtraError


def choose_gl() -> None:
    """Choose what mujoco draws with, unless the user has (MUJOCO_GL); it reads that once, when it is imported.

    On Linux without a display its default, GLFW, cannot draw; EGL can, else OSMesa, where they are installed.
    """
    if "mujoco" in sys.modules or has_display() or "MUJOCO_GL" in os.environ:
        return
    for backend, library in (("egl", "EGL"), ("osmesa", "OSMesa")):
        if find_library(library):
            os.environ["MUJOCO_GL"] = backend
            return


def has_display() -> bool:
    """Whether windows can be opened; elsewhere than on Linux, always."""
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def load_mujoco() -> ModuleType:
    """Return the module mujoco, imported after `choose_gl`.

    Raises:
        MissingExtraError: It is not installed.
    """
    choose_gl()
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError("physics", package="mujoco", extra="sim") from None
    module: ModuleType = mujoco
    return module

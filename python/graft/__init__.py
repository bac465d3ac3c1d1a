"""graft: a grasp on an object never seen, from one demonstration on another object.

    library = graft.load_library("demonstrations/")
    kettle = graft.load_object("kettle.glb")
    matches = library.retrieve(kettle, k=5)
    contact = graft.transfer_contact(matches[0])

Names are imported when they are first used, so that `import graft` costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graft.errors import GraftError, InputError, InputWarning, MissingExtraError
    from graft.objects import Contact, Demonstration, Joint, Part, PartObject
    from graft.viz import save_glb, save_object_scene, save_scene, save_sheet, save_views

_HOMES = {
    "Contact": "graft.objects",
    "Demonstration": "graft.objects",
    "GraftError": "graft.errors",
    "InputError": "graft.errors",
    "InputWarning": "graft.errors",
    "Joint": "graft.objects",
    "MissingExtraError": "graft.errors",
    "Part": "graft.objects",
    "PartObject": "graft.objects",
    "save_glb": "graft.viz",
    "save_object_scene": "graft.viz",
    "save_scene": "graft.viz",
    "save_sheet": "graft.viz",
    "save_views": "graft.viz",
}

__version__ = "0.1.0"
__all__ = [
    "Contact",
    "Demonstration",
    "GraftError",
    "InputError",
    "InputWarning",
    "Joint",
    "MissingExtraError",
    "Part",
    "PartObject",
    "save_glb",
    "save_object_scene",
    "save_scene",
    "save_sheet",
    "save_views",
]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'graft' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOMES])

"""graft: a grasp on an object never seen, from one demonstration on another object.

    library = graft.Library.open("demonstrations/")
    kettle = graft.load_object("kettle.glb")
    matches = library.retrieve(kettle, k=5)
    result = graft.transfer_contact(matches[0])

Names are imported when they are first used, so that `import graft` costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graft.contact import DenseMap, TransferredContact, agree, dense_map, transfer_contact
    from graft.errors import GraftError, InputError, InputWarning, MissingExtraError
    from graft.features import Descriptor, GeometricDescriptor
    from graft.graph import PartFlag, PartGraph, build_graph
    from graft.io import (
        as_object,
        load_demonstration,
        load_demonstrations,
        load_object,
        save_demonstration,
        save_object,
        segment,
        segment_hierarchy,
    )
    from graft.library import Library, Match, match
    from graft.marking import mark_contact
    from graft.objects import Contact, Demonstration, Joint, Part, PartObject
    from graft.transport import UFGW, Transport, ufgw, ufgw_batch
    from graft.viz import save_glb, save_object_scene, save_scene, save_sheet, save_views

_HOMES = {
    "UFGW": "graft.transport",
    "Contact": "graft.objects",
    "Demonstration": "graft.objects",
    "DenseMap": "graft.contact",
    "Descriptor": "graft.features",
    "GeometricDescriptor": "graft.features",
    "GraftError": "graft.errors",
    "InputError": "graft.errors",
    "InputWarning": "graft.errors",
    "Joint": "graft.objects",
    "Library": "graft.library",
    "Match": "graft.library",
    "MissingExtraError": "graft.errors",
    "Part": "graft.objects",
    "PartFlag": "graft.graph",
    "PartGraph": "graft.graph",
    "PartObject": "graft.objects",
    "TransferredContact": "graft.contact",
    "Transport": "graft.transport",
    "agree": "graft.contact",
    "as_object": "graft.io",
    "build_graph": "graft.graph",
    "dense_map": "graft.contact",
    "load_demonstration": "graft.io",
    "load_demonstrations": "graft.io",
    "load_object": "graft.io",
    "mark_contact": "graft.marking",
    "match": "graft.library",
    "save_demonstration": "graft.io",
    "save_glb": "graft.viz",
    "save_object": "graft.io",
    "save_object_scene": "graft.viz",
    "save_scene": "graft.viz",
    "save_sheet": "graft.viz",
    "save_views": "graft.viz",
    "segment": "graft.io",
    "segment_hierarchy": "graft.io",
    "transfer_contact": "graft.contact",
    "ufgw": "graft.transport",
    "ufgw_batch": "graft.transport",
}

__version__ = "0.1.0"
__all__ = [
    "UFGW",
    "Contact",
    "Demonstration",
    "DenseMap",
    "Descriptor",
    "GeometricDescriptor",
    "GraftError",
    "InputError",
    "InputWarning",
    "Joint",
    "Library",
    "Match",
    "MissingExtraError",
    "Part",
    "PartFlag",
    "PartGraph",
    "PartObject",
    "TransferredContact",
    "Transport",
    "agree",
    "as_object",
    "build_graph",
    "dense_map",
    "load_demonstration",
    "load_demonstrations",
    "load_object",
    "mark_contact",
    "match",
    "save_demonstration",
    "save_glb",
    "save_object",
    "save_object_scene",
    "save_scene",
    "save_sheet",
    "save_views",
    "segment",
    "segment_hierarchy",
    "transfer_contact",
    "ufgw",
    "ufgw_batch",
]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'graft' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOMES])

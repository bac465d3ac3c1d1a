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
    from graft.grasp import (
        PANDA_HAND,
        ROBOTIQ_2F85,
        Grasp,
        GraspSet,
        Gripper,
        find_gripper,
        load_grasps,
        plan_grasps,
        save_grasps,
    )
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
    from graft.motion import Approach, Motion, MotionConfig, plan_approach, plan_motion, plan_motions
    from graft.objects import Contact, Demonstration, Joint, Part, PartObject
    from graft.sim import Outcome, SimulationConfig, Trial, prepare, simulate_grasp, simulate_grasps
    from graft.sim.pictures import save_trial
    from graft.transport import UFGW, Transport, ufgw, ufgw_batch
    from graft.viz import (
        save_glb,
        save_grasp_glb,
        save_grasp_scene,
        save_grasp_sheet,
        save_object_scene,
        save_scene,
        save_sheet,
        save_views,
    )

_HOMES = {
    "PANDA_HAND": "graft.grasp",
    "ROBOTIQ_2F85": "graft.grasp",
    "UFGW": "graft.transport",
    "Approach": "graft.motion",
    "Contact": "graft.objects",
    "Demonstration": "graft.objects",
    "DenseMap": "graft.contact",
    "Descriptor": "graft.features",
    "GeometricDescriptor": "graft.features",
    "GraftError": "graft.errors",
    "Grasp": "graft.grasp",
    "GraspSet": "graft.grasp",
    "Gripper": "graft.grasp",
    "InputError": "graft.errors",
    "InputWarning": "graft.errors",
    "Joint": "graft.objects",
    "Library": "graft.library",
    "Match": "graft.library",
    "MissingExtraError": "graft.errors",
    "Motion": "graft.motion",
    "MotionConfig": "graft.motion",
    "Outcome": "graft.sim",
    "Part": "graft.objects",
    "PartFlag": "graft.graph",
    "PartGraph": "graft.graph",
    "PartObject": "graft.objects",
    "SimulationConfig": "graft.sim",
    "TransferredContact": "graft.contact",
    "Transport": "graft.transport",
    "Trial": "graft.sim",
    "agree": "graft.contact",
    "as_object": "graft.io",
    "build_graph": "graft.graph",
    "dense_map": "graft.contact",
    "find_gripper": "graft.grasp",
    "load_demonstration": "graft.io",
    "load_demonstrations": "graft.io",
    "load_grasps": "graft.grasp",
    "load_object": "graft.io",
    "mark_contact": "graft.marking",
    "match": "graft.library",
    "plan_approach": "graft.motion",
    "plan_grasps": "graft.grasp",
    "plan_motion": "graft.motion",
    "plan_motions": "graft.motion",
    "prepare": "graft.sim",
    "save_demonstration": "graft.io",
    "save_glb": "graft.viz",
    "save_grasp_glb": "graft.viz",
    "save_grasp_scene": "graft.viz",
    "save_grasp_sheet": "graft.viz",
    "save_grasps": "graft.grasp",
    "save_object": "graft.io",
    "save_object_scene": "graft.viz",
    "save_scene": "graft.viz",
    "save_sheet": "graft.viz",
    "save_trial": "graft.sim.pictures",
    "save_views": "graft.viz",
    "simulate_grasp": "graft.sim",
    "simulate_grasps": "graft.sim",
    "segment": "graft.io",
    "segment_hierarchy": "graft.io",
    "transfer_contact": "graft.contact",
    "ufgw": "graft.transport",
    "ufgw_batch": "graft.transport",
}

__version__ = "0.1.0"
__all__ = [
    "PANDA_HAND",
    "ROBOTIQ_2F85",
    "UFGW",
    "Approach",
    "Contact",
    "Demonstration",
    "DenseMap",
    "Descriptor",
    "GeometricDescriptor",
    "GraftError",
    "Grasp",
    "GraspSet",
    "Gripper",
    "InputError",
    "InputWarning",
    "Joint",
    "Library",
    "Match",
    "MissingExtraError",
    "Motion",
    "MotionConfig",
    "Outcome",
    "Part",
    "PartFlag",
    "PartGraph",
    "PartObject",
    "SimulationConfig",
    "TransferredContact",
    "Transport",
    "Trial",
    "agree",
    "as_object",
    "build_graph",
    "dense_map",
    "find_gripper",
    "load_demonstration",
    "load_demonstrations",
    "load_grasps",
    "load_object",
    "mark_contact",
    "match",
    "plan_approach",
    "plan_grasps",
    "plan_motion",
    "plan_motions",
    "prepare",
    "save_demonstration",
    "save_glb",
    "save_grasp_glb",
    "save_grasp_scene",
    "save_grasp_sheet",
    "save_grasps",
    "save_object",
    "save_object_scene",
    "save_scene",
    "save_sheet",
    "save_trial",
    "save_views",
    "segment",
    "segment_hierarchy",
    "simulate_grasp",
    "simulate_grasps",
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

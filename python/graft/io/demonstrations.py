"""Demonstrations as folders: `demonstration.json` and the object it names (docs/demonstrations.md)."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from graft.errors import InputError
from graft.io.atomic import write_whole
from graft.io.folder import DEMONSTRATION_FILE
from graft.io.guards import malformed_is_input_error, read_json, resolve_inside
from graft.io.load import load_object
from graft.io.save import save_object
from graft.io.sidecar import is_number, is_whole
from graft.io.trajectories import load_trajectory, save_trajectory
from graft.marking import closest_surface_point
from graft.objects import Contact, Demonstration, Floats, PartObject

SCHEMA = 1
"""Version of demonstration.json."""

OBJECT_FILE = "object.glb"
"""What `save_demonstration` calls the object."""

TRAJECTORY_FILE = "trajectory.npz"
"""What `save_demonstration` calls the trajectory."""

ON_SURFACE = 0.02
"""A contact this share of the object's diagonal off the surface is on it, as points that people click are; it
is then put onto the surface. Further off is an error."""

ROUNDING = 1e-6
"""Closer than this share of the diagonal, the difference is that of float32, and the contact stays as it was
written."""


def load_demonstration(folder: str | Path) -> Demonstration:
    """Read one demonstration.

    Keys `category`, `up`, `scale_to_metres` and `graspable` (names of parts) override what the object's file
    says.

    Args:
        folder: Holds a demonstration.json and the object.

    Raises:
        InputError: A file is missing or malformed, the object is outside the folder, or the contact is not on
            the object; the message has the distance.
    """
    folder = Path(folder)
    path = folder / DEMONSTRATION_FILE
    if not folder.is_dir():
        raise InputError("no such demonstration folder", path=folder)
    words = read_json(path)
    schema = words.get("schema")
    if not is_whole(schema) or schema != SCHEMA:
        newer = ", a newer graft wrote it" if is_whole(schema) and schema > SCHEMA else ""
        raise InputError(f"schema: expected {SCHEMA}, got {schema!r}{newer}", path=path)
    reference = _get(words, "object", str, path)
    if reference is None:
        raise InputError("object: expected the name of the object's file", path=path)
    inside = resolve_inside(reference, root=folder, path=path)
    if inside == folder.resolve():
        raise InputError("object: expected a file or folder inside, got the folder itself", path=path)
    obj = load_object(folder / reference.replace("\\", "/"))
    with malformed_is_input_error(path, "demonstration"):
        obj = _described(obj, words, path)
        contact = _contact(obj, words, path)
        metadata = _get(words, "metadata", dict, path) or {}
        name = _get(words, "name", str, path) or folder.resolve().name
        trajectory = _get(words, "trajectory", str, path)
        if trajectory is not None:
            resolve_inside(trajectory, root=folder, path=path)
        return Demonstration(
            obj,
            contact,
            name,
            metadata,
            grasp=_get(words, "grasp", list, path),
            trajectory=None if trajectory is None else load_trajectory(folder / trajectory.replace("\\", "/")),
        )


def load_demonstrations(root: str | Path) -> list[Demonstration]:
    """Read every demonstration among the folders in `root`, in the order of their names.

    Folders without a demonstration.json, and hidden ones, are passed over. `root` may be a demonstration
    itself.

    Raises:
        InputError: There is no such folder, or demonstrations cannot be read: every bad one is named.
    """
    root = Path(root)
    if not root.is_dir():
        raise InputError("no such folder of demonstrations", path=root)
    if (root / DEMONSTRATION_FILE).is_file():
        return [load_demonstration(root)]
    found, errors = [], []
    for folder in sorted(root.iterdir()):
        if not folder.name.startswith(".") and (folder / DEMONSTRATION_FILE).is_file():
            try:
                found.append(load_demonstration(folder))
            except InputError as error:
                errors.append(error)
    if len(errors) == 1:
        raise errors[0]
    if errors:
        total = len(found) + len(errors)
        raise InputError(
            f"{len(errors)} of {total} demonstrations cannot be read: {'; '.join(map(str, errors))}",
            path=root,
        )
    return found


def save_demonstration(folder: str | Path, demonstration: Demonstration) -> None:
    """Write a demonstration as a folder with object.glb, demonstration.json and, if it has one, trajectory.npz.

    The folder appears at once and complete. One that this function wrote before is replaced.

    Args:
        folder: To be made; folders on the way are, too.
        demonstration: Its metadata must be strings, numbers, lists and dictionaries.

    Raises:
        InputError: The folder holds other files, or the metadata do not fit JSON.
    """
    folder = Path(folder)
    obj, contact = demonstration.object, demonstration.contact
    if folder.exists():
        if not folder.is_dir():
            raise InputError("expected a folder, it is a file", path=folder)
        ours = (OBJECT_FILE, DEMONSTRATION_FILE, TRAJECTORY_FILE)
        others = sorted(p.name for p in folder.iterdir() if p.name not in ours)
        if others:
            raise InputError(f"the folder holds other files, nothing is written: {', '.join(others[:5])}", path=folder)
    document = {
        "schema": SCHEMA,
        "name": demonstration.name,
        "object": OBJECT_FILE,
        "category": obj.category,
        "up": None if obj.up is None else obj.up.tolist(),
        "scale_to_metres": obj.scale_to_metres,
        "graspable": [obj.parts[i].name for i in obj.graspable],
        "contact": {
            "point": contact.point.tolist(),
            "normal": contact.normal.tolist(),
            "part": obj.parts[contact.part].name,
            "approach": None if contact.approach is None else contact.approach.tolist(),
        },
        "metadata": dict(demonstration.metadata),
    }
    if demonstration.grasp is not None:
        document["grasp"] = demonstration.grasp.tolist()
    if demonstration.trajectory is not None:
        document["trajectory"] = TRAJECTORY_FILE
    try:
        text = json.dumps(document, indent=1, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InputError(f"metadata of {demonstration.name!r}: {error}", path=folder) from None
    folder.parent.mkdir(parents=True, exist_ok=True)
    work = Path(tempfile.mkdtemp(dir=folder.parent, prefix=f".{folder.name}."))
    try:
        new = work / "new"
        save_object(new / OBJECT_FILE, obj)
        if demonstration.trajectory is not None:
            save_trajectory(new / TRAJECTORY_FILE, demonstration.trajectory)
        write_whole(new / DEMONSTRATION_FILE, text.encode())
        if folder.exists():
            folder.rename(work / "old")
            try:
                new.rename(folder)
            except OSError:
                (work / "old").rename(folder)
                raise
        else:
            new.rename(folder)
        handle = os.open(folder.parent, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
    finally:
        shutil.rmtree(work, ignore_errors=True)


def _get(words: dict[str, Any], key: str, kind: type, path: Path) -> Any:
    """Return a value that is absent, null or of the given type."""
    value = words.get(key)
    if value is not None and not isinstance(value, kind):
        raise InputError(f"{key}: expected {_KINDS[kind]}, got {str(value)[:60]!r}", path=path)
    return value


_KINDS: dict[type, str] = {str: "a string", dict: "an object", list: "a list"}


def _vector(words: dict[str, Any], key: str, where: str, path: Path) -> Floats | None:
    value = words.get(key)
    if value is None:
        return None
    if not (isinstance(value, list) and len(value) == 3 and all(map(is_number, value))):
        raise InputError(f"{where}{key}: expected three numbers, got {str(value)[:60]!r}", path=path)
    return np.array(value, np.float64)


def _described(obj: PartObject, words: dict[str, Any], path: Path) -> PartObject:
    scale = words.get("scale_to_metres")
    if scale is not None and not (is_number(scale) and scale > 0):
        raise InputError(f"scale_to_metres: expected a positive number, got {str(scale)[:60]!r}", path=path)
    up = _vector(words, "up", "", path)
    graspable = _get(words, "graspable", list, path)
    if graspable is not None and not all(isinstance(name, str) or is_whole(name) for name in graspable):
        raise InputError(f"graspable: expected names of parts, got {str(graspable)[:60]!r}", path=path)
    return replace(
        obj,
        category=_get(words, "category", str, path) or obj.category,
        up=obj.up if up is None else up,
        scale_to_metres=obj.scale_to_metres if scale is None else float(scale),
        graspable=obj.graspable if graspable is None else tuple(obj.part_index(name) for name in graspable),
    )


def _contact(obj: PartObject, words: dict[str, Any], path: Path) -> Contact:
    """Make the contact: onto the surface, with what is not written taken from the nearest face and part."""
    given = _get(words, "contact", dict, path)
    if given is None or given.get("point") is None:
        raise InputError("contact: expected an object with a point", path=path)
    point = _vector(given, "point", "contact ", path)
    assert point is not None
    named = given.get("part")
    if named is not None and not (isinstance(named, str) or is_whole(named)):
        raise InputError(f"contact part: expected a name or number, got {str(named)[:60]!r}", path=path)
    candidates = range(len(obj.parts)) if named is None else (obj.part_index(named),)
    places = {i: closest_surface_point(obj.parts[i], point) for i in candidates}
    part = min(places, key=lambda i: (places[i][2], i))
    place, normal, distance = places[part]
    diagonal = float(np.linalg.norm(np.ptp(obj.bounds, axis=0)))
    if distance > ON_SURFACE * diagonal:
        what = "the object" if named is None else f"part {obj.parts[part].name!r}"
        raise InputError(
            f"contact point {point.tolist()} is not on {what}: it is {distance:.4g} away, "
            f"the object is {diagonal:.4g} across",
            path=path,
        )
    written = _vector(given, "normal", "contact ", path)
    return Contact(
        point if distance <= ROUNDING * diagonal else place,
        normal if written is None else written,
        part,
        _vector(given, "approach", "contact ", path),
    )

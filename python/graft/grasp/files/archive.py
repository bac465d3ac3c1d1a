"""Our .npz: one array per field of `GraspSet`, and JSON bytes with what is no array. No pickle."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from graft.errors import InputError
from graft.grasp.files.rows import check_finite, check_poses, check_widths
from graft.grasp.grasps import GraspSet
from graft.grasp.gripper_files import gripper_document, gripper_from_document
from graft.io.arrays import read_npz
from graft.io.atomic import write_whole
from graft.io.guards import parse_json
from graft.io.sidecar import is_number, is_whole

SCHEMA = "graft-grasps/1"
"""What the metadata says it is; another number is another layout."""

UNITS = {"length": "metre", "angle": "radian", "force": "newton", "mass": "kilogram"}
FRAME = "poses are T_object_gripper: origin at the TCP, z approach, y closing"

SHAPES: dict[str, tuple[int, ...]] = {"poses": (4, 4), "widths": (), "scores": (), "contacts": (2, 3), "distances": ()}
"""Array -> shape of a row."""

TERM = "term."
"""Arrays that are terms of the scores begin with this."""


def write_archive(path: Path, grasps: GraspSet) -> None:
    """Write grasps with all there is."""
    from graft import __version__

    words = {
        "schema": SCHEMA,
        "units": UNITS,
        "frame": FRAME,
        "gripper": gripper_document(grasps.gripper),
        "rejected": {reason: int(count) for reason, count in grasps.rejected.items()},
        "metadata": {"graft": __version__, "numpy": np.__version__, **grasps.metadata},
    }
    arrays: dict[str, Any] = {name: getattr(grasps, name) for name in SHAPES}
    arrays |= {TERM + name: term for name, term in grasps.terms.items()}
    arrays["metadata"] = np.frombuffer(json.dumps(words, allow_nan=False).encode(), np.uint8)
    write_whole(path, _npz(arrays))


def _npz(arrays: dict[str, Any]) -> bytes:
    """Return the bytes of an .npz archive; `np.savez` would write the time of day into it."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, array in arrays.items():
            member = io.BytesIO()
            np.lib.format.write_array(member, np.asarray(array), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), member.getvalue(), zipfile.ZIP_DEFLATED)
    return buffer.getvalue()


def read_archive(path: Path) -> GraspSet:
    """Read grasps that `write_archive` wrote.

    Raises:
        InputError: It is something else, or from a newer graft; the message names the array and the row.
    """
    arrays = read_npz(path)
    missing = [name for name in (*SHAPES, "metadata") if name not in arrays]
    if missing:
        raise InputError(f"no grasps of graft: there is no array {missing[0]!r}", path=path)
    if arrays["metadata"].dtype != np.uint8:
        raise InputError(f"metadata: expected bytes, got {arrays['metadata'].dtype}", path=path)
    words = parse_json(arrays["metadata"].tobytes(), path=path, what="metadata")
    if words.get("schema") != SCHEMA:
        raise InputError(f"schema: expected {SCHEMA!r}, got {words.get('schema')!r}", path=path)
    count = len(arrays["poses"]) if arrays["poses"].ndim else 0
    terms = {name: () for name in arrays if name.startswith(TERM)}
    for name, shape in {**SHAPES, **terms}.items():
        array = arrays[name]
        if array.shape != (count, *shape) or array.dtype.kind not in "fiu":
            raise InputError(
                f"{name}: expected numbers of shape {(count, *shape)}, got {array.dtype} of {array.shape}", path=path
            )
        check_finite(path, name, array)
    check_poses(path, arrays["poses"])
    check_widths(path, arrays["widths"])
    gripper = words.get("gripper")
    if not isinstance(gripper, dict):
        raise InputError("metadata: expected a gripper", path=path)
    try:
        return GraspSet(
            arrays["poses"],
            arrays["widths"],
            arrays["scores"],
            arrays["contacts"],
            arrays["distances"],
            gripper_from_document(gripper, path=path),
            {name.removeprefix(TERM): arrays[name] for name in terms},
            _plain(words.get("rejected", {}), "rejected", path, counts=True),
            _plain(words.get("metadata", {}), "metadata", path),
        )
    except InputError as error:
        raise (error if error.path is not None else InputError(str(error), path=path)) from None


def _plain(value: Any, what: str, path: Path, *, counts: bool = False) -> dict[str, Any]:
    """Return a dictionary of strings and numbers, or of counts."""
    good = isinstance(value, dict) and all(
        is_whole(v) if counts else isinstance(v, str) or is_number(v) for v in value.values()
    )
    if not good:
        raise InputError(f"{what}: expected {'counts' if counts else 'strings and numbers'} by name", path=path)
    return dict(value)

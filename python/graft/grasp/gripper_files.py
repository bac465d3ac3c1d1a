"""Grippers in TOML files and in the metadata of other files: `load_gripper`, `save_gripper`, `find_gripper`.

name = "my_gripper"
stroke = 0.08                 # largest opening between the pads, metres
flange = 0.1034               # the TCP straight ahead of the flange; or a table of position and rotation (rows)
force = 15.0                  # newtons a finger, optional
max_force = 70.0              # optional
mass = 0.73                   # kilograms, optional

[[palm]]                      # boxes of the hand, in the gripper frame (see graft.grasp.gripper)
center = [0.0, 0.0, -0.0704]
half_extents = [0.0315, 0.1025, 0.033]

[[finger]]                    # boxes of the finger at +y in its own frame; the first is the pad
center = [0.0, 0.00725, 0.0]
half_extents = [0.009, 0.00725, 0.009]
rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]   # optional, rows
"""

from __future__ import annotations

import difflib
import json
import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from graft.checks import Floats
from graft.errors import InputError
from graft.grasp.gripper import PANDA_HAND, ROBOTIQ_2F85, Box, Gripper
from graft.grasp.gripper_model import gripper_from_model
from graft.io.atomic import write_whole
from graft.io.guards import MAX_TEXT_BYTES, read_bytes
from graft.io.sidecar import is_number

BUILTIN: Mapping[str, Gripper] = {gripper.name: gripper for gripper in (PANDA_HAND, ROBOTIQ_2F85)}
"""Grippers that need no file."""

NUMBERS = ("stroke", "force", "max_force", "mass")
REQUIRED = ("name", "stroke", "flange", "palm", "finger")
KEYS = (*REQUIRED, "force", "max_force", "mass")
BOX_REQUIRED = ("center", "half_extents")
BOX_KEYS = (*BOX_REQUIRED, "rotation")
FLANGE_REQUIRED = ("position",)
FLANGE_KEYS = (*FLANGE_REQUIRED, "rotation")

MODEL_SUFFIXES = (".xml", ".urdf")
"""Of robot descriptions, MJCF and URDF."""


def find_gripper(name: str | os.PathLike[str], *, packages: Mapping[str, Path] | None = None) -> Gripper:
    """Return a gripper by the name of a built-in one, or from a file.

    Args:
        name: One of `BUILTIN`, or a path.
        packages: Folders that a model may name files in, see `load_object`.

    Raises:
        InputError: Neither; the message lists the names. See `load_gripper`.
    """
    text = os.fspath(name)
    if text in BUILTIN:
        return BUILTIN[text]
    if Path(text).suffix.lower() in (".toml", *MODEL_SUFFIXES):
        return load_gripper(text, packages=packages)
    close = difflib.get_close_matches(text, BUILTIN, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    raise InputError(
        f"gripper: expected one of {', '.join(BUILTIN)}, or a .toml, .xml or .urdf file, got {text!r}{hint}"
    )


def load_gripper(path: str | os.PathLike[str], *, packages: Mapping[str, Path] | None = None) -> Gripper:
    """Read a gripper from TOML (see this module), or from the MJCF or URDF of its hand.

    Args:
        path: Ends in .toml, .xml or .urdf.
        packages: Folders that a model may name files in, see `load_object`.

    Raises:
        InputError: The file cannot be used; the message names the field. See `gripper_from_model` for models.
    """
    file = Path(path)
    suffix = file.suffix.lower()
    if suffix in MODEL_SUFFIXES:
        return gripper_from_model(file, packages=packages)
    if suffix != ".toml":
        raise InputError(f"gripper: expected .toml, .xml or .urdf, got {suffix!r}", path=file)
    try:
        document = tomllib.loads(read_bytes(file, limit=MAX_TEXT_BYTES).decode("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InputError(f"not TOML: {error}", path=file) from None
    return gripper_from_document(document, path=file)


def save_gripper(path: str | os.PathLike[str], gripper: Gripper) -> None:
    """Write a gripper as TOML; `load_gripper` gives it back to the last bit.

    Raises:
        InputError: Another suffix, or the file cannot be written.
    """
    file = Path(path)
    if file.suffix.lower() != ".toml":
        raise InputError(f"expected a file ending in .toml, got {file.name!r}", path=file)
    document = gripper_document(gripper)
    # JSON's strings and arrays of numbers are TOML's, except for one control character.
    name = json.dumps(gripper.name, ensure_ascii=False).replace("\x7f", "\\u007f")
    lines = [f"name = {name}", *(f"{key} = {document[key]!r}" for key in NUMBERS)]
    tables = [("[flange]", document["flange"])]
    tables += [(f"[[{kind}]]", box) for kind in ("palm", "finger") for box in document[kind]]
    for heading, table in tables:
        lines += ["", heading, *(f"{key} = {json.dumps(value)}" for key, value in table.items())]
    # An empty array of tables is written as an empty array, before the first table.
    if not gripper.palm:
        lines.insert(1, "palm = []")
    write_whole(file, ("\n".join(lines) + "\n").encode())


def gripper_document(gripper: Gripper) -> dict[str, Any]:
    """Return a gripper as strings, numbers, lists and dictionaries, in the layout of the TOML file."""
    return {
        "name": gripper.name,
        **{key: float(getattr(gripper, key)) for key in NUMBERS},
        "flange": {"position": gripper.flange[:3, 3].tolist(), "rotation": gripper.flange[:3, :3].tolist()},
        "palm": [_box_document(box) for box in gripper.palm],
        "finger": [_box_document(box) for box in gripper.finger],
    }


def gripper_from_document(document: Mapping[str, Any], *, path: Path) -> Gripper:
    """Return the gripper that a document in the layout of the TOML file describes.

    Args:
        document: What the file holds.
        path: The file, for messages.

    Raises:
        InputError: A field is missing, unknown or wrong; the message names it.
    """
    _check_keys(document, KEYS, REQUIRED, "", path)
    if not isinstance(document["name"], str):
        raise InputError(f"name: expected a string, got {document['name']!r}", path=path)
    numbers = {key: _number(document[key], key, path) for key in NUMBERS if key in document}
    # A gripper stronger than ours need not say that it may use the force it gives.
    if "force" in numbers:
        numbers.setdefault("max_force", max(numbers["force"], Gripper.max_force))
    elif numbers.get("max_force", Gripper.force) < Gripper.force:
        numbers["force"] = numbers["max_force"]
    boxes = {kind: _boxes(document[kind], kind, path) for kind in ("palm", "finger")}
    try:
        return Gripper(
            document["name"],
            palm=boxes["palm"],
            finger=boxes["finger"],
            flange=_flange(document["flange"], path),
            **numbers,
        )
    except InputError as error:
        raise InputError(str(error), path=path) from None


def _box_document(box: Box) -> dict[str, Any]:
    document = {"center": box.center.tolist(), "half_extents": box.half_extents.tolist()}
    if not np.array_equal(box.rotation, np.eye(3)):
        document["rotation"] = box.rotation.tolist()
    return document


def _boxes(value: Any, kind: str, path: Path) -> tuple[Box, ...]:
    if not isinstance(value, list) or not all(isinstance(box, dict) for box in value):
        raise InputError(f"{kind}: expected boxes ([[{kind}]] tables), got {_shown(value)}", path=path)
    made = []
    for i, box in enumerate(value):
        where = f"{kind} box {i + 1}"
        _check_keys(box, BOX_KEYS, BOX_REQUIRED, where, path)
        vectors = [_vector(box[key], f"{where} {key}", path) for key in BOX_REQUIRED]
        rotation = _rotation(box, where, path)
        try:
            made.append(Box(vectors[0], vectors[1], rotation))
        except InputError as error:
            raise InputError(f"{where}: {error}", path=path) from None
    return tuple(made)


def _flange(value: Any, path: Path) -> Floats:
    frame = np.eye(4)
    if is_number(value):
        frame[2, 3] = value
        return frame
    if not isinstance(value, dict):
        raise InputError(
            f"flange: expected a number or a table of position and rotation, got {_shown(value)}", path=path
        )
    _check_keys(value, FLANGE_KEYS, FLANGE_REQUIRED, "flange", path)
    frame[:3, 3] = _vector(value["position"], "flange position", path)
    frame[:3, :3] = _rotation(value, "flange", path)
    return frame


def _rotation(table: Mapping[str, Any], where: str, path: Path) -> Floats:
    rows = table.get("rotation", np.eye(3).tolist())
    if not isinstance(rows, list) or len(rows) != 3:
        raise InputError(f"{where} rotation: expected three rows of three numbers, got {_shown(rows)}", path=path)
    return np.array([_vector(row, f"{where} rotation", path) for row in rows])


def _vector(value: Any, where: str, path: Path) -> Floats:
    if not (isinstance(value, list) and len(value) == 3 and all(map(is_number, value))):
        raise InputError(f"{where}: expected three numbers, got {_shown(value)}", path=path)
    return np.array(value, np.float64)


def _number(value: Any, where: str, path: Path) -> float:
    if not is_number(value):
        raise InputError(f"{where}: expected a number, got {_shown(value)}", path=path)
    return float(value)


def _check_keys(
    table: Mapping[str, Any], known: tuple[str, ...], required: tuple[str, ...], where: str, path: Path
) -> None:
    prefix = f"{where}: " if where else ""
    for key in table:
        if key not in known:
            close = difflib.get_close_matches(key, known, n=1)
            hint = f"did you mean {close[0]!r}?" if close else f"the known ones are {', '.join(known)}"
            raise InputError(f"{prefix}unknown key {key!r}; {hint}", path=path)
    for key in required:
        if key not in table:
            raise InputError(f"{prefix}missing {key!r}", path=path)


def _shown(value: Any) -> str:
    return repr(value)[:60]

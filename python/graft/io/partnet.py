"""PartNet-Mobility folders: mobility.urdf, semantics.txt, textured_objs/*.obj, result.json, meta.json.

The data set: https://sapien.ucsd.edu/browse. Within a link, every visual belongs to an instance of a
semantic part, which its name tells ("handle-4", one name for all the meshes of that handle). A part of ours
is one such instance on one link, so a door's handle and frame are two.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from graft.errors import InputError
from graft.io.guards import existing_file, parse_json, read_json, read_text
from graft.io.robot_parts import Body, RigidPiece, check_choice, merged_piece, parts_and_joints
from graft.io.robot_xml import read_description
from graft.io.urdf import MISSING_CHOICES, UP, Missing, read_scene
from graft.io.urdf_file import parse_robot
from graft.objects import PartObject

DESCRIPTION = "mobility.urdf"
INSTANCE = re.compile(r"(?P<label>.+?)-\d+")
"""A semantic part's label and its number in the object, as PartNet-Mobility names visuals."""

MAX_LIST_BYTES = 16 << 20
"""Largest semantics.txt or result.json that is read; real ones have some kilobytes."""


def is_partnet(folder: str | Path) -> bool:
    """Tell whether `folder` is a PartNet-Mobility object."""
    return (Path(folder) / DESCRIPTION).is_file()


def load_partnet(folder: str | Path, *, missing: Missing = "error") -> PartObject:
    """Load a PartNet-Mobility object.

    Names and labels of parts come from the visuals' names; where a visual has none, from the leaf of
    result.json that lists its mesh; else from the link's line in semantics.txt. The category comes from
    meta.json.

    Args:
        folder: The object's folder.
        missing: Whether meshes that are not there, as in some of the objects, are an error, or are left out
            with one `InputWarning` that sums them up.

    Returns:
        The object in the base link's frame, z up. Sizes are normalised in this data set, so `scale_to_metres`
        is None.

    Raises:
        InputError: A file of the folder cannot be used.
    """
    folder = Path(folder)
    check_choice("missing", missing, MISSING_CHOICES)
    path = existing_file(folder / DESCRIPTION, what="PartNet-Mobility description")
    robot = parse_robot(path, read_description(path))
    scene = read_scene(path, robot, packages={}, missing=missing)
    semantics = _semantics(folder / "semantics.txt")
    leaves = _leaves(folder / "result.json")
    notes = list(scene.notes)
    unknown = [link for link in semantics if link not in {body.name for body in scene.bodies}]
    if unknown:
        notes.append(f"semantics.txt names links that do not exist: {', '.join(unknown[:3])}")
    bodies = [replace(body, pieces=tuple(_instances(body, semantics, leaves))) for body in scene.bodies]
    try:
        parts, joints = parts_and_joints(_named_apart(bodies), whole=False)
    except InputError as error:
        raise InputError(str(error), path=path) from None
    return PartObject(
        name=folder.absolute().name,
        parts=parts,
        joints=joints,
        category=_category(folder / "meta.json"),
        up=np.array(UP),
        notes=tuple(notes),
        source=str(folder),
    )


def _instances(body: Body, semantics: Mapping[str, str], leaves: Mapping[str, str]) -> Iterator[RigidPiece]:
    """Join the pieces of `body` that belong to the same instance of a semantic part."""
    groups: dict[str, list[RigidPiece]] = {}
    for piece in body.pieces:
        name = piece.name if piece.named else leaves.get(piece.name) or semantics.get(body.name) or piece.name
        groups.setdefault(name, []).append(piece)
    for name, pieces in groups.items():
        instance = INSTANCE.fullmatch(name)
        label = instance["label"] if instance else semantics.get(body.name, name) if len(groups) == 1 else name
        yield replace(merged_piece(name, pieces), label=label)


def _named_apart(bodies: list[Body]) -> list[Body]:
    """Put the link's name before the names of parts that occur on several links."""
    owners: dict[str, set[str]] = {}
    for body in bodies:
        for piece in body.pieces:
            owners.setdefault(piece.name, set()).add(body.name)

    def renamed(body: Body, piece: RigidPiece) -> RigidPiece:
        return piece if len(owners[piece.name]) == 1 else replace(piece, name=f"{body.name}/{piece.name}")

    return [replace(body, pieces=tuple(renamed(body, piece) for piece in body.pieces)) for body in bodies]


def _semantics(path: Path) -> dict[str, str]:
    """Return the semantic name of every link: lines of link, kind of joint, name."""
    if not path.exists():
        return {}
    names: dict[str, str] = {}
    for number, line in enumerate(read_text(path, limit=MAX_LIST_BYTES).splitlines(), start=1):
        words = line.split()
        if not words:
            continue
        if len(words) != 3:
            raise InputError(f"line {number}: expected link, joint kind and name, got {line[:80]!r}", path=path)
        names[words[0]] = words[2]
    return names


def _leaves(path: Path) -> dict[str, str]:
    """Return the instance name ("handle-4") of every mesh, by its stem, from the tree in result.json."""
    if not path.exists():
        return {}
    names: dict[str, str] = {}
    # A document of ours is an object, PartNet's is a list: wrapped on one line, so that lines in messages
    # stay true.
    stack = parse_json(f'{{"parts": {read_text(path, limit=MAX_LIST_BYTES)}}}', path=path)["parts"]
    if not isinstance(stack, list):
        raise InputError(f"expected a list of parts, got {type(stack).__name__}", path=path)
    while stack:
        node = stack.pop()
        if not isinstance(node, dict) or not isinstance(node.get("children", []), list):
            raise InputError("expected a hierarchy of parts with children", path=path)
        stack.extend(node.get("children", []))
        if isinstance(node.get("name"), str) and isinstance(node.get("objs", []), list) and "children" not in node:
            for mesh in node.get("objs", []):
                names[str(mesh)] = f"{node['name']}-{node.get('id', 0)}"
    return names


def _category(path: Path) -> str | None:
    if not path.exists():
        return None
    category = read_json(path).get("model_cat")
    return category if isinstance(category, str) and category else None

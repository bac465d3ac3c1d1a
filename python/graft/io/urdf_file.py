"""What a URDF file says: its links and joints as a checked tree, every complaint with file and line.

The format: https://wiki.ros.org/urdf/XML. Lengths in metres, angles in radians.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from graft.checks import UNIT_TOLERANCE
from graft.io.robot_xml import at_line, numbers, transform_xyz_rpy
from graft.objects import Floats, JointType

XACRO_PREFIXES = (
    "xacro:",
    "{http://www.ros.org/wiki/xacro",
    "{http://ros.org/wiki/xacro",
    "{http://wiki.ros.org/xacro",
)
"""How the tags of xacro begin; its page has moved, and its namespace is not always declared."""

JOINT_KINDS: Mapping[str, JointType] = {
    "revolute": "hinge",
    "continuous": "hinge",
    "prismatic": "slide",
    "fixed": "fixed",
    "floating": "free",
    "planar": "planar",
}
"""URDF's joint types and ours."""

SHAPE_SIZES: Mapping[str, tuple[str, int]] = {"box": ("size", 3), "sphere": ("radius", 1)}
"""Attributes and their counts of shapes with one attribute."""

Element = Any
"""An lxml element; lxml ships no types."""


@dataclass(frozen=True, eq=False)
class Visual:
    """A piece of a link's geometry; `size` is (3,) box edges, (1,) a radius or (2,) radius and length."""

    name: str
    T_link_visual: Floats
    shape: str
    size: tuple[float, ...]
    mesh: str
    scale: Floats
    element: Element


@dataclass(frozen=True, eq=False)
class LinkJoint:
    """A joint; axis (3,) in the joint's frame, limits in radians or metres."""

    name: str
    kind: JointType
    parent: str
    child: str
    T_parent_child: Floats
    axis: Floats | None
    limits: tuple[float, float] | None
    notes: tuple[str, ...]
    element: Element


@dataclass(frozen=True, eq=False)
class Link:
    """A link with its visual and its collision geometry."""

    name: str
    visuals: tuple[Visual, ...]
    collisions: tuple[Visual, ...]
    element: Element


@dataclass(frozen=True, eq=False)
class Robot:
    """Links, parents before children, and the joint above each of them but the root."""

    links: tuple[Link, ...]
    joint_above: Mapping[str, LinkJoint]


def parse_robot(path: Path, root: Element) -> Robot:
    """Return the tree of links in the URDF document `root` read from `path`.

    Raises:
        InputError: It is not a URDF, holds xacro, or the links and joints do not form a tree.
    """
    if root.tag != "robot":
        raise at_line(path, root, f"root element: expected <robot>, got <{root.tag}>")
    _refuse_xacro(path, root)
    links: dict[str, Link] = {}
    for element in root.findall("link"):
        name = _name(path, element)
        if name in links:
            raise at_line(path, element, f"duplicate link name {name!r}")
        links[name] = Link(
            name,
            _geometry(path, element, name, "visual"),
            _geometry(path, element, name, "collision"),
            element,
        )
    if not links:
        raise at_line(path, root, "expected at least one <link>, found none")
    above: dict[str, LinkJoint] = {}
    names: set[str] = set()
    for element in root.findall("joint"):
        joint = _joint(path, element)
        for link in (joint.parent, joint.child):
            if link not in links:
                raise at_line(path, element, f"joint {joint.name!r}: no link called {link!r}")
        if joint.name in names:
            raise at_line(path, element, f"duplicate joint name {joint.name!r}")
        if joint.child in above:
            other = above[joint.child].name
            raise at_line(path, element, f"link {joint.child!r} has two parents, joints {other!r} and {joint.name!r}")
        names.add(joint.name)
        above[joint.child] = joint
    return Robot(_ordered(path, root, links, above), above)


def _ordered(path: Path, root: Element, links: Mapping[str, Link], above: Mapping[str, LinkJoint]) -> tuple[Link, ...]:
    """Return the links, parents before children, else in the order of the file."""
    roots = [name for name in links if name not in above]
    children: dict[str, list[str]] = {name: [] for name in links}
    for name in links:
        if name in above:
            children[above[name].parent].append(name)
    order: list[str] = []
    stack = roots[::-1]
    while stack:
        name = stack.pop()
        order.append(name)
        stack.extend(children[name][::-1])
    if len(order) < len(links):
        loop = _loop(next(name for name in links if name not in set(order)), above)
        raise at_line(path, above[loop[-1]].element, f"joints form a cycle: {' -> '.join(loop)}")
    if len(roots) > 1:
        names = ", ".join(roots[:5]) + (", ..." if len(roots) > 5 else "")
        raise at_line(path, links[roots[1]].element, f"expected one root link, found {len(roots)}: {names}")
    return tuple(links[name] for name in order)


def _loop(name: str, above: Mapping[str, LinkJoint]) -> list[str]:
    """Return the cycle above link `name`, from parent to child, its first link repeated at the end."""
    trail: list[str] = []
    while name not in trail:
        trail.append(name)
        name = above[name].parent
    return [name, *trail[trail.index(name) :][::-1]]


def _refuse_xacro(path: Path, root: Element) -> None:
    for element in root.iter():
        tag = element.tag if isinstance(element.tag, str) else ""
        if tag.startswith(XACRO_PREFIXES):
            raise at_line(path, element, f"holds xacro (<{tag}>): run xacro first and load its output")
        for value in element.attrib.values():
            if "${" in value or "$(" in value:
                raise at_line(path, element, f"holds xacro ({value!r}): run xacro first and load its output")


def _name(path: Path, element: Element) -> str:
    name: str = element.get("name", "")
    if not name.strip():
        raise at_line(path, element, f"<{element.tag}>: expected a name")
    return name


def _geometry(path: Path, link: Element, link_name: str, tag: str) -> tuple[Visual, ...]:
    return tuple(_visual(path, element, link_name) for element in link.findall(tag))


def _visual(path: Path, element: Element, link_name: str) -> Visual:
    geometry = element.find("geometry")
    shapes = [] if geometry is None else [child for child in geometry if isinstance(child.tag, str)]
    if not shapes:
        raise at_line(path, element, f"<{element.tag}> of link {link_name!r}: expected a shape in <geometry>")
    shape, mesh, scale = shapes[0], "", np.ones(3)
    size: tuple[float, ...] = ()
    if shape.tag in SHAPE_SIZES:
        size = _sizes(path, shape, *SHAPE_SIZES[shape.tag])
    elif shape.tag in ("cylinder", "capsule"):
        size = (*_sizes(path, shape, "radius", 1), *_sizes(path, shape, "length", 1))
    elif shape.tag == "mesh":
        mesh = shape.get("filename", "")
        scale = numbers(path, shape, "scale", 3, default=(1.0, 1.0, 1.0))
        if (np.abs(scale) < UNIT_TOLERANCE**2).any():
            raise at_line(
                path, shape, f"mesh scale: expected three numbers other than zero, got {shape.get('scale')!r}"
            )
    else:
        raise at_line(path, shape, f"expected box, cylinder, sphere, capsule or mesh, got <{shape.tag}>")
    return Visual(element.get("name", ""), _origin(path, element), shape.tag, size, mesh, scale, shape)


def _sizes(path: Path, element: Element, attribute: str, count: int) -> tuple[float, ...]:
    values = numbers(path, element, attribute, count)
    if (values <= 0).any():
        raise at_line(path, element, f"{element.tag} {attribute}: expected above zero, got {element.get(attribute)!r}")
    return tuple(values.tolist())


def _origin(path: Path, element: Element) -> Floats:
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    xyz = numbers(path, origin, "xyz", 3, default=(0.0, 0.0, 0.0))
    return transform_xyz_rpy(xyz, numbers(path, origin, "rpy", 3, default=(0.0, 0.0, 0.0)))


def _joint(path: Path, element: Element) -> LinkJoint:
    name = _name(path, element)
    where = f"joint {name!r}"
    given = element.get("type", "")
    if given not in JOINT_KINDS:
        raise at_line(path, element, f"{where} type: expected one of {', '.join(JOINT_KINDS)}, got {given!r}")
    ends = []
    for tag in ("parent", "child"):
        end = element.find(tag)
        if end is None or not end.get("link"):
            raise at_line(path, element, f"{where}: expected <{tag} link=...>")
        ends.append(end.get("link"))
    notes: list[str] = []
    axis = _axis(path, element, where, notes) if given not in ("fixed", "floating") else None
    limits = _limits(path, element, where, notes) if given in ("revolute", "prismatic") else None
    return LinkJoint(
        name,
        JOINT_KINDS[given],
        ends[0],
        ends[1],
        _origin(path, element),
        axis,
        limits,
        tuple(notes),
        element,
    )


def _axis(path: Path, element: Element, where: str, notes: list[str]) -> Floats:
    axis = element.find("axis")
    if axis is None:
        return np.array([1.0, 0.0, 0.0])
    direction = numbers(path, axis, "xyz", 3, default=(1.0, 0.0, 0.0))
    length = float(np.linalg.norm(direction))
    if length < UNIT_TOLERANCE:
        raise at_line(path, axis, f"{where} axis: expected a direction, got the zero vector")
    if abs(length - 1.0) > 1e-3:
        notes.append(f"{where}: axis of length {length:.4g} normalised")
    return direction / length


def _limits(path: Path, element: Element, where: str, notes: list[str]) -> tuple[float, float] | None:
    limit = element.find("limit")
    if limit is None:
        notes.append(f"{where}: no <limit>, taken as unlimited")
        return None
    lower, upper = (float(numbers(path, limit, end, 1, default=(0.0,))[0]) for end in ("lower", "upper"))
    if lower > upper:
        raise at_line(path, limit, f"{where} limits: expected lower <= upper, got {lower:g} > {upper:g}")
    return lower, upper

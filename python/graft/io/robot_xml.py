"""Robot descriptions as XML: reading them, numbers and frames in attributes, complaints with the line."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from graft.errors import InputError
from graft.io.guards import MAX_TEXT_BYTES, parse_xml, read_bytes
from graft.objects import Floats

LARGEST_NUMBER = 1e9
"""Attributes beyond this are taken for damage: no robot is larger than a planet, and products stay finite."""


def read_description(path: Path) -> Any:
    """Return the root element of a robot description, as `guards.read_xml` does.

    Prefixes need not be declared (`<drake:mimic/>` in many a URDF): no reader of these formats asks for that.

    Raises:
        InputError: It is not well-formed but for that, or has a DOCTYPE.
    """
    data = read_bytes(path, limit=MAX_TEXT_BYTES)
    try:
        return parse_xml(data, path=path)
    except InputError:
        root = _with_undeclared_prefixes(data)
        if root is None:
            raise
        return root


def _with_undeclared_prefixes(data: bytes) -> Any:
    """Return the root element if undeclared prefixes are all that is wrong with `data`, else None."""
    from lxml import etree

    parser = etree.XMLParser(recover=True, resolve_entities=False, load_dtd=False, no_network=True)
    try:
        root = etree.fromstring(data, parser)
    except (etree.XMLSyntaxError, ValueError):
        return None
    if root is None or root.getroottree().docinfo.doctype:
        return None
    harmless = all(entry.domain == etree.ErrorDomains.NAMESPACE for entry in parser.error_log)
    return root if harmless else None


def at_line(path: Path, element: Any, message: str) -> InputError:
    """Return an error that begins with the file and the line of the lxml `element`."""
    return InputError(f"line {element.sourceline}: {message}", path=path)


def numbers(path: Path, element: Any, attribute: str, count: int, default: Sequence[float] | None = None) -> Floats:
    """Return the `count` numbers in an attribute of the lxml `element`.

    Raises:
        InputError: They are not `count` finite numbers, or the attribute is absent and there is no default.
    """
    text = element.get(attribute)
    if text is None and default is not None:
        return np.array(default, np.float64)
    expected = "a finite number" if count == 1 else f"{count} finite numbers"
    try:
        values = np.array([float(word) for word in (text or "").split()], np.float64)
    except ValueError:
        values = np.empty(0)
    if len(values) != count or not np.isfinite(values).all():
        raise at_line(path, element, f"{element.tag} {attribute}: expected {expected}, got {_shown(text)}")
    if (np.abs(values) > LARGEST_NUMBER).any():
        raise at_line(path, element, f"{element.tag} {attribute}: beyond {LARGEST_NUMBER:g}, got {_shown(text)}")
    return values


def _shown(text: str | None) -> str:
    return "nothing" if text is None else repr(text[:80])


def transform_xyz_rpy(xyz: Floats, rpy: Floats) -> Floats:
    """Return the (4, 4) frame at `xyz` (3,), turned by `rpy` (3,) radians about the fixed x, y, z."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(rpy), np.cos(rpy)
    transform = np.eye(4)
    transform[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    transform[:3, 3] = xyz
    return transform

"""Numbers and frames in XML attributes, and complaints that name file and line."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from graft.errors import InputError
from graft.objects import Floats

LARGEST_NUMBER = 1e9
"""Attributes beyond this are taken for damage: no robot is larger than a planet, and products stay finite."""


def at_line(path: Path, element: Any, message: str) -> InputError:
    """Return an error that begins with the file and the line of the lxml `element`."""
    return InputError(f"line {element.sourceline}: {message}", path=path)


def numbers(
    path: Path, element: Any, attribute: str, count: int, default: Sequence[float] | None = None
) -> Floats:
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
        raise at_line(
            path, element, f"{element.tag} {attribute}: beyond {LARGEST_NUMBER:g}, got {_shown(text)}"
        )
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

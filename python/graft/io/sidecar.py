"""What stands next to a mesh: labels of its faces or points, and `object.json`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np

from graft.checks import UNIT_TOLERANCE
from graft.errors import InputError
from graft.io.arrays import Array, read_npy, read_npz
from graft.io.guards import contained, read_json, read_text
from graft.objects import Ints

LABEL_SUFFIXES = (".seg", ".npy", ".npz")
"""Of label files: one number per line, an array, or an archive with an array called labels."""

LABEL_KEYS = ("labels", "label", "seg", "segmentation")
"""Names of the array of labels in an archive."""


LARGEST = 1e150
"""Numbers in JSON stay below this, so that their squares are finite."""


@dataclass(frozen=True)
class ObjectWords:
    """What `object.json` says; everything may be absent.

    Attributes:
        name: Key "id".
        category: Key "category".
        part_names: Key "part_names": name of part number i; two handles may share one.
        graspable: Key "graspable_parts": numbers of parts.
        up: Key "up_axis": direction against gravity.
        scale_to_metres: Key "scale_to_metres".
    """

    name: str | None = None
    category: str | None = None
    part_names: tuple[str, ...] | None = None
    graspable: tuple[int, ...] = ()
    up: tuple[float, float, float] | None = None
    scale_to_metres: float | None = None


def read_object_words(path: Path) -> ObjectWords:
    """Read an `object.json`; keys it does not know are other people's and are left alone.

    Raises:
        InputError: Not a JSON object, or a key holds something else than it should.
    """
    words = read_json(path)

    def wrong(key: str, expected: str) -> InputError:
        return InputError(f"{key}: expected {expected}, got {str(words[key])[:60]!r}", path=path)

    def text(key: str) -> str | None:
        value = words.get(key)
        if value is not None and not (isinstance(value, str) and value):
            raise wrong(key, "a string")
        return value

    names = words.get("part_names")
    if names is not None and not (isinstance(names, list) and all(isinstance(n, str) and n for n in names)):
        raise wrong("part_names", "a list of names")
    graspable = words.get("graspable_parts") or []
    if not isinstance(graspable, list) or not all(is_whole(g) and g >= 0 for g in graspable):
        raise wrong("graspable_parts", "a list of part numbers")
    if names is not None and any(g >= len(names) for g in graspable):
        raise InputError(
            f"graspable_parts: part {max(graspable)} of {len(names)} part_names, which count from 0",
            path=path,
        )
    up = words.get("up_axis")
    if up is not None and not (
        isinstance(up, list) and len(up) == 3 and all(map(is_number, up)) and np.linalg.norm(up) > UNIT_TOLERANCE
    ):
        raise wrong("up_axis", "three numbers that make a direction, or null")
    scale = words.get("scale_to_metres")
    if scale is not None and not (is_number(scale) and scale > 0):
        raise wrong("scale_to_metres", "a positive number")
    return ObjectWords(
        text("id"),
        text("category"),
        None if names is None else tuple(names),
        tuple(graspable),
        None if up is None else (float(up[0]), float(up[1]), float(up[2])),
        None if scale is None else float(scale),
    )


def is_whole(value: Any) -> TypeGuard[int]:
    """Tell whether a value from JSON is a whole number."""
    return isinstance(value, int) and not isinstance(value, bool)


def is_number(value: Any) -> TypeGuard[float]:
    """Tell whether a value from JSON is a number that can be reckoned with."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < LARGEST


def find_beside(mesh: Path, stems: tuple[str, ...], suffixes: tuple[str, ...]) -> Path | None:
    """Return the first file next to `mesh` called a stem plus a suffix; a link out of there is refused."""
    for stem in stems:
        for suffix in suffixes:
            candidate = mesh.with_name(stem + suffix)
            if candidate != mesh and candidate.is_file():
                contained(candidate, root=mesh.parent, reference=candidate.name, path=mesh)
                return candidate
    return None


def read_labels(path: Path) -> Ints:
    """Read a label file: one whole number per line (.seg), an array (.npy), or an archive of one (.npz).

    Returns:
        (n,) int64.

    Raises:
        InputError: It holds something else.
    """
    suffix = path.suffix.lower()
    if suffix == ".npy":
        return whole_numbers(read_npy(path), path)
    if suffix == ".npz":
        return whole_numbers(label_array(read_npz(path), path), path)
    words = read_text(path, what="label file").split()
    try:
        return np.array(words, dtype=np.int64)
    except (ValueError, OverflowError):
        for number, word in enumerate(words, start=1):
            if not word.lstrip("+-").isdecimal() or len(word) > 18:
                raise InputError(f"label {number}: expected a whole number, got {word[:40]!r}", path=path) from None
        raise


def label_array(arrays: dict[str, Array], path: Path) -> Array:
    """Return the labels among the arrays of an archive."""
    key = next((k for k in LABEL_KEYS if k in arrays), None)
    if key is None and len(arrays) == 1:
        key = next(iter(arrays))
    if key is None:
        raise InputError(f"no array called {' or '.join(LABEL_KEYS)} among {', '.join(arrays) or 'none'}", path=path)
    return arrays[key]


def whole_numbers(values: Array, path: Path) -> Ints:
    """Return labels (n,) as int64.

    Raises:
        InputError: Another shape, or not whole numbers.
    """
    if values.ndim == 2 and 1 in values.shape:
        values = values.ravel()
    if values.ndim != 1 or values.dtype.kind not in "iufb":
        raise InputError(f"labels: expected one number each, got shape {values.shape} of {values.dtype}", path=path)
    if values.dtype.kind == "f" and not (np.isfinite(values).all() and (values == np.round(values)).all()):
        raise InputError("labels: expected whole numbers", path=path)
    return values.astype(np.int64)

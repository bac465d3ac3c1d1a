"""Arrays as they enter graft: converted once, checked for shape and finiteness, read-only from then on."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graft.errors import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

UNIT_TOLERANCE = 1e-6
"""A direction shorter than this has no direction."""

ROTATION_TOLERANCE = 1e-5
"""Columns of a rotation may be off unit length and right angles by this: single precision gives 1e-6."""


def checked_array(name: str, value: ArrayLike, shape: tuple[int | None, ...], dtype: type = np.float64) -> Any:
    """Return `value` as a read-only contiguous array, or raise `InputError` naming it.

    None in `shape` means any length.
    """
    try:
        array = np.asarray(value)
        if dtype is np.int64 and array.size and not np.issubdtype(array.dtype, np.integer):
            raise InputError(f"{name}: expected integers, got {array.dtype}")
        array = np.array(array, dtype=dtype, order="C", copy=True)
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{name}: expected an array of numbers, got {type(value).__name__} ({error})") from None
    if array.size == 0 and len(shape) == 2 and shape[1] is not None:
        array = array.reshape(0, shape[1])
    if array.ndim != len(shape) or any(w is not None and w != g for w, g in zip(shape, array.shape, strict=True)):
        want = ", ".join("n" if s is None else str(s) for s in shape)
        raise InputError(f"{name}: expected shape ({want}), got {array.shape}")
    if dtype is np.float64 and not np.isfinite(array).all():
        where = np.argwhere(~np.isfinite(array))[0]
        raise InputError(f"{name}: expected finite numbers, got {array[tuple(where)]} at {where.tolist()}")
    array.setflags(write=False)
    return array


def unit_vector(name: str, value: ArrayLike) -> Floats:
    """Return `value` (3,) as a read-only unit vector."""
    vector: Floats = checked_array(name, value, (3,))
    length = float(np.linalg.norm(vector))
    if length < UNIT_TOLERANCE:
        raise InputError(f"{name}: expected a direction, got the zero vector")
    unit: Floats = vector / length
    unit.setflags(write=False)
    return unit


def similarity_scale(linear: Floats) -> float:
    """Return by how much the linear part (3, 3) of a similarity stretches lengths."""
    return float(np.linalg.norm(linear) / np.sqrt(3.0))


def is_rotation(matrix: Floats) -> bool:
    """Whether (3, 3) is orthonormal to `ROTATION_TOLERANCE` and does not mirror."""
    error = np.abs(matrix.T @ matrix - np.eye(3)).max()
    return bool(error <= ROTATION_TOLERANCE and np.linalg.det(matrix) > 0)

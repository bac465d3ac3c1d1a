"""NumPy's .npy and .npz without pickle, and without believing the shape in the header."""

from __future__ import annotations

import ast
import struct
from pathlib import Path
from typing import Any

import numpy as np

from graft.errors import InputError
from graft.io.guards import malformed_is_input_error, open_zip, read_bytes, read_member

Array = np.ndarray[Any, Any]

MAGIC = b"\x93NUMPY"


def read_npy(path: str | Path) -> Array:
    """Read a .npy file of numbers.

    Raises:
        InputError: It is not one, is truncated, or holds pickled objects.
    """
    return _parse(read_bytes(path), Path(path).name, path)


def read_npz(path: str | Path) -> dict[str, Array]:
    """Read a .npz file of arrays of numbers or strings: name -> array.

    Raises:
        InputError: It is not one, a zip bomb, or one of its arrays cannot be read.
    """
    arrays = {}
    with open_zip(path) as archive:
        for member in archive.namelist():
            name = member.removesuffix(".npy")
            arrays[name] = _parse(read_member(archive, member, path=path), name, path)
    return arrays


def _parse(data: bytes, name: str, path: str | Path) -> Array:
    """Parse the .npy format (NEP 1)."""
    if data[:6] != MAGIC or len(data) < 12:
        raise InputError(f"array {name!r}: not in NumPy's format", path=path)
    long = data[6] >= 2
    (length,) = struct.unpack_from("<I" if long else "<H", data, 8)
    start = (12 if long else 10) + length
    if start > len(data):
        raise InputError(f"array {name!r}: truncated in its header", path=path)
    with malformed_is_input_error(path, f"array {name!r}"):
        try:
            header = ast.literal_eval(data[start - length : start].decode("latin-1"))
        except SyntaxError as error:
            raise ValueError(str(error)) from None
        kind, shape = np.dtype(header["descr"]), tuple(int(n) for n in header["shape"])
        if kind.hasobject:
            raise InputError(f"array {name!r}: holds pickled Python objects, which are not loaded")
        if min(shape, default=0) < 0:
            raise InputError(f"array {name!r}: negative shape {shape}")
        count = int(np.prod([int(n) for n in shape], dtype=object))
        if count * kind.itemsize != len(data) - start:
            raise InputError(
                f"array {name!r}: shape {shape} of {kind} needs {count * kind.itemsize} bytes, "
                f"{len(data) - start} are there"
            )
        flat = np.frombuffer(data, kind, count, start)
        return flat.reshape(shape, order="F" if header["fortran_order"] else "C")

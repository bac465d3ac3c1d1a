"""Read the tensors of a PyTorch checkpoint of 2018 to 2020 without PyTorch and without unpickling anything.

Such a file is five pickles (magic number, protocol, machine, the state dictionary, the order of the storages) and then
the storages' numbers. The pickles are only disassembled: of their instructions the few that spell out a dictionary of
tensors are followed here, names of classes and functions stay names, and any other instruction is an error. Nothing
that a file says is ever imported or called.
"""

from __future__ import annotations

import math
import pickletools
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from graft.errors import InputError

MAGIC = 0x1950A86A20F9469CFC6C
"""First number of such a file."""

DTYPES: dict[str, np.dtype[Any]] = {"torch FloatStorage": np.dtype("<f4"), "torch LongStorage": np.dtype("<i8")}
"""Kinds of storages that are read."""

REBUILD, DICTIONARY = "torch._utils _rebuild_tensor_v2", "collections OrderedDict"
"""What state dictionaries are spelled with."""

VALUES = ("BINUNICODE", "BININT", "BININT1", "BININT2", "LONG1", "NONE", "NEWTRUE", "NEWFALSE")
"""Instructions that state a value."""


@dataclass(frozen=True)
class _Name:
    """A class or a function, by name; it is never looked up."""

    text: str


@dataclass(frozen=True)
class _Tensor:
    """Which numbers of which storage a tensor is.

    Attributes:
        storage: Key of the storage.
        dtype: Of its numbers.
        offset: First number.
        shape: Of the tensor.
        strides: Numbers from one element to the next, along each axis.
    """

    storage: str
    dtype: np.dtype[Any]
    offset: int
    shape: tuple[int, ...]
    strides: tuple[int, ...]


def read_tensors(path: Path) -> dict[str, NDArray[Any]]:
    """Return the tensors of a state dictionary by name.

    Raises:
        InputError: The file cannot be read, is of another format, or says anything but a dictionary of tensors.
    """
    try:
        with path.open("rb") as file:
            magic, _, _, state, keys = (_spelled(file) for _ in range(5))
            if magic != MAGIC or not isinstance(state, dict) or not isinstance(keys, list):
                raise ValueError("expected a PyTorch state dictionary in the format before 1.6")
            tensors = {name: value for name, value in state.items() if isinstance(value, _Tensor)}
            dtypes = {tensor.storage: tensor.dtype for tensor in tensors.values()}
            storages = {key: _storage(file, dtypes[key]) for key in keys}
            return {name: _filled(name, tensor, storages) for name, tensor in tensors.items()}
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", path=path) from None
    except (ValueError, KeyError, IndexError, TypeError, AttributeError) as error:
        raise InputError(f"no readable checkpoint: {error}", path=path) from None


def _storage(file: BinaryIO, dtype: np.dtype[Any]) -> NDArray[Any]:
    count = int.from_bytes(file.read(8), "little", signed=True)
    if count < 0:
        raise ValueError(f"a storage of {count} numbers")
    data = file.read(count * dtype.itemsize)
    if len(data) < count * dtype.itemsize:
        raise ValueError("the file ends within a storage")
    return np.frombuffer(data, dtype)


def _filled(name: str, tensor: _Tensor, storages: dict[str, NDArray[Any]]) -> NDArray[Any]:
    """Return a tensor's numbers, copied; every index that it can reach is checked first."""
    numbers = storages[tensor.storage]
    ends = [(size - 1) * stride for size, stride in zip(tensor.shape, tensor.strides, strict=True)]
    first, last = tensor.offset + sum(min(e, 0) for e in ends), tensor.offset + sum(max(e, 0) for e in ends)
    if min(tensor.shape, default=1) < 1 or math.prod(tensor.shape) > len(numbers) or first < 0 or last >= len(numbers):
        raise ValueError(f"{name}: reaches beyond the {len(numbers)} numbers of its storage")
    index = np.full(tensor.shape, tensor.offset, np.int64)
    for axis, (size, stride) in enumerate(zip(tensor.shape, tensor.strides, strict=True)):
        steps = stride * np.arange(size, dtype=np.int64)
        index += steps.reshape([-1 if i == axis else 1 for i in range(len(tensor.shape))])
    return numbers[index]


def _spelled(file: BinaryIO) -> Any:
    """Follow one pickle's instructions and return the plain value that they spell."""
    stack: list[Any] = []
    marks: list[int] = []
    memo: dict[int, Any] = {}

    def since_mark() -> list[Any]:
        start = marks.pop()
        taken = stack[start:]
        del stack[start:]
        return taken

    for code, argument, _ in pickletools.genops(file):
        match code.name:
            case "PROTO":
                continue
            case name if name in VALUES:
                stack.append({"NONE": None, "NEWTRUE": True, "NEWFALSE": False}.get(name, argument))
            case "GLOBAL":
                stack.append(_Name(str(argument)))
            case "BINPUT" | "LONG_BINPUT":
                memo[int(argument or 0)] = stack[-1]
            case "BINGET" | "LONG_BINGET":
                stack.append(memo[int(argument or 0)])
            case "MARK":
                marks.append(len(stack))
            case "EMPTY_TUPLE":
                stack.append(())
            case "EMPTY_DICT":
                stack.append({})
            case "EMPTY_LIST":
                stack.append([])
            case "TUPLE":
                stack.append(tuple(since_mark()))
            case "TUPLE1":
                stack.append((stack.pop(),))
            case "TUPLE2":
                second = stack.pop()
                stack.append((stack.pop(), second))
            case "APPEND":
                value = stack.pop()
                stack[-1].append(value)
            case "APPENDS":
                values = since_mark()
                stack[-1].extend(values)
            case "SETITEM":
                value = stack.pop()
                _set(stack[-2], [stack.pop(), value])
            case "SETITEMS":
                pairs = since_mark()
                _set(stack[-1], pairs)
            case "REDUCE":
                arguments = stack.pop()
                stack.append(_made(stack.pop(), arguments))
            case "BINPERSID":
                pass  # the tuple that names a storage stands for it
            case "BUILD":
                stack.pop()  # attributes of the dictionary: versions of modules
            case "STOP":
                return stack.pop()
            case other:
                raise ValueError(f"instruction {other} does not spell a dictionary of tensors")
    raise ValueError("the file ends within a pickle")


def _set(dictionary: Any, pairs: list[Any]) -> None:
    if not isinstance(dictionary, dict):
        raise ValueError(f"expected a dictionary, got {type(dictionary).__name__}")
    dictionary.update(zip(pairs[::2], pairs[1::2], strict=True))


def _made(function: Any, arguments: Any) -> Any:
    """Return what one of the two functions that are known would make."""
    if function == _Name(DICTIONARY):
        return {}
    if function != _Name(REBUILD):
        raise ValueError(f"{function} makes no tensor")
    (_, kind, key, *_), offset, shape, strides, *_ = arguments
    if kind.text not in DTYPES:
        raise ValueError(f"expected tensors of {', '.join(DTYPES)}, got {kind.text}")
    return _Tensor(key, DTYPES[kind.text], offset, shape, strides)

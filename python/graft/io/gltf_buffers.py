"""glTF 2.0 containers and accessors: from bytes to arrays, believing no length that a header states."""

from __future__ import annotations

import base64
import binascii
import struct
from pathlib import Path
from typing import Any

import numpy as np

from graft.errors import InputError
from graft.io.guards import parse_json, read_bytes, resolve_uri
from graft.objects import Floats, Ints

MAGIC = b"glTF"
CHUNK_JSON, CHUNK_BIN = 0x4E4F534A, 0x004E4942
"""Chunk types of the GLB container (specification, section 4.4)."""

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""componentType -> numpy type."""

WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
"""Numbers per element of the accessor types that geometry uses."""

UNREADABLE_EXTENSIONS = ("KHR_draco_mesh_compression", "EXT_meshopt_compression")
"""Extensions without which the geometry cannot be read, where a file requires them."""


class GltfFile:
    """A glTF document with its buffers.

    Attributes:
        path: Of the file.
        document: The JSON object.
        buffers: Their bytes, as long as stated.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        data = read_bytes(path)
        binary: bytes | None = None
        text = data
        if path.suffix.lower() == ".glb" or data[:4] == MAGIC:
            text, binary = _chunks(data, path)
        self.document = parse_json(text, path=path, what="glTF document")
        required = self.document.get("extensionsRequired", [])
        for extension in UNREADABLE_EXTENSIONS:
            if extension in required:
                raise InputError(f"compressed with {extension}, which is not read: save it uncompressed", path=path)
        for image in self.document.get("images", []):
            uri = image.get("uri")
            if uri is not None and not uri.startswith("data:"):  # not opened, yet it must not point elsewhere
                resolve_uri(uri, root=path.parent, path=path)
        self.buffers = [self._buffer(i, b, binary) for i, b in enumerate(self.document.get("buffers", []))]

    def _buffer(self, index: int, buffer: dict[str, Any], binary: bytes | None) -> bytes:
        uri, stated = buffer.get("uri"), buffer["byteLength"]
        if uri is None:
            content = binary if index == 0 and binary is not None else b""
        elif uri.startswith("data:"):
            try:
                content = base64.b64decode(uri.partition(",")[2], validate=True)
            except (binascii.Error, ValueError) as error:
                raise InputError(f"buffer {index}: not base64: {error}", path=self.path) from None
        else:
            content = read_bytes(resolve_uri(uri, root=self.path.parent, path=self.path), what="buffer")
        if not isinstance(stated, int) or stated > len(content) or stated < 0:
            raise InputError(f"buffer {index}: {stated} bytes stated, {len(content)} there", path=self.path)
        return content[:stated]

    def item(self, kind: str, index: Any) -> dict[str, Any]:
        """Return element `index` of the document's array `kind`.

        Raises:
            InputError: There is none.
        """
        items = self.document.get(kind, [])
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(items):
            raise InputError(f"{kind} {index!r}: out of range, there are {len(items)}", path=self.path)
        found = items[index]
        if not isinstance(found, dict):
            raise InputError(f"{kind} {index}: expected an object, got {type(found).__name__}", path=self.path)
        return found

    def view(self, index: int) -> bytes:
        """Return the bytes of a buffer view."""
        view = self.item("bufferViews", index)
        buffer = view.get("buffer", 0)
        if not isinstance(buffer, int) or not 0 <= buffer < len(self.buffers):
            raise InputError(f"bufferView {index}: buffer {buffer!r} of {len(self.buffers)}", path=self.path)
        start, length = view.get("byteOffset", 0), view["byteLength"]
        if start < 0 or length < 0 or start + length > len(self.buffers[buffer]):
            raise InputError(
                f"bufferView {index}: bytes {start} to {start + length}, "
                f"buffer {buffer} has {len(self.buffers[buffer])}",
                path=self.path,
            )
        return self.buffers[buffer][start : start + length]

    def floats(self, index: int) -> Floats:
        """Return an accessor as (n, width) float64; normalised integers become fractions."""
        accessor = self.item("accessors", index)
        raw = self._accessor(index, accessor)
        values = raw.astype(np.float64)
        if accessor.get("normalized") and raw.dtype.kind in "iu":
            values = np.maximum(values / np.iinfo(raw.dtype).max, -1.0)
        return values

    def indices(self, index: int) -> Ints:
        """Return a scalar accessor as (n,) int64."""
        raw = self._accessor(index, self.item("accessors", index))
        if raw.dtype.kind == "f" or raw.shape[1] != 1:
            raise InputError(f"accessor {index}: expected integers for indices", path=self.path)
        return raw[:, 0].astype(np.int64)

    def _accessor(self, index: int, accessor: dict[str, Any]) -> np.ndarray[Any, Any]:
        kind, component, count = accessor.get("type"), accessor.get("componentType"), accessor.get("count")
        if kind not in WIDTHS or component not in COMPONENTS or not isinstance(count, int) or count < 0:
            raise InputError(f"accessor {index}: {count} of {kind} {component} is not geometry", path=self.path)
        sparse = accessor.get("sparse")
        if "bufferView" in accessor:
            view = self.item("bufferViews", accessor["bufferView"])
            values = self._strided(
                f"accessor {index}",
                accessor["bufferView"],
                accessor,
                component,
                WIDTHS[kind],
                count,
                view.get("byteStride"),
            )
        elif sparse and count <= max(map(len, self.buffers), default=0):
            values = np.zeros((count, WIDTHS[kind]), COMPONENTS[component])
        else:
            raise InputError(f"accessor {index}: {count} elements and no data", path=self.path)
        if sparse:
            n = sparse["count"]
            where = f"accessor {index} sparse"
            rows = self._strided(
                where,
                sparse["indices"]["bufferView"],
                sparse["indices"],
                sparse["indices"]["componentType"],
                1,
                n,
            )[:, 0].astype(np.int64)
            if len(rows) and (rows.min() < 0 or rows.max() >= count):
                raise InputError(f"{where}: row {int(rows.max())} of {count}", path=self.path)
            values = values.copy()
            values[rows] = self._strided(
                where, sparse["values"]["bufferView"], sparse["values"], component, WIDTHS[kind], n
            )
        return values

    def _strided(
        self,
        where: str,
        view: int,
        holder: dict[str, Any],
        component: int,
        width: int,
        count: int,
        stride: int | None = None,
    ) -> np.ndarray[Any, Any]:
        """Return (count, width) numbers of a view, after checking that it holds them."""
        data = self.view(view)
        kind = np.dtype(COMPONENTS[component])
        element = kind.itemsize * width
        step = stride or element
        offset = holder.get("byteOffset", 0)
        needed = offset + step * (count - 1) + element if count else offset
        if offset < 0 or step < element or needed > len(data):
            raise InputError(
                f"{where}: {count} elements need {needed} bytes, bufferView {view} has {len(data)}",
                path=self.path,
            )
        if count == 0:
            return np.zeros((0, width), kind)
        return np.ndarray((count, width), kind, data, offset, (step, kind.itemsize))


def _chunks(data: bytes, path: Path) -> tuple[bytes, bytes | None]:
    """Split a GLB into its JSON and its binary chunk."""
    if len(data) < 12 or data[:4] != MAGIC:
        raise InputError(f"expected a GLB file, which begins with glTF, got {data[:4]!r}", path=path)
    _, version, length = struct.unpack_from("<4sII", data)
    if version != 2:
        raise InputError(f"glTF version {version} is not read, version 2 is", path=path)
    if length != len(data):
        raise InputError(f"the header says {length} bytes, the file has {len(data)}", path=path)
    text: bytes | None = None
    binary: bytes | None = None
    offset = 12
    while offset + 8 <= length:
        size, kind = struct.unpack_from("<II", data, offset)
        offset += 8
        if offset + size > length:
            raise InputError(f"a chunk says {size} bytes, {length - offset} are left", path=path)
        if kind == CHUNK_JSON and text is None:
            text = data[offset : offset + size]
        elif kind == CHUNK_BIN and binary is None:
            binary = data[offset : offset + size]
        offset += size
    if text is None:
        raise InputError("no JSON chunk", path=path)
    return text, binary

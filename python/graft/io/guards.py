"""What stands between files from anywhere and the readers: checks of sizes, paths, XML, JSON, archives.

Nothing is allocated from a count that a header claims, no reference is followed out of the folder that the
user named, no entity is expanded, and nothing is unpickled.
"""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote, urlsplit

import numpy as np

from graft.errors import InputError

MAX_FILE_BYTES = 1 << 30
"""Largest file that is read: 1 GiB, some 20 million triangles of binary STL; larger ones are not household
objects."""

MAX_TEXT_BYTES = 64 << 20
"""Largest JSON or XML document that is parsed: 64 MiB, a hundred times the largest robot description we
know."""

MAX_ZIP_RATIO = 100
"""A zip archive may grow by this factor. Deflate's limit is 1032, which only bombs and constant arrays come
near."""

FREE_ZIP_BYTES = 64 << 20
"""An archive that unpacks to less than this is harmless whatever its ratio: constant label arrays stay
readable."""

_MALFORMED = (ValueError, TypeError, KeyError, IndexError, AttributeError, OverflowError, RecursionError)


def existing_file(path: str | Path, *, what: str = "file") -> Path:
    """Return `path` if it is a file that holds something.

    Raises:
        InputError: It does not exist, is a folder, or is empty.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"no such {what}", path=path)
    if not path.is_file():
        raise InputError(f"expected a {what}, got a folder or device", path=path)
    if path.stat().st_size == 0:
        raise InputError(f"the {what} is empty", path=path)
    return path


def read_bytes(path: str | Path, *, limit: int = MAX_FILE_BYTES, what: str = "file") -> bytes:
    """Return the content of a file that exists, is not empty and not larger than `limit` bytes.

    Raises:
        InputError: Otherwise, or when the system refuses to read it.
    """
    path = existing_file(path, what=what)
    size = path.stat().st_size
    if size > limit:
        raise InputError(f"the {what} has {size} bytes, more than the {limit} that are read", path=path)
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", path=path) from None


def read_text(path: str | Path, *, limit: int = MAX_FILE_BYTES, what: str = "file") -> str:
    """Return the text of a file; bytes that are not UTF-8 become replacement characters."""
    return read_bytes(path, limit=limit, what=what).decode("utf-8-sig", errors="replace")


def resolve_inside(reference: str, *, root: Path, base: Path | None = None, path: str | Path) -> Path:
    """Return where a file's reference leads, if that is inside the asset root.

    Backslashes count as slashes, as exporters on Windows write them. Symbolic links are followed before the
    check.

    Args:
        reference: A relative path as written in the file, not percent-encoded.
        root: The folder that must not be left.
        base: The folder that the reference is relative to; `root` by default.
        path: The file that holds the reference, for the message.

    Raises:
        InputError: It is absolute, has a scheme or a drive, or leads out of the root by `..` or a link.
    """
    cleaned = reference.strip().replace("\\", "/")
    if not cleaned or "\0" in cleaned:
        raise InputError(f"expected a path, got {reference!r}", path=path)
    if PurePosixPath(cleaned).is_absolute() or re.match(r"[A-Za-z][A-Za-z0-9+.-]*:", cleaned):
        raise InputError(f"reference {reference!r}: expected a relative path inside {root}", path=path)
    return contained((base or root) / cleaned, root=root, reference=reference, path=path)


def contained(candidate: Path, *, root: Path, reference: str | None = None, path: str | Path) -> Path:
    """Return `candidate` with links resolved, if that is inside `root`; see `resolve_inside`."""
    try:
        resolved = candidate.resolve()
        inside = resolved.is_relative_to(root.resolve())
    except (OSError, RuntimeError, ValueError) as error:  # a loop of links, a name too long
        raise InputError(f"reference {reference or str(candidate)!r}: {error}", path=path) from None
    if not inside:
        raise InputError(f"reference {reference or str(candidate)!r} leaves the folder {root}", path=path)
    return resolved


def resolve_uri(uri: str, *, root: Path, path: str | Path) -> Path:
    """Return where a percent-encoded relative URI (glTF) leads; see `resolve_inside`."""
    if urlsplit(uri).scheme:
        raise InputError(f"reference {uri[:80]!r}: expected a relative path inside {root}", path=path)
    return resolve_inside(unquote(uri), root=root, path=path)


def parse_json(text: str | bytes, *, path: str | Path, what: str = "document") -> dict[str, Any]:
    """Parse a JSON object.

    Raises:
        InputError: It is not JSON, not an object, or holds NaN or infinity; the message has the line.
    """
    if len(text) > MAX_TEXT_BYTES:
        raise InputError(f"the {what} has {len(text)} bytes, more than the {MAX_TEXT_BYTES} that are read", path=path)

    def refuse(constant: str) -> None:
        raise ValueError(f"{constant} is not a JSON number")

    try:
        document = json.loads(text, parse_constant=refuse)
    except json.JSONDecodeError as error:
        raise InputError(f"line {error.lineno}: not JSON: {error.msg}", path=path) from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"not JSON: {error}", path=path) from None
    if not isinstance(document, dict):
        raise InputError(f"expected a JSON object, got {type(document).__name__}", path=path)
    return document


def read_json(path: str | Path) -> dict[str, Any]:
    """Read a file that holds one JSON object; see `parse_json`."""
    return parse_json(read_bytes(path, limit=MAX_TEXT_BYTES), path=path)


def read_xml(path: str | Path) -> Any:
    """Parse an XML file and return its root element (lxml; `element.sourceline` is the line).

    Raises:
        InputError: It is not well-formed, or has a DOCTYPE, whose entities can grow without bound or read
            files.
    """
    return parse_xml(read_bytes(path, limit=MAX_TEXT_BYTES), path=path)


def parse_xml(data: bytes, *, path: str | Path) -> Any:
    """Parse XML text; see `read_xml`."""
    from lxml import etree

    doctype = data.find(b"<!DOCTYPE")
    if doctype >= 0:
        line = data.count(b"\n", 0, doctype) + 1
        raise InputError(f"line {line}: a DOCTYPE is refused, its entities are not needed here", path=path)
    parser = etree.XMLParser(resolve_entities=False, load_dtd=False, no_network=True, huge_tree=False)
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        raise InputError(f"line {error.lineno}: not well-formed XML: {error.msg}", path=path) from None
    except ValueError as error:
        raise InputError(f"not well-formed XML: {error}", path=path) from None
    if root.getroottree().docinfo.doctype:  # in another encoding than the search above saw
        raise InputError("a DOCTYPE is refused, its entities are not needed here", path=path)
    return root


def open_zip(path: str | Path) -> zipfile.ZipFile:
    """Open a zip archive whose members together do not unpack to more than is safe.

    Raises:
        InputError: It is no archive, or a bomb.
    """
    path = existing_file(path)
    try:
        archive = zipfile.ZipFile(path)
    except (zipfile.BadZipFile, OSError, NotImplementedError, *_MALFORMED) as error:
        raise InputError(f"not a zip archive, or a truncated one: {error}", path=path) from None
    unpacked = sum(member.file_size for member in archive.infolist())
    limit = min(max(FREE_ZIP_BYTES, MAX_ZIP_RATIO * path.stat().st_size), MAX_FILE_BYTES)
    if unpacked > limit:
        archive.close()
        raise InputError(
            f"the archive of {path.stat().st_size} bytes unpacks to {unpacked}, more than is safe ({limit})",
            path=path,
        )
    return archive


def read_member(archive: zipfile.ZipFile, name: str, *, path: str | Path) -> bytes:
    """Return a member's content, stopping at the size that the archive's directory states."""
    import zlib

    size = archive.getinfo(name).file_size
    try:
        with archive.open(name) as stream:
            data = stream.read(size + 1)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError, NotImplementedError) as error:
        raise InputError(f"member {name!r} cannot be unpacked: {error}", path=path) from None
    if len(data) != size:
        raise InputError(f"member {name!r}: expected {size} bytes, got {len(data)}", path=path)
    return data


@contextmanager
def malformed_is_input_error(path: str | Path, what: str) -> Iterator[None]:
    """Turn what a parser raises on nonsense that it did not expect into an `InputError` naming the file."""
    try:
        # What overflows becomes infinite, and is dropped with the other corners that are not finite.
        with np.errstate(over="ignore", invalid="ignore"):
            yield
    except InputError as error:
        if error.path is not None:
            raise
        raise InputError(str(error), path=path) from None
    except _MALFORMED as error:
        raise InputError(f"malformed {what}: {type(error).__name__}: {error}", path=path) from None

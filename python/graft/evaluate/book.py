"""The file that keeps an evaluation's rows, whatever they are.

The rows of a query are one line of the file; the first line tells what the rows were made with.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Sequence
from dataclasses import Field, asdict, dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, ClassVar, Generic, Protocol, TypeVar

import graft
from graft.errors import InputError

ROWS = "rows.jsonl"
"""Name of the file of rows within the output folder."""


class QueryRow(Protocol):
    """A dataclass of plain values that says which query it belongs to."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @property
    def query(self) -> str:
        """Key of the query."""
        ...


R = TypeVar("R", bound=QueryRow)


def digest(*pieces: bytes) -> str:
    """Return sixteen hexadecimal digits that tell one sequence of bytes from another."""
    whole = hashlib.sha256()
    for piece in pieces:
        whole.update(piece)
    return whole.hexdigest()[:16]


@cache
def code_fingerprint() -> str:
    """Return a digest of the package's Python files and its compiled core: other code makes other rows."""
    root = Path(graft.__file__).parent
    files = sorted(path for path in root.rglob("*") if path.suffix in (".py", ".so", ".pyd"))
    return digest(*(path.read_bytes() for path in files))


@dataclass(eq=False)
class Book(Generic[R]):
    """The file of rows: a header line, then one line per query.

    Attributes:
        path: Of the file.
        done: Rows that it has, by query.
    """

    path: Path
    done: dict[str, list[R]] = field(default_factory=dict)

    @classmethod
    def open(cls, path: Path, header: dict[str, Any], read: Callable[[dict[str, Any]], R]) -> Book[R]:
        """Read what is there, drop a last line that was cut off, or begin a new file.

        Args:
            path: Of the file.
            header: What rows depend on.
            read: Makes a row of what a line tells; raises TypeError or KeyError where it cannot.

        Raises:
            InputError: The rows there were made with something else, or a line is none.
        """
        book: Book[R] = cls(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        whole = _whole_lines(path)
        if not whole:
            path.write_bytes(json.dumps(header).encode() + b"\n")
            return book
        found = _parsed(path, 1, whole[0])
        if found != header:
            other = next((key for key in header if found.get(key) != header[key]), "format")
            raise InputError(f"rows made with another {other}; choose another --out or remove the file", path=path)
        for number, line in enumerate(whole[1:], start=2):
            try:
                rows = [read(document) for document in _parsed(path, number, line)["rows"]]
                book.done[rows[0].query] = rows
            except (TypeError, KeyError, IndexError) as error:
                raise InputError(f"line {number}: not the rows of a query ({error})", path=path) from None
        os.truncate(path, sum(len(line) + 1 for line in whole))
        return book

    def write(self, rows: Sequence[R]) -> None:
        """Add the rows of one query: one write of one line."""
        line = json.dumps({"rows": [asdict(row) for row in rows]}, allow_nan=False).encode() + b"\n"
        with self.path.open("ab") as file:
            file.write(line)


def _whole_lines(path: Path) -> list[bytes]:
    """Return the lines of a file that end in a newline; none when there is no file."""
    return path.read_bytes().split(b"\n")[:-1] if path.exists() else []


def _parsed(path: Path, number: int, line: bytes) -> dict[str, Any]:
    try:
        document = json.loads(line)
    except ValueError as error:
        raise InputError(f"line {number}: expected JSON, got {line[:40]!r} ({error})", path=path) from None
    if not isinstance(document, dict) or (number > 1 and "rows" not in document):
        raise InputError(f"line {number}: expected the rows of a query, got {line[:40]!r}", path=path)
    return document

"""Errors that a user can act on."""

from __future__ import annotations

from pathlib import Path


def printable(text: str) -> str:
    """Return text whose line breaks, control characters and undecodable bytes are spelled out."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


class GraftError(Exception):
    """Base of the errors that graft raises on purpose."""


class InputError(GraftError, ValueError):
    """A file or an argument that cannot be used.

    The message is one line: the file (or argument), the culprit in it, what was expected.
    The command line prints it without a traceback and exits with 3.
    """

    def __init__(self, message: str, *, path: str | Path | None = None) -> None:
        self.path = None if path is None else Path(path)
        text = printable(" ".join(message.split()))
        super().__init__(text if path is None else f"{printable(str(path))}: {text}")


class MissingExtraError(GraftError, ImportError):
    """An optional dependency that a call needs is not installed."""

    def __init__(self, what: str, *, package: str, extra: str) -> None:
        super().__init__(f"{what} needs {package}: pip install 'graft-robotics[{extra}]'")


class InputWarning(UserWarning):
    """Something in an input was dropped, repaired or assumed; the message names the file and the culprit."""

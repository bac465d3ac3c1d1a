"""Tables of numbers in text files, as OFF, ASCII PLY and point clouds have them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graft.errors import InputError
from graft.objects import Floats


def number_rows(lines: Sequence[str], *, first_line: int | Sequence[int], least: int = 1) -> Floats:
    """Parse lines of equally many numbers.

    Args:
        lines: Numbers separated by white space or commas.
        first_line: Line number of `lines[0]` in the file, or the number of every line; for the message.
        least: Columns there must be at least.

    Returns:
        (rows, columns) float64; nan and inf are numbers here.

    Raises:
        InputError: Naming the first line that has another number of columns or holds something else.
    """

    def numbered(row: int) -> int:
        return first_line + row if isinstance(first_line, int) else first_line[row]

    rows = [line.replace(",", " ").split() for line in lines]
    columns = len(rows[0]) if rows else least
    if columns < least:
        raise InputError(f"line {numbered(0)}: expected at least {least} numbers, got {columns}")
    for index, row in enumerate(rows):
        if len(row) != columns:
            raise InputError(f"line {numbered(index)}: expected {columns} numbers, got {len(row)}")
    try:
        return np.array(rows, np.float64).reshape(len(rows), columns)
    except ValueError:
        for index, row in enumerate(rows):
            for word in row:
                try:
                    float(word)
                except ValueError:
                    raise InputError(f"line {numbered(index)}: expected a number, got {word[:40]!r}") from None
        raise


def ragged_rows(lines: Sequence[str], *, first_line: int | Sequence[int]) -> list[list[int]]:
    """Parse lines `n i1 .. in [more]` into lists of n integers; what follows them is not read.

    Raises:
        InputError: Naming the first line that is shorter than it says or holds something else.
    """
    found = []
    for row, line in enumerate(lines):
        words = line.split()
        number = first_line + row if isinstance(first_line, int) else first_line[row]
        try:
            count = int(words[0]) if words else 0
            indices = [int(word) for word in words[1 : count + 1]] if count > 0 else []
        except ValueError:
            raise InputError(f"line {number}: expected integers, got {line.strip()[:60]!r}") from None
        if count < 0 or len(indices) != count:
            raise InputError(f"line {number}: says {count} corners, has {len(words) - 1 if words else 0}")
        found.append(indices)
    return found

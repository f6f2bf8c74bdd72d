"""Lines and tables of numbers of the text files that engines write, with the place of every fault."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from typing import BinaryIO

import numpy as np

from workflow.data.files import PathLike, open_plain
from workflow.data.frame import Floats, Ints
from workflow.errors import ArchiveError

ROWS = 65536  # lines of a table that are in memory as text at one time
PLAIN = bytes(range(32, 127)) + b"\t\n\v\f\r"
# NumPy reads bytes as Latin-1, where some beyond ASCII are blanks: a text in an unused column would shift the others
AS_ASCII = bytes(byte if byte in PLAIN else ord("?") for byte in range(256))


def shown(text: bytes) -> str:
    """The beginning of ``text``, fit for a terminal."""
    return "".join(c if c.isprintable() else "?" for c in text[:60].decode("utf-8", "replace"))


def numbers_in(lines: list[bytes], columns: Sequence[int] | None = None) -> Floats:
    """Lines of numbers as a table, of ``columns`` alone if they are given; an empty one if they are none."""
    if not lines[0].strip():  # of lines without content NumPy warns
        return np.empty((0, 0))
    try:
        return np.loadtxt(lines, comments=None, ndmin=2, usecols=columns)
    except ValueError:
        return np.empty((0, 0))


def numeric(line: bytes, columns: int, finite: bool) -> bool:
    """Whether a line is ``columns`` numbers."""
    try:
        values = [float(word) for word in line.split()]
    except ValueError:
        return False
    return len(values) == columns and (not finite or bool(np.isfinite(values).all()))


def read_columns(path: PathLike, file: BinaryIO, line: int, rows: int, names: Sequence[str], wanted: Sequence[int]) -> Floats:
    """Columns ``wanted`` of a table of ``rows`` lines, (rows, len(wanted)) float64; what stands in others does not matter.

    ``file`` stands before the first row, ``line`` is the number of the line before it.  Raises ArchiveError with line
    and column for a row of another length, and for what is no finite number.
    """
    table = np.empty((rows, len(wanted)))
    for done in range(0, rows, ROWS):
        lines = list(islice(file, min(ROWS, rows - done)))
        if b"".join(lines).translate(None, PLAIN):
            lines = [row.translate(AS_ASCII) for row in lines]
        part = numbers_in(lines, wanted) if wanted else np.empty((len(lines), 0))
        whole = all(len(row.split()) == len(names) for row in lines)
        if part.shape != (len(lines), len(wanted)) or not whole or not np.isfinite(part).all():
            raise _fault(path, lines, line + done + 1, names, wanted)
        table[done : done + len(lines)] = part
    return table


def _fault(path: PathLike, lines: list[bytes], first: int, names: Sequence[str], wanted: Sequence[int]) -> ArchiveError:
    """What is wrong with the first bad line."""
    for number, row in enumerate(lines, first):
        words = row.split()
        if len(words) != len(names):
            return ArchiveError(f"{path}, line {number}: {len(words)} words, expected {len(names)} ({' '.join(names)}); "
                                "the line is damaged, or a text in it has blanks")  # fmt: skip
        for column in wanted:
            if not numeric(words[column], 1, finite=True):
                return ArchiveError(
                    f"{path}, line {number}, column {column + 1} ({names[column]}): found '{shown(words[column])}', "
                    "expected a finite number; correct it, or leave the column out"
                )
    return ArchiveError(f"{path}, line {first}: the table cannot be read; the file is damaged there, restore it")


def whole_numbers(values: Floats, what: str) -> Ints:
    """``values`` as whole numbers; ArchiveError (named by ``what``) if one is none."""
    fine = (np.abs(values) < 2.0**53) & (values == np.floor(values))
    if not fine.all():
        raise ArchiveError(f"{what} {values[~fine][0]:g} is no whole number; the file is damaged, restore it or run again")
    return values.astype(np.int64)


def open_output(path: PathLike) -> BinaryIO:
    """A file that the engine writes.  Raises ArchiveError if it cannot be read."""
    try:
        return open_plain(path)
    except OSError as error:
        raise ArchiveError(f"cannot read '{path}': {error.strerror}; check the path and that the run started") from None

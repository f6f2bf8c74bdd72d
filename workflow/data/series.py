"""The time series that a deck writes, one row of numbers per output."""

from __future__ import annotations

import os

import numpy as np

from workflow.data.files import PathLike
from workflow.data.frame import Floats
from workflow.data.text import numbers_in, numeric, open_output, whole_numbers
from workflow.errors import ArchiveError

CLOCK = ("step", "time", "stage")  # columns that must be there, and be numbers in every row


def read_series(path: PathLike) -> dict[str, Floats]:
    """Time series of ``fix print``: name -> (rows,) float64, in column order.

    First line ``# step time ... stage ...``, then one row of numbers per output; a repeated title line (a resumed run)
    is skipped, an unfinished last line dropped.  ``nan`` is allowed, for a quantity not defined yet.
    """
    with open_output(path) as file:
        lines = [line for line in file if line.endswith(b"\n")]
    title = lines[0].decode("ascii", "replace") if lines else ""
    names = title.lstrip("# ").split()
    if not title.startswith("#") or names[:2] != ["step", "time"] or "stage" not in names or len(set(names)) < len(names):
        raise ArchiveError(f"{path}, line 1: found '{title.strip()[:60]}', expected '# step time ... stage ...'; "
                           "correct the fix print command of the deck")  # fmt: skip
    rows = [(number, line) for number, line in enumerate(lines[1:], 2) if line != lines[0]]
    table = numbers_in([line for _, line in rows]) if rows else np.empty((0, len(names)))
    back = np.flatnonzero(np.diff(table[:, 0]) < 0) + 1 if table.shape == (len(rows), len(names)) else [None]
    if len(back):
        bad = (n for n, line in rows if not numeric(line, len(names), finite=False))
        number = next(bad, 2) if back[0] is None else rows[back[0]][0]
        raise ArchiveError(f"{path}, line {number}: expected {len(names)} numbers ({' '.join(names)}) and "
                           "increasing steps; the file is damaged; restore it or run again")  # fmt: skip
    for name in CLOCK:
        column = table[:, names.index(name)]
        if not np.isfinite(column).all():
            raise ArchiveError(f"{path}: '{name}' is not a number in every row; the file is damaged; restore it or run again")
    for name in ("step", "stage"):
        whole_numbers(table[:, names.index(name)], f"{path}: {name}")
    new = np.diff(table[:, 0], prepend=-1.0) > 0  # a stage that ends on a row repeats it as the first of the next
    return {name: table[new, k] for k, name in enumerate(names)}


def read_last_row(path: PathLike) -> dict[str, Floats]:
    """The last complete row of a time series, from its first line and its end alone; {} before the first row."""
    with open_output(path) as file:
        names = file.readline().decode("ascii", "replace").lstrip("# ").split()
        start = file.tell()
        end = file.seek(0, os.SEEK_END)
        file.seek(max(end - 16_384, start))
        lines = file.read().split(b"\n")[:-1]
    for line in reversed(lines):
        if numeric(line, len(names), finite=False):
            return {name: np.array([float(word)]) for name, word in zip(names, line.split(), strict=True)}
    return {}

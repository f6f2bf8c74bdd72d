"""Text dumps of LAMMPS, LIGGGHTS and what writes like them: where each snapshot is, and its columns.

A file is looked through once, which finds every snapshot; tables are then read where and when they are wanted, of the
columns that are wanted.  What follows the last whole snapshot is left out, and said.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import BinaryIO

import numpy as np

from workflow.archive.formats import DUMP, HEAD, misfit, unpacked
from workflow.data.files import PathLike
from workflow.data.frame import Floats
from workflow.data.text import shown
from workflow.errors import ArchiveError

MOST_DIGITS = 18  # of a whole number that fits 64 bits
AXES = "xyz"
FLAT = 1e-12  # a tilt below this share of the box is none


@dataclass(frozen=True)
class Snapshot:
    """Where one snapshot is and what its head says.

    ``time``: NaN where it is not given; ``units``: "" likewise.  ``bounds`` (3, 2): lower and upper faces; ``flags``: of
    the faces, "" in old headers.  ``label``: ATOMS, ENTRIES or another word for the rows.  ``columns``: as the file names
    them, "1", "2", ... where it names none.  ``line`` and ``offset``: number of the line with the names, place [byte] of
    the first row.
    """

    path: PathLike
    step: int
    time: float
    units: str
    bounds: Floats
    flags: str
    label: str
    rows: int
    columns: tuple[str, ...]
    line: int
    offset: int

    @property
    def where(self) -> str:
        """File and line, for messages."""
        return f"{self.path}, line {self.line}"

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Of the axes x and y; a header without flags is older than boxes that are not."""
        faces = [face == "pp" for face in self.flags.split()] or [True, True]
        return faces[0], faces[1]


class _Cut(Exception):
    """The file ends, or the next snapshot begins, inside a snapshot."""


class _Reader:
    """Lines of a file with their numbers and bytes."""

    def __init__(self, path: PathLike, file: BinaryIO) -> None:
        self.path, self.file, self.number, self.offset = path, file, 0, 0
        self.kept: bytes | None = None  # a line that was read too early

    def line(self) -> bytes:
        """The next line; b"" at the end.  Raises _Cut for a line without its end, which may lack digits."""
        line = self.kept if self.kept is not None else self.file.readline()
        self.kept = None
        if line and not line.endswith(b"\n"):
            raise _Cut
        self.number += bool(line)
        self.offset += len(line)
        return line

    def value(self) -> bytes:
        """The line after a title."""
        line = self.line()
        if line.startswith(DUMP):
            self.put_back(line)
        if not line or self.kept is not None:
            raise _Cut
        return line.strip()

    def put_back(self, line: bytes) -> None:
        self.kept, self.number, self.offset = line, self.number - 1, self.offset - len(line)

    def fault(self, message: str) -> ArchiveError:
        return ArchiveError(f"{self.path}, line {self.number}: {message}")

    def integer(self, what: str) -> int:
        text = self.value()
        if not text.isdigit() or len(text) > MOST_DIGITS:
            raise self.fault(f"found '{shown(text)}', expected a whole number ({what}); the file is damaged there")
        return int(text)

    def numbers(self, count: int, what: str) -> list[float]:
        text = self.value()
        try:
            found = [float(word) for word in text.split()]
        except ValueError:
            found = []
        if len(found) != count or not np.isfinite(found).all():
            raise self.fault(f"found '{shown(text)}', expected {count} numbers ({what}); the file is damaged there")
        return found


def _head(lines: _Reader, units: str) -> Snapshot | None:
    """The head of the next snapshot, up to the names of its columns; None at the end of the file."""
    seen: set[str] = set()
    step = rows = 0
    time, label, flags, bounds = float("nan"), "", "", np.empty((0, 2))
    while True:
        line = lines.line()
        if not line.strip() and not seen:
            if not line:
                return None
            continue
        if not line.startswith(DUMP):
            raise (
                _Cut
                if not line
                else lines.fault(
                    f"found '{shown(line.strip())}', expected a line that begins with 'ITEM:'; the file is damaged there"
                )
            )
        title = line[len(DUMP) :].decode("utf-8", "replace").strip()
        kind = " ".join(title.split()[:2]) if title.startswith(("NUMBER OF", "BOX BOUNDS")) else title
        if kind in seen or ("TIMESTEP" in seen and kind in ("UNITS", "TIME")):
            lines.put_back(line)
            raise _Cut
        seen.add(kind)
        if kind == "UNITS":
            units = lines.value().decode("ascii", "replace")
        elif kind == "LABEL":
            lines.value()
        elif kind == "TIME":
            (time,) = lines.numbers(1, "the time")
        elif kind == "TIMESTEP":
            step = lines.integer("the step")
        elif kind == "NUMBER OF":
            label = title[len("NUMBER OF ") :]
            rows = lines.integer("the number of rows")
        elif kind == "BOX BOUNDS":
            flags, bounds = _box(lines, title.split()[2:])
        elif label and f"{title} ".startswith(f"{label} ") and {"TIMESTEP", "BOX BOUNDS"} <= seen:
            columns = tuple(title[len(label) :].split())
            return Snapshot(lines.path, step, time, units, bounds, flags, label, rows, columns, lines.number, lines.offset)
        else:
            raise lines.fault(f"'{shown(line.strip())}' is not expected here in a dump of LAMMPS; the file is damaged "
                              "there, or is of another kind")  # fmt: skip


def _box(lines: _Reader, words: list[str]) -> tuple[str, Floats]:
    """Flags and faces; a tilted box is refused, one that could tilt and does not is a rectangle."""
    if words[:2] == ["abc", "origin"]:
        raise lines.fault("the box is given by three vectors (general triclinic), which is not supported; write the dump "
                          "with 'dump_modify ... triclinic/general no' from a rectangular box")  # fmt: skip
    tilts = words[:3] == ["xy", "xz", "yz"]
    flags = words[3:] if tilts else words
    if flags and (len(flags) != 3 or any(len(face) != 2 or not set(face) <= set("pfsm") for face in flags)):
        raise lines.fault(f"the faces of the box are '{' '.join(words)}', expected 'pp pp pp' or such")
    rows = np.array([lines.numbers(3 if tilts else 2, "faces of the box") for _ in AXES])
    if tilts and (np.abs(rows[:, 2]) > FLAT * np.abs(rows[:2, 1] - rows[:2, 0]).max()).any():
        raise lines.fault(f"the box is tilted (xy, xz, yz = {', '.join(f'{tilt:g}' for tilt in rows[:, 2])}), which is not "
                          "supported; give a rectangular box")  # fmt: skip
    if not (rows[:2, 1] > rows[:2, 0]).all():
        raise lines.fault(f"the box ends at {rows[0, 1]:g}, {rows[1, 1]:g} and begins at {rows[0, 0]:g}, {rows[1, 0]:g}; a "
                          "side must be longer than 0")  # fmt: skip
    return " ".join(flags), rows[:, :2].copy()


def _pass_rows(lines: _Reader, head: Snapshot) -> Snapshot:
    """``head`` with its columns counted if they have no names; the rows are passed."""
    for row in range(head.rows):
        line = lines.line()
        if not line:
            raise _Cut
        if line.startswith(DUMP):
            lines.put_back(line)
            raise _Cut
        if not row and not head.columns:
            head = replace(head, columns=tuple(str(k) for k in range(1, len(line.split()) + 1)))
    return head


def snapshots_in(path: PathLike) -> tuple[list[Snapshot], list[str]]:
    """All whole snapshots of a file in the order of writing, and notes about those that are cut off.

    Raises InputError for a file of another kind, ArchiveError for damage.
    """
    found: list[Snapshot] = []
    notes: list[str] = []
    file, packed = unpacked(path)
    with file:
        try:
            head = file.peek(HEAD)[:HEAD]  # type: ignore[attr-defined]
            if not head.lstrip().startswith(DUMP):
                raise misfit(path, head)
            lines = _Reader(path, file)
            while True:
                begin = lines.number + 1
                try:
                    block = _head(lines, found[-1].units if found else "")
                    if block is None:
                        break
                    found.append(_pass_rows(lines, block))
                except _Cut:
                    notes.append(
                        f"{path}: the snapshot that begins at line {begin} is cut off in line {lines.number + 1} and left out"
                    )
                    if lines.kept is None:
                        break
        except OSError as error:
            notes.append(f"{path}: its {packed} data end too early or are damaged ({error}); what follows step "
                         f"{found[-1].step if found else 'none'} is left out")  # fmt: skip
    return found, notes

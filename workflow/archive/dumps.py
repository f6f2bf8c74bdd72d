"""Readers of the text files a deck writes in one run directory: grains dump, contacts dump, time series.

Dumps are streamed, one frame in memory at a time.  A run may be killed while it writes: what follows the last complete
frame is ignored.  Damage before that point is an error that names file and line.  Contents are only ever parsed as
numbers.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import BinaryIO

import numpy as np

from workflow.data import text
from workflow.data.files import PathLike
from workflow.data.frame import LARGEST, Contacts, Floats, Frame, Ints, Tracks, sound
from workflow.data.text import numbers_in, numeric, open_output, whole_numbers
from workflow.errors import ArchiveError

TRACK_COLUMNS = ("id", "x", "y")
GRAIN_COLUMNS = ("id", "diameter", "mass", "x", "y", "vx", "vy", "omegaz", "fx", "fy", "tqz")
MOST_DIGITS = 18  # of a whole number that fits 64 bits
# of a contact dump; the decks up to version 0.2 left them numbered, c_pairs[1] to c_pairs[15]
CONTACT_COLUMNS = ("id_i", "id_j", "state", "bx", "by", "gap", "elastic", "viscous", "attraction", "tangential", "moment", "du",
                   "dtheta", "sliding", "rolling")  # fmt: skip
TURNING = (3, 4, 10, 12)  # columns of a contact that change their sign when i and j are exchanged


@dataclass(frozen=True)
class Block:
    """One snapshot of a LAMMPS text dump.

    ``bounds`` (3, 2): lower and upper box faces.  ``columns``: names after ``ITEM: ATOMS`` or ``ITEM: ENTRIES``.
    ``table`` (rows, len(columns)) float64.  ``line``: number of the line that holds the column names.
    """

    step: int
    time: float
    bounds: Floats
    columns: tuple[str, ...]
    table: Floats
    line: int
    periodic: tuple[bool, bool] = (True, True)

    @property
    def named(self) -> dict[str, Floats]:
        """{column: (rows,)}."""
        return dict(zip(self.columns, self.table.T, strict=True))


class _Truncated(Exception):
    """The file ended inside a frame."""


class _Lines:
    """Lines of a file with their numbers; a line without its newline was cut off while it was written."""

    def __init__(self, path: PathLike, file: BinaryIO) -> None:
        self.path, self.file, self.number = path, file, 0

    def take(self, count: int) -> list[bytes]:
        lines = list(islice(self.file, count))
        if len(lines) < count or (lines and not lines[-1].endswith(b"\n")):
            raise _Truncated
        self.number += count
        return lines

    def header(self, name: str) -> str:
        """The rest of an ``ITEM: <name>`` line."""
        line = self.take(1)[0].decode("ascii", "replace").rstrip()
        item = f"ITEM: {name}"
        if not f"{line} ".startswith(f"{item} "):
            hint = " (dump_modify ... time yes)" if name == "TIME" else ""
            raise self.fault(f"found '{line[:60]}', expected '{item}'{hint}")
        return line[len(item) :].strip()

    def numbers(self, rows: int, columns: int, what: str) -> Floats:
        """``rows`` lines of ``columns`` finite numbers each."""
        table = np.empty((rows, columns))
        for done in range(0, rows, text.ROWS):
            first = self.number + 1
            lines = self.take(min(text.ROWS, rows - done))
            part = numbers_in(lines)
            if part.shape != (len(lines), columns) or not np.isfinite(part).all():
                bad = (k for k, line in enumerate(lines) if not numeric(line, columns, finite=True))
                self.number = first + next(bad, 0)
                raise self.fault(f"expected {columns} finite numbers per line ({what})")
            table[done : done + len(lines)] = part
        return table

    def integer(self, what: str) -> int:
        """A line with one integer >= 0 of 64 bits; int() rather than float64 so that a step beyond 2**53 stays exact."""
        line = self.take(1)[0]
        if not line.strip().isdigit() or len(line.strip()) > MOST_DIGITS:
            raise self.fault(f"found '{line.decode('ascii', 'replace').strip()[:60]}', expected one integer ({what})")
        return int(line)

    def fault(self, message: str) -> ArchiveError:
        return ArchiveError(
            f"{self.path}, line {self.number}: {message}; the file is damaged or is no LAMMPS dump of this package; "
            "restore it or run again"
        )


def _block(lines: _Lines, kind: str) -> Block:
    """The next snapshot; ``kind`` is ATOMS or ENTRIES."""
    lines.header("TIME")
    time = float(lines.numbers(1, 1, "the time")[0, 0])
    lines.header("TIMESTEP")
    step = lines.integer("the time step")
    lines.header(f"NUMBER OF {kind}")
    rows = lines.integer("the number of rows")
    faces = lines.header("BOX BOUNDS").split()
    bounds = lines.numbers(3, 2, "lower and upper box face")
    columns = tuple(lines.header(kind).split())
    line = lines.number
    periodic = (faces[:1] in ([], ["pp"]), faces[1:2] in ([], ["pp"]))
    return Block(step, time, bounds, columns, lines.numbers(rows, len(columns), " ".join(columns)), line, periodic)


def read_blocks(path: PathLike, kind: str) -> Iterator[Block]:
    """Snapshots of a LAMMPS ``dump custom`` (kind ATOMS) or ``dump local`` (kind ENTRIES) of a run, steps increasing.

    A step written twice (the end of one stage is the start of the next) is given once, as first written.  Raises
    ArchiveError for a missing file, damage before the last frame, or steps that go back.
    """
    last = -1
    with open_output(path) as file:
        lines = _Lines(path, file)
        while True:
            try:
                block = _block(lines, kind)
            except _Truncated:
                return
            if block.step < last:
                lines.number = block.line
                raise lines.fault(f"found step {block.step} after step {last}, expected increasing steps")
            if block.step > last:
                yield block
            last = block.step


def read_frames(
    grains: PathLike,
    contacts: PathLike,
    *,
    series: Mapping[str, Floats] | None = None,
    stages: Mapping[int, str] | None = None,
) -> Iterator[Frame]:
    """Frames of a run: the steps present in both dumps, in order; one at a time.

    ``grains``: columns `GRAIN_COLUMNS` in any order, others are ignored; sorted by id.  ``contacts``: `CONTACT_COLUMNS`
    by name, or by position where the deck left them numbered; rows of state 0 are dropped,
    the others brought to i < j (which flips branch, moment
    and rotation, while T and du keep their sign) and sorted by (i, j).  ``series`` (see `read_series`) gives each frame
    the stage number of the last row at or before its step, and ``stages`` names the numbers (default: the number).
    """
    names = dict(stages or {})
    partner = read_blocks(contacts, "ENTRIES")
    table = next(partner, None)
    for block in read_blocks(grains, "ATOMS"):
        while table is not None and table.step < block.step:
            table = next(partner, None)
        if table is None:
            return
        if table.step == block.step:
            number = _stage_number(series, block.step)
            yield _frame(block, table, names.get(number, str(number)), grains, contacts)


def read_tracks(path: PathLike) -> Tracks:
    """Positions of a ``dump custom`` with the columns id x y at many times, grains that come and go included."""
    blocks = list(read_blocks(path, "ATOMS"))
    for block in blocks:
        if not (np.abs(block.table) < LARGEST).all():
            raise ArchiveError(f"{path}, step {block.step}: a position is no place in a box; the file is damaged, run again")
        if block.columns != TRACK_COLUMNS:
            raise ArchiveError(f"{path}, line {block.line}: columns are {' '.join(block.columns)}, expected "
                               f"{' '.join(TRACK_COLUMNS)}; correct the dump command of the deck")  # fmt: skip
    named = [whole_numbers(block.table[:, 0], f"{path}, step {block.step}: grain id") for block in blocks]
    ids = np.unique(np.concatenate(named or [np.empty(0, dtype=np.int64)]))
    position = np.full((len(blocks), len(ids), 2), np.nan)
    for k, block in enumerate(blocks):
        position[k, np.searchsorted(ids, named[k])] = block.table[:, 1:3]
    return Tracks(np.array([block.time for block in blocks]), ids, position)


def _stage_number(series: Mapping[str, Floats] | None, step: int) -> int:
    """Stage in force at ``step``; of rows at the same step the first counts: the frame ends the earlier stage."""
    if not series or not len(series["step"]):
        return 0
    row = int(np.searchsorted(series["step"], step, "left"))
    if row == len(series["step"]) or series["step"][row] != step:
        row = max(row - 1, 0)
    return int(series["stage"][row])


def _frame(block: Block, table: Block, stage: str, grains: PathLike, contacts: PathLike) -> Frame:
    missing = [name for name in GRAIN_COLUMNS if name not in block.columns]
    if missing:
        raise ArchiveError(
            f"{grains}, line {block.line}: column {', '.join(missing)} missing; "
            f"expected at least {' '.join(GRAIN_COLUMNS)}; correct the dump command of the deck"
        )
    place = {name: block.columns.index(name) for name in GRAIN_COLUMNS}
    rows = block.table[np.argsort(block.table[:, place["id"]], kind="stable")]

    def pick(*names: str) -> Floats:
        return np.ascontiguousarray(rows[:, [place[name] for name in names]].squeeze(-1 if len(names) == 1 else ()))

    ids = whole_numbers(pick("id"), f"{grains}, line {block.line}: grain id")
    if len(ids) > 1 and (np.diff(ids) <= 0).any():
        twice = int(ids[1:][np.diff(ids) <= 0][0])
        raise ArchiveError(
            f"{grains}, line {block.line}: grain id {twice} occurs twice at step {block.step}; "
            "each grain has one row; the file is damaged, run again"
        )
    frame = Frame(
        step=block.step, time=block.time, stage=stage,
        origin=block.bounds[:2, 0].copy(), cell=block.bounds[:2, 1] - block.bounds[:2, 0],
        ids=ids, diameter=pick("diameter"), mass=pick("mass"), position=pick("x", "y"), velocity=pick("vx", "vy"),
        spin=pick("omegaz"), force=pick("fx", "fy"), torque=pick("tqz"),
        contacts=_contacts(table, ids, contacts), periodic=block.periodic,
    )  # fmt: skip
    return sound(frame, f"{grains}, line {block.line}")


def _contacts(block: Block, ids: Ints, path: PathLike) -> Contacts:
    named = set(CONTACT_COLUMNS) <= set(block.columns)
    if not named and (len(block.columns) != len(CONTACT_COLUMNS) or set(CONTACT_COLUMNS) & set(block.columns)):
        raise ArchiveError(
            f"{path}, line {block.line}: columns are {' '.join(block.columns)}, expected {' '.join(CONTACT_COLUMNS)}; "
            "correct the dump local command of the deck"
        )
    place = [block.columns.index(name) for name in CONTACT_COLUMNS] if named else slice(None)
    table = block.table[:, place]
    table = table[table[:, 2] != 0]
    swap = table[:, 0] > table[:, 1]
    table[swap, :2] = table[swap, 1::-1]
    table[np.ix_(swap, TURNING)] *= -1.0
    table = table[np.lexsort((table[:, 1], table[:, 0]))]
    where = f"{path}, step {block.step}"
    i, j = (rows_of(whole_numbers(table[:, c], f"{where}: grain id"), ids, where) for c in (0, 1))
    columns = np.ascontiguousarray(table[:, 5:].T)
    return Contacts(i, j, table[:, 3:5].copy(), *columns[:8], *(columns[8:] != 0))


def rows_of(wanted: Ints, ids: Ints, where: str) -> Ints:
    """Rows of grain ids ``wanted`` in the sorted array ``ids``; ArchiveError (named by ``where``) if one is absent."""
    absent = ~np.isin(wanted, ids)
    if absent.any():
        raise ArchiveError(
            f"{where}: the contact table names grain id {int(wanted[absent][0])}, which is no grain of that frame; "
            "both files must come from one run; run again"
        )
    return np.searchsorted(ids, wanted)

"""Readers of the text files a deck writes in one run directory: grains dump, contacts dump, time series.

Dumps are streamed, one frame in memory at a time.  A run may be killed while it writes: what follows the last complete
frame is ignored.  Damage before that point is an error that names file and line.  Contents are only ever parsed as
numbers.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import BinaryIO

import numpy as np

from workflow.data import text
from workflow.data.files import PathLike
from workflow.data.frame import LARGEST, NO_CONTACTS, Floats, Frame, Interactions, Ints, Tracks, validate_frame
from workflow.data.text import numbers_in, numeric, open_output, whole_numbers
from workflow.errors import ArchiveError

TRACK_COLUMNS = ("id", "x", "y")
GRAIN_COLUMNS = ("id", "diameter", "mass", "x", "y", "vx", "vy", "omegaz", "fx", "fy", "tqz")
MOST_DIGITS = 18  # of a whole number that fits 64 bits
# of a contact dump; the decks up to version 0.2 left them numbered, c_pairs[1] to c_pairs[15]
CONTACT_COLUMNS = ("id_i", "id_j", "state", "bx", "by", "gap", "elastic", "viscous", "attraction", "tangential", "moment", "du",
                   "dtheta", "sliding", "rolling")  # fmt: skip
TURNING = ("bx", "by", "moment", "dtheta")  # columns of a contact that change their sign when i and j are exchanged
NUMBERED = re.compile(r"([cf]_\w+)\[(\d+)\]")  # a column that nobody named: compute or fix, and its place there


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
    contacts_of: Callable[[Block, Frame], Frame] | None = None,
) -> Iterator[Frame]:
    """Frames of a run: the steps present in both dumps, in order; one at a time.

    ``grains``: columns `GRAIN_COLUMNS` in any order, others are ignored; sorted by id.  ``contacts``: `CONTACT_COLUMNS` in any
    order, others are ignored, or all of them by their numbers (see `numbered_contacts`); rows of state 0 are dropped, the
    others brought to i < j (which flips branch, moment and rotation, while T and du keep their sign) and sorted by (i, j).
    ``series`` (see `read_series`) gives each frame the stage number of the last row at or before its step, and ``stages``
    names the numbers (default: the number).  ``contacts_of``: puts the interactions of another kind of contact table into a
    frame.  Raises ArchiveError.
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
            frame = _grains(block, names.get(number, str(number)), grains)
            whole = contacts_of(table, frame) if contacts_of else _with_contacts(frame, table, contacts)
            yield validate_frame(whole, f"{grains}, line {block.line}")


def read_tracks(path: PathLike) -> Tracks:
    """Positions of a ``dump custom`` with the columns id x y at many times, grains that come and go included."""
    blocks = list(read_blocks(path, "ATOMS"))
    for block in blocks:
        if not (np.abs(block.table) < LARGEST).all():
            raise ArchiveError(f"{path}, step {block.step}: a position is no place in a box; the file is damaged, run again")
    places = [_places(block, TRACK_COLUMNS, path) for block in blocks]
    named = [
        whole_numbers(block.table[:, place["id"]], f"{path}, step {block.step}: grain id")
        for block, place in zip(blocks, places, strict=True)
    ]
    ids = np.unique(np.concatenate(named or [np.empty(0, dtype=np.int64)]))
    position = np.full((len(blocks), len(ids), 2), np.nan)
    for k, block in enumerate(blocks):
        position[k, np.searchsorted(ids, named[k])] = block.table[:, [places[k]["x"], places[k]["y"]]]
    return Tracks(np.array([block.time for block in blocks]), ids, position)


def _stage_number(series: Mapping[str, Floats] | None, step: int) -> int:
    """Stage in force at ``step``; of rows at the same step the first counts: the frame ends the earlier stage."""
    if not series or not len(series["step"]):
        return 0
    row = int(np.searchsorted(series["step"], step, "left"))
    if row == len(series["step"]) or series["step"][row] != step:
        row = max(row - 1, 0)
    return int(series["stage"][row])


def _with_contacts(frame: Frame, table: Block, path: PathLike) -> Frame:
    return replace(frame, interactions=_contacts(table, frame.ids, path))


def _grains(block: Block, stage: str, grains: PathLike) -> Frame:
    """The frame without its interactions."""
    place = _places(block, GRAIN_COLUMNS, grains)
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
    return Frame(
        step=block.step, time=block.time, stage=stage,
        origin=block.bounds[:2, 0].copy(), cell=block.bounds[:2, 1] - block.bounds[:2, 0],
        ids=ids, diameter=pick("diameter"), mass=pick("mass"), position=pick("x", "y"), velocity=pick("vx", "vy"),
        omega=pick("omegaz"), force=pick("fx", "fy"), torque=pick("tqz"),
        interactions=NO_CONTACTS, periodic=block.periodic,
    )  # fmt: skip


def _places(block: Block, names: Sequence[str], path: PathLike) -> dict[str, int]:
    """{name: its place among the columns}; ArchiveError if a name is missing or there twice."""
    missing = [name for name in names if name not in block.columns]
    twice = [name for name in names if block.columns.count(name) > 1]
    if missing or twice:
        what = f"column {', '.join(missing)} missing" if missing else f"column {', '.join(twice)} is there more than once"
        raise ArchiveError(f"{path}, line {block.line}: {what} in {' '.join(block.columns)}; expected "
                           f"{' '.join(names)}, each once; correct the dump command of the deck")  # fmt: skip
    return {name: block.columns.index(name) for name in names}


def numbered_contacts(columns: Sequence[str]) -> dict[str, str]:
    """{name: column} of a contact table whose deck left the columns of its ``compute pair/local`` numbered, c_ID[1] to
    c_ID[15], in any order; {} if these are not its columns.  So wrote the decks up to version 0.2."""
    matches = [NUMBERED.fullmatch(column) for column in columns]
    numbers = {int(match[2]): column for match, column in zip(matches, columns, strict=True) if match}
    if len({match[1] for match in matches if match}) != 1 or len(columns) != len(CONTACT_COLUMNS):
        return {}
    expected = range(1, len(CONTACT_COLUMNS) + 1)
    return dict(zip(CONTACT_COLUMNS, map(numbers.__getitem__, expected), strict=True)) if set(numbers) == set(expected) else {}


def _contacts(block: Block, ids: Ints, path: PathLike) -> Interactions:
    numbered = numbered_contacts(block.columns)
    place = {name: block.columns.index(column) for name, column in numbered.items()} or _places(block, CONTACT_COLUMNS, path)
    table = block.table[block.table[:, place["state"]] != 0]
    known = {name: np.ascontiguousarray(table[:, column]) for name, column in place.items()}
    swap = known["id_i"] > known["id_j"]
    for name in TURNING:
        known[name][swap] *= -1.0
    first, second = np.minimum(known["id_i"], known["id_j"]), np.maximum(known["id_i"], known["id_j"])
    order = np.lexsort((second, first))
    known = {name: column[order] for name, column in known.items()}
    where = f"{path}, step {block.step}"
    i, j = (rows_of(whole_numbers(end[order], f"{where}: grain id"), ids, where) for end in (first, second))
    return Interactions(
        i=i, j=j, branch=np.column_stack((known["bx"], known["by"])), gap=known["gap"], elastic=known["elastic"],
        viscous=known["viscous"], attraction=known["attraction"], tangential=known["tangential"], moment=known["moment"],
        xi_t=known["du"], xi_r=known["dtheta"], sliding=known["sliding"] != 0, rolling=known["rolling"] != 0,
    )  # fmt: skip


def rows_of(wanted: Ints, ids: Ints, where: str) -> Ints:
    """Rows of grain ids ``wanted`` in the sorted array ``ids``; ArchiveError (named by ``where``) if one is absent."""
    absent = ~np.isin(wanted, ids)
    if absent.any():
        raise ArchiveError(
            f"{where}: the contact table names grain id {int(wanted[absent][0])}, which is no grain of that frame; "
            "both files must come from one run; run again"
        )
    return np.searchsorted(ids, wanted)

"""Contact tables of other programs: the columns as the interactions of a frame, each pair once, nothing made up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from workflow.archive import plausible
from workflow.archive.columns import CONTACT_HELP, Reading, is_own
from workflow.archive.dump_tables import Dump
from workflow.archive.dumps import NUMBERED
from workflow.archive.pair_forces import Known, forces_of, rest_of
from workflow.archive.snapshots import Snapshot
from workflow.data.build import nearest
from workflow.data.frame import Floats, Frame, Interactions, Ints, validate_frame, without
from workflow.errors import ArchiveError

ODD = ("bx", "by", "moment", "dtheta", "fx", "fy", "fz", "tx", "ty")  # change sign when i and j are exchanged
REMEDY = "correct the file, or name its columns with --columns"


def contact_table(
    frame: Frame, dump: Dump, block: Snapshot, found: Mapping[str, str], reading: Reading, rounding: float = 0.0
) -> Frame:
    """``frame`` with the interactions of ``block``; ``found``: {name here: column}, ``rounding`` of the positions.  Raises
    ArchiveError and InputError."""
    missing = [name for name in ("id_i", "id_j") if name not in found]
    if missing:
        hint = (
            " the columns are numbered: of LIGGGHTS, add --liggghts KEYWORDS;"
            if any(map(NUMBERED.fullmatch, block.columns))
            else ""
        )
        raise ArchiveError(
            f"{block.where}: column {', '.join(missing)} missing in {' '.join(block.columns)};{hint} {CONTACT_HELP}"
        )
    own = is_own(found)  # a column named 'state' of another program is not ours
    used = {name: column for name, column in found.items() if own or name != "state"}
    columns = dump.table(block, list(dict.fromkeys(used.values())))
    known = {name: columns[column] for name, column in used.items()}
    if own:
        known = _rows(known, known.pop("state") != 0)
    known, i, j = _ordered(known, frame, block)
    known, i, j, notes = _once(known, i, j, frame, block)
    branch = _branch(known, i, j, frame, block)
    plausible.near(i, j, branch, frame, block.where)
    gap = _gap(known, i, j, branch, frame, block)
    parts, lacks = forces_of(known, branch, gap, block, reading)
    forces: dict[str, Any] = {**parts}
    table = Interactions(
        i, j, branch, np.zeros(len(i)) if gap is None else gap, **forces, **rest_of(known, forces, lacks, reading),
    )  # fmt: skip
    lacks |= {"gap"} if gap is None else set()
    lacks |= {name for name, column in (("xi_t", "du"), ("xi_r", "dtheta")) if column not in known}
    if gap is not None and not own:
        table, said = plausible.only_interactions(table, frame, rounding, forces_known="normal" not in lacks)
        notes += said
    if "normal" not in lacks and not own:
        notes += plausible.forces(table, frame, block, reading.attraction)
    whole = replace(frame, interactions=table)
    notes += plausible.missed(whole, rounding, reading.complete and not own)
    return without(validate_frame(replace(whole, notes=(*frame.notes, *notes)), block.where, REMEDY), lacks)


def identities(values: Floats, block: Snapshot, name: str) -> Ints:
    """Numbers of grains.  Raises ArchiveError if one is no whole number."""
    broken = values[(values != np.floor(values)) | (np.abs(values) >= 2.0**53)]
    if len(broken):
        raise ArchiveError(f"{block.where}: {name} {broken[0]:g} is no whole number; name the column of the ids with --columns")
    return values.astype(np.int64)


def _rows(known: Known, kept: np.ndarray) -> Known:
    return {name: column[kept] for name, column in known.items()}


def _ordered(known: Known, frame: Frame, block: Snapshot) -> tuple[Known, Ints, Ints]:
    """Rows with i below j, sorted, and the two rows of the grains."""
    ends = [identities(known[name], block, name) for name in ("id_i", "id_j")]
    for end in ends:
        absent = end[~np.isin(end, frame.ids)]
        if len(absent):
            raise ArchiveError(f"{block.where}: grain id {absent[0]} is not in the dump of the grains at step {block.step} "
                               f"({len(absent)} such rows); give files of one run and one group, and the columns of "
                               "the ids")  # fmt: skip
    if (ends[0] == ends[1]).any():
        raise ArchiveError(f"{block.where}: grain {ends[0][ends[0] == ends[1]][0]} touches itself; {REMEDY}")
    swap = ends[0] > ends[1]
    sign = np.where(swap, -1.0, 1.0)
    known = known | {name: sign * known[name] for name in ODD if name in known}
    i, j = (np.searchsorted(frame.ids, end) for end in (np.minimum(*ends), np.maximum(*ends)))
    order = np.lexsort((j, i))
    return _rows(known, order), i[order], j[order]


def _once(known: Known, i: Ints, j: Ints, frame: Frame, block: Snapshot) -> tuple[Known, Ints, Ints, list[str]]:
    """Each pair once: rows that say the same again are left out, rows that contradict each other are refused.

    Two grains that meet on two sides of a small cell are two pairs; only their branches tell.
    """
    same = (np.diff(i) == 0) & (np.diff(j) == 0)
    if "bx" in known and "by" in known:
        apart = np.abs(np.diff(np.column_stack((known["bx"], known["by"])), axis=0)) > 1e-3 * frame.cell
        same &= ~apart.any(axis=1)
    again = np.append(np.zeros(min(len(i), 1), dtype=bool), same)
    if not again.any():
        return known, i, j, []
    rows = np.flatnonzero(again)
    for name, column in known.items():
        scale = float(np.abs(column).max(initial=0.0))
        differ = np.abs(column[rows] - column[rows - 1]) > 1e-4 * scale
        if name not in ("id_i", "id_j") and differ.any():
            row = rows[differ][0]
            raise ArchiveError(
                f"{block.where}: grains {frame.ids[i[row]]} and {frame.ids[j[row]]} are listed twice with different {name} "
                f"({column[row - 1]:g} and {column[row]:g}, seen from the lower id); write each pair once"
            )
    kept = ~again
    note = f"{block.path}: {len(rows)} of {len(i)} rows repeat a pair (both directions, or twice); each pair is counted once"
    return _rows(known, kept), i[kept], j[kept], [note]


def _branch(known: Known, i: Ints, j: Ints, frame: Frame, block: Snapshot) -> Floats:
    """Vectors from i to j: those of the file, or to the nearest image."""
    straight = frame.position[j] - frame.position[i]
    cell = np.where(frame.periodic, frame.cell, np.inf)
    short = nearest(straight, cell)
    if "bx" not in known or "by" not in known:
        return short
    branch = np.column_stack((known["bx"], known["by"]))
    off = nearest(branch - straight, cell)
    wrong = np.flatnonzero((np.abs(off) > 1e-3 * frame.cell).any(axis=1))
    if len(wrong):
        k = wrong[0]
        raise ArchiveError(
            f"{block.where}: bx by of grains {frame.ids[i[k]]} and {frame.ids[j[k]]} is ({branch[k, 0]:g}, "
            f"{branch[k, 1]:g}), their centres are ({short[k, 0]:g}, {short[k, 1]:g}) apart; {len(wrong)} rows differ; "
            "give files of one moment"
        )
    return branch


def _gap(known: Known, i: Ints, j: Ints, branch: Floats, frame: Frame, block: Snapshot) -> Floats | None:
    """Gaps of the file, or from the diameters; None if neither is there."""
    given = known["gap"] if "gap" in known else -known["overlap"] if "overlap" in known else None
    if "diameter" in frame.lacks:
        return given
    mean = (frame.diameter[i] + frame.diameter[j]) / 2
    seen = np.hypot(*branch.T) - mean
    if given is None:
        return np.asarray(seen)
    wrong = np.flatnonzero(np.abs(given - seen) > 1e-3 * mean + 1e-5 * frame.cell.max())  # the digits of a file
    if not len(wrong) and not given.any():
        wrong = np.flatnonzero(seen)
    if len(wrong):
        k = wrong[0]
        raise ArchiveError(f"{block.where}: the gap of grains {frame.ids[i[k]]} and {frame.ids[j[k]]} is {given[k]:g} in "
                           f"the file, {seen[k]:g} by positions and diameters; {REMEDY}")  # fmt: skip
    return given

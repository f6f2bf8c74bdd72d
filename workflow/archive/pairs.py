"""Contact tables of other programs: the columns as the interactions of a frame, each pair once, nothing made up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from workflow.analysis.build import nearest
from workflow.analysis.frame import Contacts, Floats, Frame, Ints, sound, without
from workflow.archive import plausible
from workflow.archive.columns import CONTACT_HELP, NUMBERED, Reading, is_own
from workflow.archive.snapshots import Dump, Snapshot
from workflow.errors import ArchiveError

ODD = ("bx", "by", "moment", "dtheta", "fx", "fy", "fz", "tx", "ty")  # change sign when i and j are exchanged
CENTRAL = 1e-3  # |T| below this share of the largest |N| is the rounding of a force along the branch
SLIDES = 1e-4  # how close to the Coulomb limit a contact slides: files have six digits and more
EMPTY: Any = np.empty(0)
NO_CONTACTS = Contacts(
    EMPTY.astype(np.int64), EMPTY.astype(np.int64), np.empty((0, 2)), *[EMPTY] * 8, *[EMPTY.astype(bool)] * 2
)
REMEDY = "correct the file, or name its columns with --columns"

Known = dict[str, Floats]


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
    parts, lacks = _forces(known, branch, block, reading)
    forces: dict[str, Any] = {**parts}
    table = Contacts(
        i, j, branch, np.zeros(len(i)) if gap is None else gap, **forces, **_rest(known, forces, lacks, reading),
    )  # fmt: skip
    lacks |= {"gap"} if gap is None else set()
    lacks |= {name for name, column in (("stretch", "du"), ("rotation", "dtheta")) if column not in known}
    if gap is not None and not own:
        table, said = plausible.only_interactions(table, frame, rounding, forces_known="normal" not in lacks)
        notes += said
    if "normal" not in lacks and not own:
        notes += plausible.forces(table, frame, block, reading.attraction)
    whole = replace(frame, contacts=table)
    notes += plausible.missed(whole, rounding, reading.complete and not own)
    return without(sound(replace(whole, notes=(*frame.notes, *notes)), block.where, REMEDY), lacks)


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
            raise ArchiveError(f"{block.where}: grain id {absent[0]} is not in the dump of the grains at step "
                               f"{block.step} ({len(absent)} such "
                               "rows); give files of one run and one group, and the columns of the ids")  # fmt: skip
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
            f"{branch[k, 1]:g}), their "
            f"centres are ({short[k, 0]:g}, {short[k, 1]:g}) apart; {len(wrong)} rows differ; give files of one moment"
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
        raise ArchiveError(f"{block.where}: the gap of grains {frame.ids[i[k]]} and {frame.ids[j[k]]} is "
                           f"{given[k]:g} in the file, "
                           f"{seen[k]:g} by positions and diameters; {REMEDY}")  # fmt: skip
    return given


def _forces(known: Known, branch: Floats, block: Snapshot, reading: Reading) -> tuple[dict[str, Floats], set[str]]:
    """The parts of N, and T, with what is lacking of them (zero here)."""
    count = len(branch)
    vector = _of_vector(known, branch, block) if {"fx", "fy"} <= set(known) else None
    parts = (
        [known[name] for name in ("elastic", "viscous", "attraction")]
        if {"elastic", "viscous", "attraction"} <= set(known)
        else None
    )
    given = {
        "fx fy": None if vector is None else vector[0],
        "normal": known.get("normal"),
        "elastic viscous attraction": None if parts is None else parts[0] + parts[1] + parts[2],
    }
    chosen = _chosen({name: value for name, value in given.items() if value is not None}, reading, block)
    zero = np.zeros(count)
    tangential = known.get("tangential") if vector is None or "tangential" in reading.names else vector[1]
    lacks = _lacking(chosen, tangential, known, vector, reading, count)
    if parts is not None and chosen == "elastic viscous attraction":
        forces = dict(zip(("elastic", "viscous", "attraction"), parts, strict=True))
    else:
        normal = given[chosen] if chosen else zero
        assert normal is not None
        pull = np.minimum(normal, 0.0)
        attracts = reading.attraction > 0
        forces = {
            "elastic": np.maximum(normal, 0.0),
            "viscous": zero if attracts else pull,
            "attraction": pull if attracts else zero,
        }
    return forces | {"tangential": zero if tangential is None or "tangential" in lacks else tangential}, lacks


def _chosen(given: Mapping[str, Floats], reading: Reading, block: Snapshot) -> str | None:
    """Which of several descriptions of N counts: the one that the user names, else the only one, else all if they agree."""
    named = [name for name in given if any(word in reading.names for word in name.split())]
    if named:
        return named[0]
    names = list(given)
    for other in names[1:]:
        scale = float(np.abs(given[names[0]]).max(initial=0.0))
        if (np.abs(given[other] - given[names[0]]) > 1e-3 * scale).any():
            raise ArchiveError(f"{block.where}: {names[0]} and {other} give different normal forces; name the "
                               f"columns that count with "
                               "--columns, such as normal=normal")  # fmt: skip
    return names[-1] if names and names[-1].startswith("elastic") else names[0] if names else None


def _of_vector(known: Known, branch: Floats, block: Snapshot) -> tuple[Floats, Floats]:
    """N and T from the force on i, fx fy, and its tangential part tx ty where that comes apart."""
    n = branch / np.hypot(*branch.T)[:, None] if len(branch) else branch
    t = np.column_stack((-n[:, 1], n[:, 0]))
    force = -np.column_stack((known["fx"], known["fy"]))  # of i on j
    plausible.planar(known, block)
    if {"tx", "ty"} <= set(known):
        scale = float(np.abs(force).max(initial=0.0))
        oblique = np.abs((force * t).sum(axis=1)) > 10 * CENTRAL * scale
        if oblique.any() and (known["tx"].any() or known["ty"].any()):
            raise ArchiveError(
                f"{block.where}: fx fy are not along the line of centres in {int(oblique.sum())} rows, so that "
                f"they hold the tangential "
                "part; leave tx ty out (or give the normal part as fx fy)"
            )
        force = force - np.column_stack((known["tx"], known["ty"]))
    return (force * n).sum(axis=1), (force * t).sum(axis=1)


def _lacking(
    chosen: str | None,
    tangential: Floats | None,
    known: Known,
    vector: tuple[Floats, Floats] | None,
    reading: Reading,
    count: int,
) -> set[str]:
    """normal and tangential, where the file has them not.  A force along the branch alone, as compute pair/local gives it,
    has no tangential part unless the law has none."""
    lacks = set() if chosen else {"normal"}
    central = (
        vector is not None and not {"tx", "ty"} <= set(known)
        and np.abs(vector[1]).max(initial=0.0) <= CENTRAL * np.abs(vector[0]).max(initial=0.0)
    )  # fmt: skip
    if reading.friction != 0 and count and (tangential is None or (central and "tangential" not in known)):
        lacks |= {"tangential"}
    return lacks


def _rest(known: Known, forces: Mapping[str, Floats], lacks: set[str], reading: Reading) -> dict[str, Any]:
    """Moments, displacements and flags; ``lacks`` grows by what the law has and the file has not."""
    zero = np.zeros(len(forces["elastic"]))
    if reading.rolling:
        lacks |= {name for name in ("moment", "rolling") if name not in known}
    if "sliding" in known:
        sliding = known["sliding"] != 0
    elif reading.friction is not None and not {"normal", "tangential"} & lacks:
        normal = forces["elastic"] + forces["viscous"] + forces["attraction"]
        limit = reading.friction * np.maximum(normal + reading.attraction, 0.0)
        size = np.abs(forces["tangential"])
        sliding = (size > 0) & (size >= limit * (1.0 - SLIDES))
    else:
        sliding = zero > 0
        lacks |= {"sliding"}
    return {
        "moment": known.get("moment", zero), "stretch": known.get("du", zero), "rotation": known.get("dtheta", zero),
        "sliding": sliding, "rolling": known.get("rolling", zero) != 0,
    }  # fmt: skip

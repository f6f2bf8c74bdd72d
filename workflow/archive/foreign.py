"""Frames of data that other programs made: LAMMPS dumps with a contact table, and MDAnalysis Universes.

Plain arrays need no reader: `workflow.analysis.build.make_frame`.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from workflow.analysis.build import make_frame
from workflow.analysis.frame import Floats, Frame, sound
from workflow.archive.dumps import CONTACT_COLUMNS, Block, PathLike, read_blocks, rows_of, whole
from workflow.errors import ArchiveError, InputError

if TYPE_CHECKING:
    import MDAnalysis

# Names a column of a dump can have; others are ignored.  {field of make_frame: alternatives, each a tuple of columns}
GRAINS: dict[str, tuple[tuple[str, ...], ...]] = {
    "position": (("x", "y"), ("xu", "yu")), "mass": (("mass",),), "velocity": (("vx", "vy"),), "spin": (("omegaz",),),
    "force": (("fx", "fy"),), "torque": (("tqz",),),
}  # fmt: skip
PAIRS: dict[str, tuple[str, ...]] = {
    "branch": ("bx", "by"), "gap": ("gap",), "elastic": ("elastic",), "viscous": ("viscous",),
    "attraction": ("attraction",), "normal": ("normal",), "tangential": ("tangential",), "moment": ("moment",),
    "stretch": ("du",), "rotation": ("dtheta",), "sliding": ("sliding",), "rolling": ("rolling",),
}  # fmt: skip
# the columns of this package's own contact dumps, which LAMMPS calls c_...[1] to c_...[15]
OWN = ("id_i", "id_j", "state", "bx", "by", "gap", "elastic", "viscous", "attraction", "tangential", "moment", "du", "dtheta",
       "sliding", "rolling")  # fmt: skip
ODD = ("bx", "by", "moment", "dtheta")  # change sign when i and j are exchanged
CONTACT_HELP = (
    "name the columns with dump_modify colname or --columns NAME=COLUMN; needed: id_i id_j; used: bx by (branch), gap, "
    "normal (or elastic viscous attraction), tangential, moment, or fx fy (force on id_i) and tx ty (its tangential part "
    "where fx fy lacks it, as in compute pair/local)"
)


def foreign_frames(
    grains: PathLike, contacts: PathLike | None = None, *, names: Mapping[str, str] | None = None
) -> Iterator[Frame]:
    """Frames of a LAMMPS ``dump custom`` of discs, periodic in x and y, with a ``dump local`` of their contacts.

    ``grains``: columns id, x y (or xu yu), diameter or radius, and, where there are any, mass vx vy omegaz fx fy tqz.
    ``contacts``: one row per pair, columns as in CONTACT_HELP; the steps present in both files are given.  None: the
    discs that overlap, without forces.  ``names``: {name used here: column in the file}.  Raises ArchiveError that
    names what is missing.
    """
    renamed = {column: name for name, column in (names or {}).items()}
    partner = read_blocks(contacts, "ENTRIES", foreign=True) if contacts is not None else None
    table = next(partner, None) if partner else None
    for block in read_blocks(grains, "ATOMS", foreign=True):
        while partner and table is not None and table.step < block.step:
            table = next(partner, None)
        if partner and table is None:
            return
        if table is None or table.step == block.step:
            yield _frame(block, table, renamed, grains, contacts)


def _columns(block: Block, renamed: Mapping[str, str]) -> dict[str, Floats]:
    names = [renamed.get(column, column) for column in block.columns]
    numbered = [re.fullmatch(r"c_\w+\[(\d+)\]", column) for column in block.columns]
    if len(names) == CONTACT_COLUMNS and all(m and int(m[1]) == k for k, m in enumerate(numbered, 1)):
        names = list(OWN)
    return dict(zip(names, block.table.T, strict=True))


def _frame(block: Block, table: Block | None, renamed: Mapping[str, str], grains: PathLike, contacts: PathLike | None) -> Frame:
    known = _columns(block, renamed)
    if (
        "id" not in known
        or not any(set(pair) <= set(known) for pair in GRAINS["position"])
        or not {"diameter", "radius"} & set(known)
    ):
        raise ArchiveError(
            f"{grains}, line {block.line}: columns are {' '.join(block.columns)}; needed are id, x y (or xu yu), and "
            "diameter or radius; add them to the dump command, or name them with --columns NAME=COLUMN"
        )
    order = np.argsort(known["id"], kind="stable")
    known = {name: column[order] for name, column in known.items()}
    ids = whole(known["id"], f"{grains}, line {block.line}: grain id")
    if (np.diff(ids) <= 0).any():
        raise ArchiveError(f"{grains}, line {block.line}: grain id {ids[1:][np.diff(ids) <= 0][0]} occurs twice at step "
                           f"{block.step}; write each grain once")  # fmt: skip
    values = {}
    for field, choices in GRAINS.items():
        found = next((names for names in choices if set(names) <= set(known)), None)
        if found:
            values[field] = np.column_stack([known[n] for n in found]) if len(found) > 1 else known[found[0]]
    diameter = known["diameter"] if "diameter" in known else 2.0 * known["radius"]
    cell, origin = block.bounds[:2, 1] - block.bounds[:2, 0], block.bounds[:2, 0].copy()
    pairs = None if table is None else _pairs(table, renamed, ids, f"{contacts}, line {table.line}")
    if pairs is not None and "force" in pairs:
        _split(pairs, values["position"], cell)
    frame = make_frame(
        values.pop("position"), diameter, cell, pairs, origin=origin, step=block.step, ids=ids,
        time=0.0 if np.isnan(block.time) else block.time, **values,
    )  # fmt: skip
    return sound(frame, f"{grains}, line {block.line}")


def _pairs(table: Block, renamed: Mapping[str, str], ids: Any, where: str) -> dict[str, Any]:
    """Columns for make_frame, i below j; "force" holds the force of i on j where it is given as a vector."""
    known = _columns(table, renamed)
    missing = [name for name in ("id_i", "id_j") if name not in known]
    if missing:
        raise ArchiveError(f"{where}: column {', '.join(missing)} missing in {' '.join(table.columns)}; {CONTACT_HELP}")
    if "state" in known:
        known = {name: column[known["state"] != 0] for name, column in known.items()}
    swap = known["id_i"] > known["id_j"]
    sign = np.where(swap, -1.0, 1.0)
    known |= {name: sign * known[name] for name in (*ODD, "fx", "fy", "tx", "ty") if name in known}
    known["id_i"], known["id_j"] = np.minimum(known["id_i"], known["id_j"]), np.maximum(known["id_i"], known["id_j"])
    pairs: dict[str, Any] = {
        name: rows_of(whole(known[column], f"{where}: grain id"), ids, where) for name, column in (("i", "id_i"), ("j", "id_j"))
    }
    for field, names in PAIRS.items():
        if set(names) <= set(known):
            pairs[field] = np.column_stack([known[n] for n in names]) if len(names) > 1 else known[names[0]]
    if {"fx", "fy"} <= set(known):  # on i, as LAMMPS gives it; the force of i on j is the opposite
        total = [known[f"f{axis}"] + known.get(f"t{axis}", 0.0) for axis in "xy"]
        pairs["force"] = -np.column_stack(total)
    return pairs


def _split(pairs: dict[str, Any], position: Floats, cell: Floats) -> None:
    """The force vector of i on j becomes N and T."""
    force = pairs.pop("force")
    branch = pairs.get("branch")
    if branch is None:
        branch = position[pairs["j"]] - position[pairs["i"]]
        branch = branch - cell * np.round(branch / cell)
    with np.errstate(divide="ignore", invalid="ignore"):  # two grains at one place: `make_frame` refuses what comes out
        n = branch / np.hypot(*branch.T)[:, None]
    pairs["normal"] = (force * n).sum(axis=1)
    pairs["tangential"] = force[:, 1] * n[:, 0] - force[:, 0] * n[:, 1]


def universe_frame(
    universe: MDAnalysis.Universe, pairs: Mapping[str, ArrayLike] | None = None, *, radii: ArrayLike | None = None
) -> Frame:
    """The current time step of a MDAnalysis Universe of discs in the xy plane, in a rectangular periodic cell.

    ``radii`` default to the Universe's own; ``pairs`` as in `make_frame` (None: the discs that overlap).  MDAnalysis holds
    positions as float32 (7 digits): a warning says what that leaves of the gaps.  Raises InputError.
    """
    atoms, box = universe.atoms, universe.dimensions
    if box is None or not np.allclose(box[3:], 90.0) or not (box[:2] > 0).all():
        raise InputError(f"universe.dimensions = {box}; set the lengths of a rectangular cell and angles of 90 degrees")
    if radii is None and not hasattr(atoms, "radii"):
        raise InputError("the universe has no radii; give radii=..., or add the topology attribute 'radii'")
    position = np.asarray(atoms.positions)
    if position.dtype == np.float32:
        error = float(np.spacing(np.abs(position[:, :2]).max(initial=0.0)))
        warnings.warn(
            f"MDAnalysis holds positions as float32: gaps are uncertain by {2 * error:.1e}; overlaps below that are lost, "
            "give the contact table, or read the run's archive in float64",
            stacklevel=2,
        )
    diameter = 2.0 * np.asarray(atoms.radii if radii is None else radii, dtype=np.float64)
    cell = np.asarray(box[:2], dtype=np.float64)
    mass = {"mass": np.asarray(atoms.masses, dtype=np.float64)} if hasattr(atoms, "masses") else {}
    return make_frame(position, diameter, cell, pairs, step=int(universe.trajectory.frame), **mass)

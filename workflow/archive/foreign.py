"""Frames of data that other programs made: LAMMPS and LIGGGHTS dumps with contact tables, and MDAnalysis Universes.

What a file does not give is not made up: the frame lacks it (`Frame.lacks`), and what needs it is undefined.  Plain
arrays need no reader: `workflow.data.build.make_frame`.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from workflow.archive import plausible
from workflow.archive.columns import FORMS, GRAINS, Reading, check_names, contact_names, resolve
from workflow.archive.dump_tables import Dump
from workflow.archive.pairs import REMEDY, contact_table, identities
from workflow.archive.snapshots import Snapshot
from workflow.data.build import make_frame
from workflow.data.files import PathLike
from workflow.data.frame import NO_CONTACTS, Floats, Frame, Ints, validate_frame, without
from workflow.errors import ArchiveError, InputError

if TYPE_CHECKING:
    import MDAnalysis

UNIFORM = ("lj", "si", "cgs", "micro", "nano", "")  # units of LAMMPS in which m v^2 is a force times a length
FEW = 20
VECTORS = {"velocity": ("vx", "vy"), "force": ("fx", "fy")}
SCALARS = {"mass": "mass", "omega": "omegaz", "torque": "tqz"}


class Sample:
    """The frames of one packing: ``grains`` and, if there are any, ``contacts``, one or several files of each, text dumps
    plain or compressed.  ``steps``: those of both.  Raises InputError and ArchiveError."""

    def __init__(self, grains: Sequence[PathLike], contacts: Sequence[PathLike] = (), reading: Reading | None = None) -> None:
        self.reading = reading or Reading()
        self.grains = Dump(grains)
        self.interactions = Dump(contacts) if contacts else None
        self.notes = [*self.grains.notes, *(self.interactions.notes if self.interactions else [])]
        steps = list(self.grains.snapshots)
        if self.interactions:
            others = self.interactions.snapshots
            self.steps = [step for step in steps if step in others]
            if not self.steps:
                raise InputError(f"'{grains[0]}' has the steps {_range(steps)}, '{contacts[0]}' has "
                                 f"{_range(list(others))}: none is in both; give files of one run")  # fmt: skip
            alone = len(steps) + len(others) - 2 * len(self.steps)
            if alone:
                self.notes.append(f"{alone} snapshots are in one of grains and contacts only and left out")
        else:
            self.steps = steps

    def frame(self, number: int) -> Frame:
        """Frame ``number`` of those in both files; negative from the end.  Raises InputError if there is none."""
        if not -len(self.steps) <= number < len(self.steps):
            raise InputError(f"frame {number} does not exist in '{self.grains.paths[0]}' (with its contacts), which has "
                             f"{len(self.steps)}; choose another --frame")  # fmt: skip
        step = self.steps[number]
        block = self.grains.snapshots[step]
        table = self.interactions.snapshots[step] if self.interactions else None
        check_names(self.reading.names, block, table)
        frame, rounding = _grains(self.grains, block, self.reading, with_contacts=table is not None)
        if table is None or self.interactions is None:
            frame = _overlapping(frame, block.where, rounding)
        else:
            plausible.same_moment(block, table)
            names = contact_names(table, self.reading.names, self.reading.liggghts)
            frame = contact_table(frame, self.interactions, table, names, self.reading, rounding)
        return replace(frame, notes=(*self.notes, *frame.notes, *plausible.notes_of(frame, self.reading.friction)))

    def frames(self) -> Iterator[Frame]:
        """All frames, one at a time."""
        dumps = [dump for dump in (self.grains, self.interactions) if dump is not None]
        try:
            for dump in dumps:
                dump.streaming = True
            for number in range(len(self.steps)):
                yield self.frame(number)
        finally:
            for dump in dumps:
                dump.streaming = False
                dump.close()


def foreign_frames(
    grains: PathLike, contacts: PathLike | None = None, *, names: Mapping[str, str] | None = None, friction: float | None = None
) -> Iterator[Frame]:
    """Frames of a LAMMPS ``dump custom`` of discs with a ``dump local`` of their contacts; see `Sample` and `Reading`.

    ``grains``: columns of `workflow.archive.columns.GRAINS`, at least id, a coordinate x and y in any of its forms, and
    diameter or radius.  ``contacts``: one row per pair, columns as in CONTACT_HELP; the steps in both files are given.
    None: the discs that overlap, without forces.
    """
    given = Reading(names=names or {}, friction=friction)
    yield from Sample([grains], [] if contacts is None else [contacts], given).frames()


def _grains(dump: Dump, block: Snapshot, reading: Reading, *, with_contacts: bool) -> tuple[Frame, float]:
    """The grains of a snapshot; ``with_contacts``: a table of them comes, so that diameters may lack.  And
    how far the positions are rounded."""
    found = resolve(block, GRAINS, reading.names)
    forms = {axis: _form(axis, found, reading.names) for axis in "xyz"}
    sized = with_contacts or {"diameter", "radius"} & set(found)
    if "id" not in found or forms["x"] is None or forms["y"] is None or not sized:
        raise ArchiveError(f"{block.where}: columns are {' '.join(block.columns)}; needed are id, x y (or xs ys, xu yu, "
                           f"xsu ysu), and diameter or radius; {_hint(block)}")  # fmt: skip
    used = {name: column for name, column in found.items() if name not in _coordinates() or name in forms.values()}
    columns = dump.table(block, list(dict.fromkeys(used.values())))
    known = {name: columns[column] for name, column in used.items()}
    ids = identities(known["id"], block, "grain id")
    order = np.argsort(ids, kind="stable")
    ids, known = ids[order], {name: column[order] for name, column in known.items()}
    twice = np.flatnonzero(np.diff(ids) == 0)
    if len(twice):
        raise ArchiveError(f"{block.where}: grain id {ids[twice[0]]} occurs twice at step {block.step}; write each grain once")
    if len(ids) and ids[0] < 1:
        raise ArchiveError(f"{block.where}: grain id {ids[0]} is not above 0; {REMEDY}")
    place = {axis: _place(known, axis, form, block) for axis, form in forms.items() if form is not None}
    diameter = _diameter(known, block, reading.names)
    plausible.flat(block, place.get("z"), diameter)
    sides = block.bounds[:2, 1] - block.bounds[:2, 0]
    rounding = max(plausible.last_digit(known[form]) * (sides[k] if "s" in form[1:] else 1.0)
                   for k, axis in enumerate("xy") if (form := forms[axis]) is not None)  # fmt: skip
    if diameter is not None and len(np.unique(diameter)) > FEW:  # a few sizes may be round numbers
        rounding = max(rounding, plausible.last_digit(diameter))
    return _frame(block, ids, np.column_stack((place["x"], place["y"])), diameter, known), rounding


def _coordinates() -> set[str]:
    return {axis + form for axis in "xyz" for form in FORMS}


def _form(axis: str, found: Mapping[str, str], names: Mapping[str, str]) -> str | None:
    """The name of the coordinate to read: one that the user gave, else the first there is."""
    there = [axis + form for form in FORMS if axis + form in found]
    return next((name for name in there if name in names), there[0] if there else None)


def _hint(block: Snapshot) -> str:
    if block.label != "ATOMS":
        return f"the rows are '{block.label}': a table of contacts goes behind --contacts, after the dump of the grains"
    return "add them to the dump command, or name them with --columns NAME=COLUMN"


def _place(known: Mapping[str, Floats], axis: str, name: str, block: Snapshot) -> Floats:
    """Coordinates from any of their four forms; unwrapped ones are brought into a periodic box."""
    k, values, form = "xyz".index(axis), known[name], name[1:]
    low, high = block.bounds[k]
    if "s" in form:
        values = low + values * (high - low)
    if "u" in form and k < 2 and block.periodic[k]:
        values = low + (values - low) % (high - low)
    return values


def _diameter(known: Mapping[str, Floats], block: Snapshot, names: Mapping[str, str]) -> Floats | None:
    radius, diameter = known.get("radius"), known.get("diameter")
    if radius is not None and diameter is not None and ("radius" in names) == ("diameter" in names):
        if not np.allclose(diameter, 2.0 * radius, rtol=1e-3):
            raise ArchiveError(f"{block.where}: diameter is not twice the radius; say with --columns which column counts")
    elif radius is not None and (diameter is None or "radius" in names):
        diameter = 2.0 * radius
    if diameter is not None and not (diameter > 0.0).all():
        raise ArchiveError(f"{block.where}: a grain has the diameter {diameter.min():g}, it must be above 0; {REMEDY}")
    return diameter


def _frame(block: Snapshot, ids: Ints, position: Floats, diameter: Floats | None, known: Mapping[str, Floats]) -> Frame:
    count, notes = len(ids), []
    lacks: set[str] = set()
    values: dict[str, Any] = {}
    for name, axes in VECTORS.items():
        there = [axis in known for axis in axes]
        values[name] = np.column_stack([known[axis] for axis in axes]) if all(there) else np.zeros((count, 2))
        lacks |= set() if all(there) else {name}
    for name, column in SCALARS.items():
        values[name] = known.get(column, np.ones(count) if name == "mass" else np.zeros(count))
        lacks |= set() if column in known else {name}
    if block.units not in UNIFORM and "mass" not in lacks:
        notes.append(f"units {block.units}: mass times velocity squared is no force times a length there; masses are not used")
        values["mass"], lacks = np.ones(count), lacks | {"mass"}
    lacks |= {"time"} if np.isnan(block.time) else set()
    lacks |= {"diameter"} if diameter is None else set()
    if not block.flags:
        notes.append(
            f"{block.where}: the header does not say where the box is periodic (it is old); taken as periodic in x and y"
        )
    frame = Frame(
        step=block.step, time=0.0 if np.isnan(block.time) else block.time, stage="", origin=block.bounds[:2, 0].copy(),
        cell=block.bounds[:2, 1] - block.bounds[:2, 0], ids=ids, diameter=np.ones(count) if diameter is None else diameter,
        position=position, interactions=NO_CONTACTS, periodic=block.periodic, notes=tuple(notes), **values,
    )  # fmt: skip
    return without(validate_frame(frame, block.where, REMEDY), lacks)


def _overlapping(frame: Frame, where: str, rounding: float) -> Frame:
    """The discs that overlap, of whose forces nothing is known."""
    shape = make_frame(frame.position, frame.diameter, frame.cell, origin=frame.origin, periodic=frame.periodic)
    plausible.near(shape.interactions.i, shape.interactions.j, shape.interactions.branch, frame, where)
    lacks = {"normal", "tangential", "moment", "xi_t", "xi_r", "sliding", "rolling"}
    note = "no contact table is given: contacts are the discs that overlap, their forces are unknown"
    notes = (*frame.notes, note, *plausible.near_touching(frame, rounding))
    return without(replace(frame, interactions=shape.interactions, notes=notes), lacks)


def _range(steps: Sequence[int]) -> str:
    return f"{steps[0]}" if len(steps) == 1 else f"{steps[0]} ... {steps[-1]} ({len(steps)})"


def universe_frame(
    universe: MDAnalysis.Universe, pairs: Mapping[str, ArrayLike] | None = None, *, radii: ArrayLike | None = None
) -> Frame:
    """The current time step of a MDAnalysis Universe of discs in the xy plane, in a rectangular periodic cell.

    ``radii`` default to the Universe's own; ``pairs`` as in `make_frame` (None: the discs that overlap); the frame lacks what
    neither gives.  MDAnalysis holds positions as float32 (7 digits): a warning says what that leaves of the gaps.  Raises
    InputError.
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
    mass: dict[str, Any] = {"mass": np.asarray(atoms.masses, dtype=np.float64)} if hasattr(atoms, "masses") else {}
    lacks = {"time", "velocity", "omega", "force", "torque", *(() if mass else ("mass",)), *_absent(pairs or {})}
    return without(make_frame(position, diameter, cell, pairs, step=int(universe.trajectory.frame), **mass), lacks)


def _absent(pairs: Mapping[str, ArrayLike]) -> set[str]:
    """The quantities of contacts that ``pairs`` does not give."""
    parts = {"normal"} if {"normal", "elastic", "viscous", "attraction"} & set(pairs) else set()
    return {"normal", "tangential", "moment", "xi_t", "xi_r", "sliding", "rolling"} - set(pairs) - parts

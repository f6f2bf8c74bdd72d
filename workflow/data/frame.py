"""The data every measure works on: grains in a periodic cell and the interactions between them.

All arrays are NumPy, float64 unless said otherwise; units are those of the scene (length a, mass of a disc of diameter
a, force F0 or a P).  Sign convention (G07 sec. II B): the unit normal n points from grain i to grain j, t is n rotated by
+90 degrees; the force of i on j is N n + T t, N > 0 repulsive; the rolling moment of i on j is ``moment``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Set
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from workflow.data.pandas_tables import data_frame
from workflow.data.units import Units
from workflow.errors import ArchiveError, InputError

if TYPE_CHECKING:
    import pandas

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

AT_ONCE = 65_536  # rows of a table that are Python objects
PARTS = ("elastic", "viscous", "attraction")  # of the normal force
PER_GRAIN = ("ids", "diameter", "mass", "position", "velocity", "omega", "force", "torque")  # fields of a frame
LARGEST = 1e30  # no number of a frame is larger: its powers stay finite, and it fits float32


def plain_rows(*columns: np.ndarray) -> Iterator[tuple[Any, ...]]:
    """The rows of a table as plain numbers, AT_ONCE of them in memory at one time."""
    for k in range(0, len(columns[0]), AT_ONCE):
        yield from zip(*(column[k : k + AT_ONCE].tolist() for column in columns), strict=True)


@dataclass(frozen=True, repr=False)
class Interactions:
    """Interactions of one frame, one row each: contacts (gap < 0) and distant pairs (0 <= gap <= D0, or a contact that opened
    in the last step and is still due a viscous force).

    ``i``, ``j``: 0-based rows of the grain arrays, each pair once.  ``branch`` (M, 2): vector from the centre of i to the
    centre of (the nearest image of) j.  ``gap``: h = |branch| - (d_i + d_j)/2.  ``elastic`` N_e = -K_N h >= 0,
    ``viscous`` N_v = -eta v_n, ``attraction`` N_a <= 0; ``tangential`` T; ``moment`` rolling moment of i on j;
    ``xi_t`` elastic tangential displacement du, ``xi_r`` elastic relative rotation dtheta; ``sliding`` and
    ``rolling``: the Coulomb, respectively rolling, limit is reached.
    """

    i: Ints
    j: Ints
    branch: Floats
    gap: Floats
    elastic: Floats
    viscous: Floats
    attraction: Floats
    tangential: Floats
    moment: Floats
    xi_t: Floats
    xi_r: Floats
    sliding: Bools
    rolling: Bools

    def __post_init__(self) -> None:
        rows = len(self.i)
        for field in fields(self):
            if len(getattr(self, field.name)) != rows:
                raise InputError(
                    f"contacts: column '{field.name}' has {len(getattr(self, field.name))} rows, 'i' has {rows}; "
                    "give every column one value per interaction"
                )

    def __len__(self) -> int:
        return len(self.i)

    def __repr__(self) -> str:
        contacts = int(self.in_contact.sum())
        return f"<Interactions: {len(self)} pairs, {contacts} in contact, {len(self) - contacts} distant>"

    def to_pandas(self) -> pandas.DataFrame:
        """A row per interaction: the fields by their names (branch_x, branch_y), in_contact, distance and normal_force.

        Raises EnvironmentFault if pandas is not installed.
        """
        derived = {name: getattr(self, name) for name in ("in_contact", "distance", "normal_force")}
        return data_frame({f.name: getattr(self, f.name) for f in fields(self)} | derived)

    @property
    def normal_force(self) -> Floats:
        """N = N_e + N_v + N_a, (M,), repulsion positive (G07 eqs. 4, 5)."""
        return self.elastic + self.viscous + self.attraction

    @property
    def distance(self) -> Floats:
        """|branch|, (M,)."""
        return np.hypot(self.branch[:, 0], self.branch[:, 1])

    @property
    def normal(self) -> Floats:
        """Unit normal from i to j, (M, 2)."""
        return self.branch / self.distance[:, None]

    @property
    def force(self) -> Floats:
        """Force of i on j, N n + T t, (M, 2)."""
        n = self.normal
        t = np.column_stack((-n[:, 1], n[:, 0]))
        return self.normal_force[:, None] * n + self.tangential[:, None] * t

    @property
    def in_contact(self) -> Bools:
        """True for contacts (gap < 0), False for distant pairs."""
        return self.gap < 0.0

    def select(self, rows: NDArray) -> Interactions:
        """The interactions of ``rows`` (a mask or indices) as a new table."""
        return Interactions(*(getattr(self, f.name)[rows] for f in fields(self)))


EMPTY: Any = np.empty(0)
NO_CONTACTS = Interactions(
    EMPTY.astype(np.int64), EMPTY.astype(np.int64), np.empty((0, 2)), *[EMPTY] * 8, *[EMPTY.astype(bool)] * 2
)


@dataclass(frozen=True, repr=False)
class Frame:
    """One instant: grains (sorted by id) in a rectangular periodic cell, with their interactions.

    ``cell`` (2,): lengths L1, L2.  ``origin`` (2,): lower corner.  Per grain: ``ids`` (N,) int64, ``diameter``, ``mass`` (N,),
    ``position``, ``velocity`` (N, 2) (velocity relative to the affine motion of the cell), ``omega`` (N,),
    ``force`` (N, 2) and ``torque`` (N,) as the engine summed them.  ``periodic``: of the axes x, y.  ``lacks``: what the
    source does not give, see `without`.  ``notes``: what is to be said of the source with every number.  ``units``: their
    names in ASCII, None where the source states none.
    """

    step: int
    time: float
    stage: str
    origin: Floats
    cell: Floats
    ids: Ints
    diameter: Floats
    mass: Floats
    position: Floats
    velocity: Floats
    omega: Floats
    force: Floats
    torque: Floats
    interactions: Interactions
    periodic: tuple[bool, bool] = (True, True)
    lacks: frozenset[str] = frozenset()
    notes: tuple[str, ...] = ()
    units: Units | None = None

    def __repr__(self) -> str:
        length, time = (f" {self.units.length}", f" {self.units.time}") if self.units else ("", "")
        clock = "" if "time" in self.lacks else f" t = {self.time:.6g}{time},"
        cell = " x ".join(f"{side:.4g}" for side in self.cell.tolist())
        return (f"<Frame{f' {self.stage!r}' if self.stage else ''}:{clock} step {self.step}, {self.grains} grains, "
                f"{len(self.interactions)} interactions, cell {cell}{length}>")  # fmt: skip

    def to_pandas(self) -> pandas.DataFrame:
        """A row per grain, in the order to which ``interactions.i`` and ``j`` refer; vectors as two columns, position_x ...

        Raises EnvironmentFault if pandas is not installed.
        """
        return data_frame({name: getattr(self, name) for name in PER_GRAIN})

    @property
    def grains(self) -> int:
        """Number of grains N."""
        return len(self.ids)

    @property
    def area(self) -> float:
        """Cell area A = L1 L2."""
        return float(self.cell[0] * self.cell[1])

    def need(self, what: str, *names: str) -> None:
        """Raises InputError if one of ``names`` is lacking: ``what`` is undefined then."""
        missing = [name for name in names if name in self.lacks]
        if missing:
            raise InputError(f"{what}: undefined, the source does not give {', '.join(QUANTITIES[name] for name in missing)}")

    def select(self, kept: Bools) -> Frame:
        """The grains of ``kept`` (N,) and the interactions between them, in the same cell."""
        row = np.cumsum(kept) - 1
        table = self.interactions.select(kept[self.interactions.i] & kept[self.interactions.j])
        table = replace(table, i=row[table.i], j=row[table.j])
        return replace(self, interactions=table, **{name: getattr(self, name)[kept] for name in PER_GRAIN})


@dataclass(frozen=True)
class Tracks:
    """Positions at many times: ``time`` (F,), ``ids`` (G,), ``position`` (F, G, 2), NaN where a grain is absent."""

    time: Floats
    ids: Ints
    position: Floats


# what a source may lack, in words; "normal" stands for the three parts of N
QUANTITIES = {
    "time": "the time", "diameter": "diameters", "mass": "masses", "velocity": "velocities", "omega": "angular velocities",
    "force": "the sums of the forces on the grains", "torque": "the sums of the moments on the grains", "gap": "gaps",
    "normal": "normal forces", "tangential": "tangential forces", "moment": "rolling moments",
    "xi_t": "elastic displacements", "xi_r": "elastic rotations", "sliding": "which contacts slide",
    "rolling": "which contacts roll",
}  # fmt: skip


def _fields(lacks: Set[str]) -> set[str]:
    """Fields of Frame and Contacts that ``lacks`` names."""
    return {*lacks, *(PARTS if "normal" in lacks else ())}


def without(frame: Frame, names: Iterable[str]) -> Frame:
    """``frame`` with the quantities ``names`` (of QUANTITIES) unknown: NaN, so that no number can come of them, and in
    ``lacks``.  Truth values and the time, which have no NaN, keep what they are and must not be asked."""
    lacks = frozenset(names)
    absent = _fields(lacks)

    def unknown(owner: Frame | Interactions, names: Iterable[str]) -> dict[str, Any]:
        return {name: np.full_like(getattr(owner, name), np.nan) for name in names if name in absent}

    table = replace(frame.interactions, **unknown(frame.interactions, ("gap", *PARTS, "tangential", "moment", "xi_t", "xi_r")))
    grains = unknown(frame, ("diameter", "mass", "velocity", "omega", "force", "torque"))
    return replace(frame, interactions=table, lacks=frame.lacks | lacks, **grains)


DAMAGED = "the file is damaged, or no packing: restore it or run again"


def validate_frame(frame: Frame, where: str, remedy: str = DAMAGED) -> Frame:
    """``frame`` itself, if every number in it can be one of a packing.

    Finite numbers below LARGEST; cell lengths, diameters and masses above 0; ids above 0 and increasing; pairs of two
    different grains with distinct centres.  Raises ArchiveError that begins with ``where``, names the quantity and ends with
    ``remedy``: readers of files end here, so that measures need not doubt their input.
    """

    def demand(fine: Any, what: str) -> None:
        if not np.all(fine):
            raise ArchiveError(f"{where}: {what}; {remedy}")

    count, unknown = frame.grains, _fields(frame.lacks)
    for owner, name in [(frame, f.name) for f in fields(Frame)] + [(frame.interactions, f.name) for f in fields(Interactions)]:
        value = getattr(owner, name)
        if name not in unknown and isinstance(value, (float, np.ndarray)) and np.asarray(value).dtype.kind == "f":
            demand(np.abs(value) < LARGEST, f"{name} holds a value that is not finite")
    for name in ("diameter", "mass", "position", "velocity", "omega", "force", "torque"):
        demand(len(getattr(frame, name)) == count, f"{name} has not one value per grain")
    for name in {"cell", "diameter", "mass"} - unknown:
        demand(getattr(frame, name) > 0.0, f"{name} is not above 0")
    demand(frame.ids[:1] > 0, "grain ids are not above 0")
    demand(np.diff(frame.ids) > 0, "grain ids do not increase")
    demand(frame.interactions.i != frame.interactions.j, "a grain touches itself")
    demand(frame.interactions.distance > 0.0, "two grains in contact have one centre")
    return frame

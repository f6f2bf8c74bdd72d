"""Whether the data of other programs can be discs in a plane with their contacts: refused, or said beside the numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workflow.archive.snapshots import Snapshot
from workflow.data.balance import balance, solid_fraction
from workflow.data.build import nearest, pairs_in_contact
from workflow.data.frame import QUANTITIES, Floats, Frame, Interactions, Ints
from workflow.errors import ArchiveError, InputError

PLANE = 1e-6  # of a diameter: centres in one plane
DEEPEST = 0.5  # of the mean diameter of two grains; what overlaps farther is no contact
DEEP = 0.2  # of the mean diameter: no contact is overlapped that far, but in what is projected from space
SURE = 1e-9  # of the mean diameter: round-off of a file with all its digits
APART = 1e-4  # of the mean diameter: a gap above it is no rounding of a file with six digits
DIFFERS = 1e-3  # of the mean |N|: net forces that differ by more are not rounding


def flat(block: Snapshot, z: Floats | None, diameter: Floats | None) -> None:
    """Raises InputError if the centres are not in one plane."""
    if z is None or not len(z):
        return
    size = float(diameter.min()) if diameter is not None else 1.0
    span = float(np.ptp(z))
    if span > PLANE * size:
        raise InputError(f"{block.where}: z spans {span:.4g}, {span / size:.3g} of the smallest diameter: the data are "
                         "three-dimensional; all measures are of discs in a plane")  # fmt: skip


def planar(known: Mapping[str, Floats], block: Snapshot) -> None:
    """Raises InputError if contact forces leave the plane."""
    if "fz" in known:
        most = float(max(np.abs(known[name]).max(initial=0.0) for name in ("fx", "fy")))
        if np.abs(known["fz"]).max(initial=0.0) > PLANE * most:
            raise InputError(f"{block.where}: contact forces have a part along z: the data are three-dimensional; all "
                             "measures are of discs in a plane")  # fmt: skip


def same_moment(grains: Snapshot, contacts: Snapshot) -> None:
    """Raises InputError if box or time of the two files differ: they are of different runs."""
    side = (grains.bounds[:2, 1] - grains.bounds[:2, 0]).max()
    box = np.abs(grains.bounds[:2] - contacts.bounds[:2]).max() > 1e-5 * side
    time = not np.isnan(grains.time + contacts.time) and not np.isclose(grains.time, contacts.time, rtol=1e-6)
    if box or time:
        raise InputError(f"'{grains.path}' and '{contacts.path}' have different {'boxes' if box else 'times'} at step "
                         f"{grains.step}; give grains and contacts of one run")  # fmt: skip


def near(i: Ints, j: Ints, branch: Floats, frame: Frame, where: str) -> None:
    """Raises InputError for pairs farther apart, or nearer, than two discs in contact can be."""
    distance = np.hypot(*branch.T)
    if not (distance > 0.0).all():
        k = int(np.argmin(distance))
        raise ArchiveError(f"{where}: grains {frame.ids[i[k]]} and {frame.ids[j[k]]} have one centre; correct the file")
    if "diameter" in frame.lacks or not len(i):
        return
    mean = (frame.diameter[i] + frame.diameter[j]) / 2
    far = np.flatnonzero(distance - mean > frame.diameter.max())
    if len(far):
        k = far[0]
        raise InputError(
            f"{where}: grains {frame.ids[i[k]]} and {frame.ids[j[k]]} are {distance[k]:.4g} apart, more than two diameters "
            f"({len(far)} such rows): the table is of another sample or step, the ids are in other columns, or the box is "
            "periodic and its flags are not"
        )
    k = int(np.argmin(distance / mean))
    if distance[k] < (1.0 - DEEPEST) * mean[k]:
        raise InputError(
            f"{where}: the centres of grains {frame.ids[i[k]]} and {frame.ids[j[k]]} are {distance[k]:.4g} apart, their "
            f"mean diameter is {mean[k]:.4g}: no disc is overlapped that far; the lengths are of other units, the radii "
            "diameters, or the data three-dimensional"
        )


def only_interactions(table: Interactions, frame: Frame, rounding: float, forces_known: bool) -> tuple[Interactions, list[str]]:
    """The table without pairs that do not touch and exert no force: a list of neighbours holds such."""
    loose = table.gap > 0.0
    if forces_known:
        loose &= (table.normal_force == 0.0) & (table.tangential == 0.0) & (table.moment == 0.0)
    elif "diameter" not in frame.lacks:
        loose &= table.gap > SURE * frame.diameter.mean() + 2.0 * rounding
    if not loose.any():
        return table, []
    return table.select(~loose), [
        f"{int(loose.sum())} of {len(table)} rows are pairs that neither touch nor act on each other; left out"
    ]


def last_digit(values: Floats) -> float:
    """The unit of the last digit with which a file gives the largest of ``values``; 0 for ten digits and more."""
    some = values[: 1000 : max(len(values[:1000]) // 200, 1)].tolist()
    for digits in range(4, 10):
        if some and all(float(f"{value:.{digits}g}") == value for value in some):
            return float(10.0 ** (np.floor(np.log10(max(np.abs(values).max(), 1e-300))) + 1 - digits))
    return 0.0


def near_touching(frame: Frame, rounding: float) -> list[str]:
    """Pairs of which the digits of the positions do not tell whether they touch."""
    i, _, gap = _pairs(frame, 2.0 * rounding) if rounding else (np.empty(0), np.empty(0), np.empty(0))
    close = int((np.abs(gap) < 2.0 * rounding).sum())
    if not close:
        return []
    return [f"positions are given to {rounding:.0e}: whether {close} of {len(i)} pairs touch is open; write more digits "
            "(dump_modify format float %.17g), or give the contacts"]  # fmt: skip


def missed(frame: Frame, rounding: float, complete: bool) -> list[str]:
    """Discs that overlap and are not in the table of contacts: refused if it must be ``complete``, else said."""
    if "diameter" in frame.lacks or 2.0 * frame.diameter.max() >= frame.cell[list(frame.periodic)].min(initial=np.inf):
        return []
    i, j, gap = _pairs(frame, 0.0)
    table, least = frame.interactions, SURE * frame.diameter.mean() + 2.0 * rounding
    absent = ~np.isin(i * frame.grains + j, table.i * frame.grains + table.j) & (gap < -least)
    if not absent.any():
        return []
    k = int(np.argmin(np.where(absent, gap, 0.0)))
    words = (f"{int(absent.sum())} of {len(i)} pairs of discs that overlap are not in the table of contacts, deepest "
             f"{frame.ids[i[k]]} and {frame.ids[j[k]]} by {-gap[k]:.3g}")  # fmt: skip
    if not complete:
        return [f"{words}: they are not counted"]
    raise InputError(f"{words}: it is incomplete, or of another step; if these are no contacts (clumps, bonds, excluded "
                     "groups), add --partial")  # fmt: skip


def _pairs(frame: Frame, reach: float) -> tuple[Ints, Ints, Floats]:
    """Pairs with a gap below ``reach``, from positions and diameters."""
    i, j = pairs_in_contact(frame.position, frame.diameter, frame.cell, reach, periodic=frame.periodic)
    apart = nearest(frame.position[j] - frame.position[i], np.where(frame.periodic, frame.cell, np.inf))
    return i, j, np.hypot(*apart.T) - (frame.diameter[i] + frame.diameter[j]) / 2


def forces(table: Interactions, frame: Frame, block: Snapshot, attraction: float) -> list[str]:
    """Notes about the normal forces.  Raises InputError for forces that no contacts can have."""
    normal = table.normal_force
    if not len(normal):
        return []
    if not normal.any():
        raise InputError(f"{block.where}: all normal forces are 0 in {len(normal)} contacts; name the columns of the forces")
    pulling = float((normal < 0.0).mean())
    if pulling > 0.9 and attraction == 0.0 and normal.sum() < 0.0:
        raise InputError(f"{block.where}: {100 * pulling:.0f} % of the normal forces are attractive without --f0: forces "
                         "on id_j, or i and j exchanged? fx fy must be the force on id_i, normal above 0 where grains "
                         "repel")  # fmt: skip
    return _apart(table, frame, block) + _pulling(pulling, table, attraction)


def _pulling(share: float, table: Interactions, attraction: float) -> list[str]:
    if share > 0.0 and attraction == 0.0 and not table.attraction.any():
        return [f"{100 * share:.2g} % of the normal forces are attractive; without --f0 they count as viscous"]
    return []


def _apart(table: Interactions, frame: Frame, block: Snapshot) -> list[str]:
    """Grains that repel each other without touching, in a law of contact."""
    if "diameter" in frame.lacks:
        return []
    pushing = table.normal_force > 0.0
    apart = pushing & (table.gap > APART * frame.diameter.mean())
    if not apart.any():
        return []
    words = f"{int(apart.sum())} of {int(pushing.sum())} repulsive forces act between grains that do not touch"
    if apart.sum() > 0.9 * pushing.sum():
        raise InputError(f"{block.where}: {words}; are the radii given as diameters, or lengths in other units?")
    return [words]


def notes_of(frame: Frame, friction: float | None) -> list[str]:
    """What is to be said beside the numbers of a frame.  Raises InputError where they cannot be those of discs."""
    notes = _dense(frame)
    if not all(frame.periodic):
        notes.append("the box has walls: nothing is wrapped there; solid fraction and stress are of the whole box, "
                     "contacts with the walls are not in the table")  # fmt: skip
    notes += _balanced(frame) + _coulomb(frame, friction)
    lacking = [words for name, words in QUANTITIES.items() if name in frame.lacks and name not in ("xi_t", "xi_r")]
    if lacking:
        notes.append(f"not given: {', '.join(lacking)}; what needs them is undefined")
    return notes


def _dense(frame: Frame) -> list[str]:
    if "diameter" in frame.lacks:
        return []
    share = solid_fraction(frame)
    deepest = float(-frame.interactions.gap.min(initial=0.0)) if "gap" not in frame.lacks else 0.0
    if share <= 1.0:
        return []
    words = f"the area fraction is {share:.4g}, above 1, and the deepest overlap {deepest:.3g}"
    if deepest > DEEP * frame.diameter.mean() or not len(frame.interactions):
        raise InputError(f"{words}: these are no discs in a plane; three-dimensional data cannot be measured here")
    return [f"{words}: soft discs, or spheres in space"]


def _balanced(frame: Frame) -> list[str]:
    """How well the contacts balance each grain, and whether they add up to what the program summed."""
    if {"normal", "tangential"} & frame.lacks or not len(frame.interactions):
        return []
    found, mean = balance(frame), float(np.abs(frame.interactions.normal_force).mean())
    notes = [f"balance: the largest net force of the contacts on a grain is {found.largest_force / mean:.2g} of the mean |N|"]
    if "force" not in frame.lacks and found.force_difference > DIFFERS * mean:
        notes.append("the contacts do not add up to the forces on the grains in the dump, by "
                     f"{found.force_difference / mean:.2g} of the mean |N|: gravity, walls or drag act as well, or "
                     "contacts are missing")  # fmt: skip
    return notes


def _coulomb(frame: Frame, friction: float | None) -> list[str]:
    if friction is None or {"normal", "tangential"} & frame.lacks or frame.interactions.attraction.any():
        return []
    table = frame.interactions
    above = np.abs(table.tangential) > friction * np.maximum(table.normal_force, 0.0) * 1.001 + 1e-6 * np.abs(
        table.normal_force
    ).max(initial=0.0)
    if not above.any():
        return []
    return [
        f"|T| exceeds mu N in {int(above.sum())} of {len(table)} contacts: --mu {friction:g} is not the friction of these data"
    ]

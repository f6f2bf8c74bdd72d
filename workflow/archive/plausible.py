"""Whether the data of other programs can be discs in a plane with their contacts: refused, or said beside the numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workflow.analysis.build import nearest, touching_pairs
from workflow.analysis.contacts import balance, solid_fraction
from workflow.analysis.frame import QUANTITIES, Contacts, Floats, Frame
from workflow.archive.snapshots import Snapshot
from workflow.errors import ArchiveError, InputError

PLANE = 1e-6  # of a diameter: centres in one plane
DEEPEST = 0.5  # of the mean diameter of two grains; what overlaps farther is no contact
DEEP = 0.2  # of the mean diameter: no contact is overlapped that far, but in what is projected from space
APART = 1e-4  # of the mean diameter: a gap above it is no rounding of a file with six digits
DIFFERS = 1e-3  # of the mean |N|: net forces that differ by more are not rounding


def flat(block: Snapshot, z: Floats | None, diameter: Floats | None) -> None:
    """Raises InputError if the centres are not in one plane."""
    if z is None or not len(z):
        return
    size = float(diameter.min()) if diameter is not None else 1.0
    span = float(np.ptp(z))
    if span > PLANE * size:
        raise InputError(f"{block.where}: z spans {span:.4g}, {span / size:.3g} of the smallest diameter: the "
                         f"data are three-dimensional; "
                         "all measures are of discs in a plane")  # fmt: skip


def planar(known: Mapping[str, Floats], block: Snapshot) -> None:
    """Raises InputError if contact forces leave the plane."""
    if "fz" in known:
        most = float(max(np.abs(known[name]).max(initial=0.0) for name in ("fx", "fy")))
        if np.abs(known["fz"]).max(initial=0.0) > PLANE * most:
            raise InputError(f"{block.where}: contact forces have a part along z: the data are "
                             f"three-dimensional; all measures are of "
                             "discs in a plane")  # fmt: skip


def same_moment(grains: Snapshot, contacts: Snapshot) -> None:
    """Raises InputError if box or time of the two files differ: they are of different runs."""
    side = (grains.bounds[:2, 1] - grains.bounds[:2, 0]).max()
    box = np.abs(grains.bounds[:2] - contacts.bounds[:2]).max() > 1e-5 * side
    time = not np.isnan(grains.time + contacts.time) and not np.isclose(grains.time, contacts.time, rtol=1e-6)
    if box or time:
        raise InputError(f"'{grains.path}' and '{contacts.path}' have different {'boxes' if box else 'times'} "
                         f"at step {grains.step}; give "
                         "grains and contacts of one run")  # fmt: skip


def near(frame: Frame, where: str) -> None:
    """Raises InputError for pairs farther apart than they can act on each other."""
    table = frame.contacts
    if not (table.distance > 0.0).all():
        k = int(np.argmin(table.distance))
        raise ArchiveError(
            f"{where}: grains {frame.ids[table.i[k]]} and {frame.ids[table.j[k]]} have one centre; correct the file"
        )
    if "diameter" in frame.lacks or not len(table):
        return
    mean = (frame.diameter[table.i] + frame.diameter[table.j]) / 2
    k = int(np.argmin(table.distance / mean))
    if table.distance[k] < (1.0 - DEEPEST) * mean[k]:
        raise InputError(
            f"{where}: the centres of grains {frame.ids[table.i[k]]} and {frame.ids[table.j[k]]} are "
            f"{table.distance[k]:.4g} apart, "
            f"their mean diameter is {mean[k]:.4g}: no disc is overlapped that far; the lengths are of other "
            f"units, the radii diameters, "
            "or the data three-dimensional"
        )
    gap = table.distance - (frame.diameter[table.i] + frame.diameter[table.j]) / 2
    far = np.flatnonzero(gap > frame.diameter.max())
    if len(far):
        k = far[0]
        raise InputError(
            f"{where}: grains {frame.ids[table.i[k]]} and {frame.ids[table.j[k]]} are "
            f"{table.distance[k]:.4g} apart, more than two "
            f"diameters ({len(far)} such rows): the table is of another sample or step, or the columns of the ids are others"
        )


def only_interactions(table: Contacts, frame: Frame, forces_known: bool) -> tuple[Contacts, list[str]]:
    """The table without pairs that do not touch and exert no force: a list of neighbours holds such."""
    loose = table.gap > 0.0
    if forces_known:
        loose &= (table.normal_force == 0.0) & (table.tangential == 0.0) & (table.moment == 0.0)
    elif "diameter" not in frame.lacks:
        loose &= table.gap > APART * frame.diameter.mean()
    if not loose.any():
        return table, []
    return table.select(~loose), [
        f"{int(loose.sum())} of {len(table)} rows are pairs that neither touch nor act on each other; left out"
    ]


def forces(table: Contacts, block: Snapshot, attraction: float) -> list[str]:
    """Notes about the normal forces.  Raises InputError for forces that no contacts can have."""
    normal = table.normal_force
    if not len(normal):
        return []
    if not normal.any():
        raise InputError(f"{block.where}: all normal forces are 0 in {len(normal)} contacts; name the columns of the forces")
    pulling = float((normal < 0.0).mean())
    if pulling > 0.9 and attraction == 0.0 and normal.sum() < 0.0:
        raise InputError(f"{block.where}: {100 * pulling:.0f} % of the normal forces are attractive without "
                         f"--f0: forces on id_j, or i and j "
                         "exchanged? fx fy must be the force on id_i, normal above 0 where grains repel")  # fmt: skip
    if pulling > 0.0 and attraction == 0.0 and not table.attraction.any():
        return [f"{100 * pulling:.2g} % of the normal forces are attractive; without --f0 they count as viscous"]
    return []


def notes_of(frame: Frame, friction: float | None) -> list[str]:
    """What is to be said beside the numbers of a frame.  Raises InputError where they cannot be those of discs."""
    notes = _dense(frame)
    if not all(frame.periodic):
        notes.append("the box has walls: nothing is wrapped there; solid fraction and stress are of the whole "
                     "box, contacts with the walls "
                     "are not in the table")  # fmt: skip
    if len(frame.contacts) or "normal" not in frame.lacks:
        notes += _missed(frame) + _balanced(frame) + _coulomb(frame, friction)
    lacking = [words for name, words in QUANTITIES.items() if name in frame.lacks and name not in ("stretch", "rotation")]
    if lacking:
        notes.append(f"not given: {', '.join(lacking)}; what needs them is undefined")
    return notes


def _dense(frame: Frame) -> list[str]:
    if "diameter" in frame.lacks:
        return []
    share = solid_fraction(frame)
    deepest = float(-frame.contacts.gap.min(initial=0.0)) if "gap" not in frame.lacks else 0.0
    if share <= 1.0:
        return []
    words = f"the area fraction is {share:.4g}, above 1, and the deepest overlap {deepest:.3g}"
    if deepest > DEEP * frame.diameter.mean() or not len(frame.contacts):
        raise InputError(f"{words}: these are no discs in a plane; three-dimensional data cannot be measured here")
    return [f"{words}: soft discs, or spheres in space"]


def _missed(frame: Frame) -> list[str]:
    """Discs that overlap and are not in the table."""
    if {"diameter", "gap"} & frame.lacks or 2.0 * frame.diameter.max() >= frame.cell[list(frame.periodic)].min(initial=np.inf):
        return []
    i, j = touching_pairs(frame.position, frame.diameter, frame.cell, periodic=frame.periodic)
    table, count = frame.contacts, frame.grains
    apart = nearest(frame.position[j] - frame.position[i], np.where(frame.periodic, frame.cell, np.inf))
    depth = (frame.diameter[i] + frame.diameter[j]) / 2 - np.hypot(*apart.T)
    missed = ~np.isin(i * count + j, table.i * count + table.j) & (depth > APART * frame.diameter.mean())
    if not missed.any():
        return []
    k = int(np.argmax(np.where(missed, depth, 0.0)))
    if 2 * int(missed.sum()) > len(i):
        raise InputError(f"{int(missed.sum())} of {len(i)} pairs of discs that overlap are not in the table of "
                         f"contacts, deepest "
                         f"{frame.ids[i[k]]} and {frame.ids[j[k]]} by {depth[k]:.3g}: it is of another step, or "
                         f"incomplete")  # fmt: skip
    return [f"{int(missed.sum())} pairs of discs overlap and are not in the table of contacts, deepest {frame.ids[i[k]]} and "
            f"{frame.ids[j[k]]} by {depth[k]:.3g}: they are not counted"]  # fmt: skip


def _balanced(frame: Frame) -> list[str]:
    """How well the contacts balance each grain, and whether they add up to what the program summed."""
    if {"normal", "tangential"} & frame.lacks or not len(frame.contacts):
        return []
    found, mean = balance(frame), float(np.abs(frame.contacts.normal_force).mean())
    notes = [f"balance: the largest net force of the contacts on a grain is {found.largest_force / mean:.2g} of the mean |N|"]
    if "force" not in frame.lacks and found.force_difference > DIFFERS * mean:
        notes.append(f"the contacts do not add up to the forces on the grains in the dump, by "
                     f"{found.force_difference / mean:.2g} of the mean |N|: "
                     "gravity, walls or drag act as well, or contacts are missing")  # fmt: skip
    return notes


def _coulomb(frame: Frame, friction: float | None) -> list[str]:
    if friction is None or {"normal", "tangential"} & frame.lacks or frame.contacts.attraction.any():
        return []
    table = frame.contacts
    above = np.abs(table.tangential) > friction * np.maximum(table.normal_force, 0.0) * 1.001 + 1e-6 * np.abs(
        table.normal_force
    ).max(initial=0.0)
    if not above.any():
        return []
    return [
        f"|T| exceeds mu N in {int(above.sum())} of {len(table)} contacts: --mu {friction:g} is not the friction of these data"
    ]

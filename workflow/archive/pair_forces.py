"""Forces of a contact table: N and T from the columns there are, what slides, and what of it is lacking."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from workflow.archive import plausible
from workflow.archive.columns import Reading
from workflow.archive.snapshots import Snapshot
from workflow.data.frame import PARTS, Floats
from workflow.errors import ArchiveError

CENTRAL = 1e-3  # |T| below this share of the largest |N| is the rounding of a force along the branch
SLIDES = 1e-3  # how close to the Coulomb limit a contact slides: with six digits T and N are known to 1e-4

Known = dict[str, Floats]


def forces_of(
    known: Known, branch: Floats, gap: Floats | None, block: Snapshot, reading: Reading
) -> tuple[dict[str, Floats], set[str]]:
    """The parts of N, and T, with what is lacking of them (zero here); ``gap``: None where it is unknown."""
    count = len(branch)
    apart = gap >= 0.0 if gap is not None else np.zeros(count, dtype=bool)
    vector = _of_vector(known, branch, block, reading) if {"fx", "fy"} <= set(known) else None
    parts = [known[name] for name in PARTS] if set(PARTS) <= set(known) else None
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
        forces = dict(zip(PARTS, parts, strict=True))
    else:
        normal = given[chosen] if chosen else zero
        assert normal is not None
        # with the law of --f0 a contact is attracted by F0, a pair at a distance by its whole force
        attraction = np.where(apart, np.minimum(normal, 0.0), -reading.attraction) if reading.attraction else zero
        rest = normal - attraction
        forces = {"elastic": np.maximum(rest, 0.0), "viscous": np.minimum(rest, 0.0), "attraction": attraction}
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
            raise ArchiveError(f"{block.where}: {names[0]} and {other} give different normal forces; name the columns that "
                               "count with --columns, such as normal=normal")  # fmt: skip
    return names[-1] if names and names[-1].startswith("elastic") else names[0] if names else None


def _of_vector(known: Known, branch: Floats, block: Snapshot, reading: Reading) -> tuple[Floats, Floats]:
    """N and T from the force on i, fx fy, and its tangential part tx ty where that comes apart."""
    n = branch / np.hypot(*branch.T)[:, None] if len(branch) else branch
    t = np.column_stack((-n[:, 1], n[:, 0]))
    force = -np.column_stack((known["fx"], known["fy"]))  # of i on j
    plausible.planar(known, block)
    meant = {"fx", "tx"} <= set(reading.names) or "fx" not in reading.names  # tx ty go with these fx fy
    if {"tx", "ty"} <= set(known):
        scale = float(np.abs(force).max(initial=0.0))
        oblique = np.abs((force * t).sum(axis=1)) > 10 * CENTRAL * scale
        if oblique.any() and not meant:
            return (force * n).sum(axis=1), (force * t).sum(axis=1)
        if oblique.any() and (known["tx"].any() or known["ty"].any()):
            raise ArchiveError(
                f"{block.where}: fx fy are not along the line of centres in {int(oblique.sum())} rows, so that they hold "
                "the tangential part; leave tx ty out (or give the normal part as fx fy)"
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


def rest_of(known: Known, forces: Mapping[str, Floats], lacks: set[str], reading: Reading) -> dict[str, Any]:
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
        "moment": known.get("moment", zero), "xi_t": known.get("du", zero), "xi_r": known.get("dtheta", zero),
        "sliding": sliding, "rolling": known.get("rolling", zero) != 0,
    }  # fmt: skip

"""The contact table of a run under one of LAMMPS's own laws (`common/contact_table_lammps.in`), as interactions.

LAMMPS tells the force along the line of centres and the tangential one.  The elastic part is K_N (-h) and the attraction that
of G07 eqs. 4, 5, both known from the gap; what is left of N is the viscous part.  Elastic displacements it does not tell.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workflow.archive.dumps import Block, rows_of
from workflow.data.build import nearest
from workflow.data.contact_law import ContactLaw
from workflow.data.files import PathLike
from workflow.data.frame import Floats, Frame, Interactions, without
from workflow.data.text import whole_numbers
from workflow.errors import ArchiveError

COLUMNS = ("id_i", "id_j", "fx", "fy", "tx", "ty")
ROLLING = ("rx", "ry")  # of a law with rolling springs
LACKS = ("xi_t", "xi_r")
# share of its limit from which a spring counts as being there: forces are those of the present velocities
AT_LIMIT = 1.0 - 1e-3


@dataclass(frozen=True)
class LammpsLaw:
    """What LAMMPS was told: ``law``, and the radius R_i R_j/(R_i + R_j) at which its rolling spring is that of the law."""

    law: ContactLaw
    pair_radius: float


def with_lammps_contacts(block: Block, frame: Frame, told: LammpsLaw, path: PathLike) -> Frame:
    """``frame`` with the interactions of ``block``, and without what LAMMPS does not tell of them; raises ArchiveError."""
    return without(replace(frame, interactions=interactions_of(block, frame, told, path)), LACKS)


def interactions_of(block: Block, frame: Frame, told: LammpsLaw, path: PathLike) -> Interactions:
    """The interactions of ``block`` between the grains of ``frame``, each pair once, i < j; raises ArchiveError.

    With F and T on the first grain as LAMMPS gives them, n from i to j and t = n turned by +90 degrees: N = -F.n, T = -T.t of i
    on j; the rolling force r of ``granular``, which acts at R* = R_i R_j/(R_i + R_j), is a moment R* (n x r) of i on j.
    """
    missing = [name for name in COLUMNS if name not in block.columns]
    if missing:
        raise ArchiveError(f"{path}, line {block.line}: column {', '.join(missing)} missing in {' '.join(block.columns)}; "
                           "correct the dump command of the deck")  # fmt: skip
    known, law, where = block.named, told.law, f"{path}, step {block.step}"
    ends = [rows_of(whole_numbers(known[name], f"{where}: grain id"), frame.ids, where) for name in ("id_i", "id_j")]
    cell = np.where(frame.periodic, frame.cell, np.inf)
    branch = nearest(frame.position[ends[1]] - frame.position[ends[0]], cell)
    distance = np.hypot(*branch.T)
    gap = distance - (frame.diameter[ends[0]] + frame.diameter[ends[1]]) / 2
    kept = (gap < 0.0) | (gap < law.cutoff_gap)
    swap = (ends[0] > ends[1])[kept]
    i, j = (np.where(swap, b[kept], a[kept]) for a, b in (ends, ends[::-1]))
    order = np.lexsort((j, i))

    def pick(values: NDArray[Any]) -> NDArray[Any]:
        return np.ascontiguousarray(values[kept][order])

    n = branch / np.where(distance > 0.0, distance, 1.0)[:, None]
    normal = -(known["fx"] * n[:, 0] + known["fy"] * n[:, 1])
    tangential = known["tx"] * n[:, 1] - known["ty"] * n[:, 0]
    radius = frame.diameter / 2
    arm = radius[ends[0]] * radius[ends[1]] / (radius[ends[0]] + radius[ends[1]])
    turning = np.zeros(len(gap))
    if set(ROLLING) <= set(block.columns):
        turning = arm * (n[:, 0] * known["ry"] - n[:, 1] * known["rx"])
    attraction = _attraction(gap, law)
    elastic = law.kn * np.maximum(-gap, 0.0)
    pressed = np.abs(normal - attraction)  # of which the limits are shares
    sign = np.where(swap, -1.0, 1.0)[order]
    unknown = np.full(len(order), np.nan)
    return Interactions(
        i=i[order], j=j[order], branch=pick(branch) * sign[:, None], gap=pick(gap), elastic=pick(elastic),
        viscous=pick(np.where(gap < 0.0, normal - attraction - elastic, 0.0)), attraction=pick(attraction),
        tangential=pick(tangential), moment=pick(turning) * sign, xi_t=unknown, xi_r=unknown,
        sliding=pick((gap < 0.0) & (law.mu > 0.0) & (np.abs(tangential) >= AT_LIMIT * law.mu * pressed)),
        rolling=pick((gap < 0.0) & law.rolling & (np.abs(turning) >= AT_LIMIT * law.mur * arm / told.pair_radius * pressed)),
    )  # fmt: skip


def _attraction(gap: Floats, law: ContactLaw) -> Floats:
    """-F0 in contact, -F0 (1 - h/D0) up to h = D0 (G07 eqs. 4, 5)."""
    if not law.cutoff_gap:
        return np.zeros(len(gap))
    return -law.f0 * np.clip(1.0 - gap / law.d0, 0.0, 1.0)

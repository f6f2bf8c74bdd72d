"""Rigidity matrix G and stiffness matrix K of a frame's interaction network (G07 appendix A).

Columns are U = (u_i, theta_i)_i, then eps_1, eps_2 for a free cell, with u_i the displacement beyond the affine motion
-eps.r_i (compression positive).  Rows are the relative displacements of the interactions: normal (approach positive),
tangential and rolling (A1-A3).  Forces f along the rows balance the load G^T f (A5).

Lever arms: the grains touch at the point that divides the branch in the ratio of the radii, so arm_i = R_i
|r_ij|/(R_i + R_j) instead of R_i.  The relative difference is the overlap (1e-5 at kappa = 1e5), but with it the
rigid rotation of a cluster and the counter-rotation of grains in even loops leave every contact exactly at rest,
which the counts of the paper (kappa = 3 and H = 1 for the four discs of fig. 13) take for granted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array, diags_array, vstack

from workflow.data.contact_law import ContactLaw
from workflow.data.frame import Floats, Frame, Ints
from workflow.errors import InputError

TRANSLATIONS = 2  # global motions that a periodic cell always leaves


@dataclass(frozen=True)
class Degrees:
    """Book of degrees of freedom: N grains, N_c contacts, N_d distant pairs, and what they are allowed to do."""

    grains: int
    contacts: int
    distant: int
    friction: bool
    rolling: bool
    free_cell: bool

    @property
    def per_grain(self) -> int:
        """Degrees of freedom of a grain: 3, or 2 without friction (rotations then play no part)."""
        return 3 if self.friction else 2

    @property
    def cell(self) -> int:
        """Degrees of freedom of the cell: 2 when free, else 0."""
        return 2 if self.free_cell else 0

    @property
    def columns(self) -> int:
        """N_f = per_grain N + cell."""
        return self.per_grain * self.grains + self.cell

    @property
    def per_contact(self) -> int:
        """Relative displacements of a contact: normal, + tangential with friction, + rolling."""
        return 1 + self.friction + self.rolling

    @property
    def rows(self) -> int:
        """M = per_contact N_c + N_d."""
        return self.per_contact * self.contacts + self.distant


def degrees(frame: Frame, *, friction: bool, rolling: bool = False, free_cell: bool = False) -> Degrees:
    """The book of ``frame``; raises InputError for rolling resistance without friction or a frame without grains."""
    if rolling and not friction:
        raise InputError("rolling: True with friction False; rolling resistance needs rotations, set friction to True")
    if not frame.grains:
        raise InputError("frame: 0 grains; rigidity needs at least one, choose another frame")
    in_contact = int(np.count_nonzero(frame.interactions.in_contact))
    return Degrees(frame.grains, in_contact, len(frame.interactions) - in_contact, friction, rolling, free_cell)


def row_owners(frame: Frame, book: Degrees) -> Ints:
    """Interaction of every row of G, (M,) int64: all normal rows, then the contacts' tangential and rolling rows."""
    in_contact = np.flatnonzero(frame.interactions.in_contact)
    return np.concatenate([np.arange(len(frame.interactions)), *[in_contact] * (book.per_contact - 1)])


def closed_branches(frame: Frame) -> Floats:
    """Branch vectors rebuilt from the positions, (M, 2): around every loop they add up to zero to the last digit.

    Branches stored with fewer digits would not, and a rounding of 1e-8 is enough to keep a free cluster from rotating.
    Raises InputError if two interacting grains have the same centre.
    """
    pairs = frame.interactions
    straight = frame.position[pairs.j] - frame.position[pairs.i]
    branches = straight + frame.cell * np.round((pairs.branch - straight) / frame.cell)
    lost = np.flatnonzero(~(np.abs(branches).max(axis=1, initial=0.0) > 0.0))
    if len(lost):
        i, j = frame.ids[pairs.i[lost[0]]], frame.ids[pairs.j[lost[0]]]
        raise InputError(f"contacts: grains {i} and {j} are at the same place, their normal is undefined; separate them")
    return branches


def rigidity_matrix(frame: Frame, book: Degrees, length: float = 1.0) -> csr_array:
    """Rigidity matrix G, (M, N_f) (G07 A1-A3), for lengths measured in units of ``length``.

    Normal row n.(u_i - u_j + eps.r_ij); tangential row t.(u_i - u_j + eps.r_ij) + arm_i theta_i + arm_j theta_j
    (contacts, with friction); rolling row theta_i - theta_j (contacts, with rolling resistance).  Order of rows:
    ``row_owners``.
    """
    pairs, branch = frame.interactions, closed_branches(frame) / length
    distance = np.hypot(branch[:, 0], branch[:, 1])
    n = branch / distance[:, None]
    t = np.column_stack((-n[:, 1], n[:, 0]))
    blocks = [_rows(frame, book, np.arange(len(n)), n, branch)]
    in_contact = np.flatnonzero(pairs.in_contact)
    if book.friction:
        arms = frame.diameter[np.column_stack((pairs.i, pairs.j))]
        arms *= (distance / arms.sum(axis=1))[:, None]
        blocks.append(_rows(frame, book, in_contact, t, branch, arms))
    if book.rolling:
        blocks.append(_rows(frame, book, in_contact, np.zeros_like(t), branch, np.tile([1.0, -1.0], (len(t), 1))))
    return csr_array(vstack(blocks))


def _rows(frame: Frame, book: Degrees, chosen: Ints, axis: Floats, branch: Floats, spins: Floats | None = None) -> csr_array:
    """One row per chosen interaction: axis.(u_i - u_j + eps.branch) + spins.(theta_i, theta_j)."""
    first, second = book.per_grain * frame.interactions.i[chosen], book.per_grain * frame.interactions.j[chosen]
    columns, values = [first, first + 1, second, second + 1], [*axis[chosen].T, *-axis[chosen].T]
    if spins is not None:
        columns += [first + 2, second + 2]
        values += [*spins[chosen].T]
    if book.free_cell:
        last = np.full(len(chosen), book.columns - 1)
        columns += [last - 1, last]
        values += [*(axis * branch)[chosen].T]
    entries = np.concatenate(values), (np.tile(np.arange(len(chosen)), len(columns)), np.concatenate(columns))
    rows = coo_array(entries, shape=(len(chosen), book.columns)).tocsr()  # adds up entries of a grain and its image
    rows.eliminate_zeros()
    return rows


def stiffness_matrix(frame: Frame, book: Degrees, law: ContactLaw, length: float = 1.0) -> csc_array:
    """Stiffness matrix K = G^T k G, (N_f, N_f) (G07 A6): the Hessian of the elastic energy at zero prestress.

    k is diagonal: K_N or, for distant pairs, -F0/D0; K_T; K_r.  Prestress corrections are left out, as in the paper.
    ``length``: unit of length, as in ``rigidity_matrix`` (K then has the unit of a force over a length throughout).
    Raises InputError if a stiffness that the book needs is zero.
    """
    for name, needed in (("kt", book.friction), ("kr", book.rolling)):
        if needed and not getattr(law, name):
            raise InputError(f"law: '{name}' is 0 but the network resists that motion; give a positive stiffness")
    matrix = rigidity_matrix(frame, book, length)
    kinds = np.repeat([law.kt, law.kr / length**2], [book.contacts * book.friction, book.contacts * book.rolling])
    normal = np.where(frame.interactions.in_contact, law.kn, law.tail_stiffness)
    return csc_array(matrix.T @ diags_array(np.concatenate((normal, kinds))) @ matrix)

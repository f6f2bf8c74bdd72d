"""Degrees of hyperstaticity and of mechanism of an interaction network, its floppy modes and its states of self-stress.

k = dim null(G) counts independent motions that leave every contact at rest, the two global translations of a periodic
cell included; H = dim null(G^T) counts independent systems of self-balanced forces (G07 appendix A).  G and G^T are
factorised separately and the rank is counted a third time from the inertia of G^T G, so that N_f + H = M + k and its
printed forms (19), (21), (22) are checks and not definitions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array, csr_array
from scipy.sparse.csgraph import connected_components

from workflow.data.contact_law import ContactLaw
from workflow.data.frame import Bools, Floats, Frame, Ints
from workflow.errors import WorkflowError
from workflow.measures.clusters import bridges
from workflow.measures.network import (
    TRANSLATIONS,
    Degrees,
    degrees,
    rigidity_matrix,
    row_owners,
    stiffness_matrix,
)
from workflow.measures.sparse_rank import Factorisation, dissect, eigenvalues_below, factorise

# Squared singular values of G (lengths in mean diameters) below this are zero; round-off leaves about 1e-15.
ZERO = 1e-14
MARGINAL = 1e-8  # negative eigenvalues of K count as unstable beyond this share of K_N


@dataclass(frozen=True)
class Rigidity:
    """Counts of a network (G07 sec. IV B 2 and appendix A).

    ``hyperstaticity`` H; ``floppy_modes`` k, the two translations included; ``cell_degrees`` 2 for a free cell, else
    0; ``positive_definite``: K resists every motion except the translations; ``unstable_modes``: directions in which
    K is negative (only distant pairs can cause them).  ``smallest_pivot`` and ``largest_residue``: the smallest pivot
    taken as nonzero and the largest taken as zero, the gap that makes the counts trustworthy.

    The backbone: the largest part of the network that no single contact holds together (with rolling resistance one contact
    is enough; a distant pair never is), of ``backbone_grains``.  Left out are loose grains, clusters that float in holes, and
    whatever hangs on one contact and so rolls around it.  ``backbone_mechanisms``: its floppy modes beyond the
    translations; ``positive_definite_backbone``: it has none and no unstable mode.
    """

    grains: int
    contacts: int
    distant: int
    friction: bool
    rolling: bool
    hyperstaticity: int
    floppy_modes: int
    cell_degrees: int
    positive_definite: bool
    unstable_modes: int
    smallest_pivot: float
    largest_residue: float
    backbone_grains: int
    backbone_mechanisms: int
    positive_definite_backbone: bool

    @property
    def mechanisms(self) -> int:
        """Floppy modes beyond the two translations, k - 2."""
        return self.floppy_modes - TRANSLATIONS

    def as_dict(self) -> dict[str, int | float | bool | None]:
        """Plain values under stable names, for JSON; the smallest pivot of a network without contacts is None."""
        return vars(self) | {"smallest_pivot": self.smallest_pivot if np.isfinite(self.smallest_pivot) else None}


def rigidity(
    frame: Frame, *, law: ContactLaw, friction: bool = True, rolling: bool = False, free_cell: bool = False
) -> Rigidity:
    """Rigidity analysis of ``frame``: see ``Rigidity``.

    ``friction``, ``rolling``: contacts transmit tangential forces, rolling moments; sliding contacts count as
    sticking (G07 appendix A).  Raises InputError for unusable arguments and WorkflowError if the three counts of the
    rank differ, which happens only if the network is so close to a singular geometry that rounding decides.
    """
    book = degrees(frame, friction=friction, rolling=rolling, free_cell=free_cell)
    matrix = dimensionless(frame, book)
    order, parents = grain_order(frame, book)
    motions = factorise(matrix, order, parents)
    forces = factorise_forces(frame, book, matrix)
    coupling = cell_coupling(forces, matrix, book)
    hyperstaticity = forces.nullity - coupling_rank(coupling)
    soft = eigenvalues_below(csc_array(matrix.T @ matrix), ZERO, np.concatenate(order))
    _check_identities(book, hyperstaticity, motions, soft)
    unstable = _unstable_modes(frame, book, law, motions)
    definite = motions.nullity == TRANSLATIONS and unstable == 0
    kept = _backbone(frame, rolling)
    mechanisms, rigid = motions.nullity - TRANSLATIONS, definite
    if not kept.all():
        mechanisms, rigid = _alone(frame.select(kept), law, free_cell, friction, rolling)
    return Rigidity(
        grains=book.grains,
        contacts=book.contacts,
        distant=book.distant,
        friction=friction,
        rolling=rolling,
        hyperstaticity=hyperstaticity,
        floppy_modes=motions.nullity,
        cell_degrees=book.cell,
        positive_definite=definite,
        unstable_modes=unstable,
        smallest_pivot=min(motions.smallest_live, forces.smallest_live),
        largest_residue=max(motions.largest_dead, forces.largest_dead),
        backbone_grains=int(kept.sum()),
        backbone_mechanisms=mechanisms,
        positive_definite_backbone=rigid,
    )


def length_unit(frame: Frame) -> float:
    """Unit of length that brings all entries of G to order one: the mean diameter."""
    return float(np.mean(frame.diameter))


def dimensionless(frame: Frame, book: Degrees) -> csr_array:
    """G for lengths in units of ``length_unit``."""
    return rigidity_matrix(frame, book, length_unit(frame))


def grain_order(frame: Frame, book: Degrees) -> tuple[list[Ints], list[int]]:
    """Elimination blocks of the columns of G by nested dissection of the grains; the strains come last."""
    incidence = incidence_matrix(frame)
    blocks, parents = dissect(frame.position, csr_array(incidence.T @ incidence))
    columns = [(book.per_grain * nodes[:, None] + np.arange(book.per_grain)).ravel() for nodes in blocks]
    columns[-1] = np.concatenate((columns[-1], np.arange(book.columns - book.cell, book.columns)))
    return columns, parents


def factorise_forces(frame: Frame, book: Degrees, matrix: csr_array) -> Factorisation:
    """Factorised balance of the grains, the rows of G^T without those of the cell (they would join all contacts)."""
    incidence = incidence_matrix(frame)
    middle = frame.position[frame.interactions.i] + 0.5 * frame.interactions.branch
    blocks, parents = dissect(middle, csr_array(incidence @ incidence.T))
    owners = row_owners(frame, book)
    order = np.argsort(owners, kind="stable")
    starts = np.searchsorted(owners[order], np.arange(len(frame.interactions) + 1))
    rows = [np.concatenate([order[:0], *(order[starts[c] : starts[c + 1]] for c in nodes)]) for nodes in blocks]
    return factorise(csr_array(matrix[:, : book.columns - book.cell].T), rows, parents)


def incidence_matrix(frame: Frame) -> csr_array:
    """(interactions, grains), 1 where the interaction holds the grain."""
    pairs = np.arange(len(frame.interactions))
    row, column = np.tile(pairs, 2), np.concatenate((frame.interactions.i, frame.interactions.j))
    return csr_array((np.ones(len(row)), (row, column)), shape=(len(pairs), frame.grains))


def cell_coupling(forces: Factorisation, matrix: csr_array, book: Degrees) -> Floats:
    """Stress (cell degrees, nullity) of the unit self-balanced systems of the grains; a free cell allows none."""
    if not book.cell:
        return np.zeros((0, forces.nullity))
    return forces.times_null_space(matrix[:, -book.cell :].toarray().T)


def coupling_rank(coupling: Floats) -> int:
    """Number of independent stresses in ``coupling``, by which a free cell reduces H."""
    return int(np.linalg.matrix_rank(coupling, tol=ZERO**0.5)) if coupling.size else 0


def _unstable_modes(frame: Frame, book: Degrees, law: ContactLaw, motions: Factorisation) -> int:
    """Negative eigenvalues of K; without distant pairs K is a sum of squares and has none.

    K is taken on the independent columns of G, which removes null(G), translations included, and changes no other sign.
    The small shift keeps single pivots from vanishing (n contacts against -F0/D0 = -n K_N would make one exactly zero).
    """
    stiffness = stiffness_matrix(frame, book, law, length_unit(frame)) / law.kn
    return eigenvalues_below(stiffness, -MARGINAL, motions.independent) if book.distant else 0


def _backbone(frame: Frame, rolling: bool) -> Bools:
    """Grains of the backbone, (N,); see `Rigidity`."""
    holds = ~(bridges(frame) & ~frame.interactions.in_contact) if rolling else ~bridges(frame)
    edges = (np.ones(int(holds.sum())), (frame.interactions.i[holds], frame.interactions.j[holds]))
    label = connected_components(csr_array(edges, shape=(frame.grains, frame.grains)), directed=False)[1]
    return label == np.bincount(label).argmax()


def _alone(part: Frame, law: ContactLaw, free_cell: bool, friction: bool, rolling: bool) -> tuple[int, bool]:
    """Mechanisms of a part of a network on its own, and whether its K is positive definite."""
    book = degrees(part, friction=friction, rolling=rolling, free_cell=free_cell)
    motions = factorise(dimensionless(part, book), *grain_order(part, book))
    mechanisms = motions.nullity - TRANSLATIONS
    return mechanisms, mechanisms == 0 and _unstable_modes(part, book, law, motions) == 0


def _check_identities(book: Degrees, hyperstaticity: int, motions: Factorisation, soft: int) -> None:
    """N_f + H = M + k for the separately counted k and H, (19), (21), (22), and the inertia of G^T G."""
    left, right = book.columns + hyperstaticity, book.rows + motions.nullity
    if left != right or soft != motions.nullity:
        number = "21" if book.rolling else "19" if book.friction else "22"
        raise WorkflowError(
            f"rigidity: N_f + H = {left} but M + k = {right} (G07 eq. {number}), and {soft} eigenvalues of G^T G "
            f"vanish where k = {motions.nullity}; smallest pivot {motions.smallest_live:.1e}, largest residue "
            f"{motions.largest_dead:.1e}: the geometry is too close to singular to be counted in double precision, "
            "take another frame"
        )

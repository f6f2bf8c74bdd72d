"""Floppy modes and states of self-stress of an interaction network: bases of null(G) and null(G^T) (G07 appendix A)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import inv, null_space, qr
from scipy.sparse import coo_array, csc_array, csr_array
from scipy.sparse.csgraph import connected_components

from workflow.data.frame import Floats, Frame, Ints
from workflow.errors import InputError, WorkflowError
from workflow.measures.network import TRANSLATIONS, degrees, row_owners
from workflow.measures.rigidity import (
    cell_coupling,
    coupling_rank,
    dimensionless,
    factorise_forces,
    grain_order,
    incidence_matrix,
    length_unit,
)
from workflow.measures.sparse_rank import Factorisation, factorise

MOST_MECHANISMS = 5000  # of which a dense product is formed (200 MB)
ROWS_AT_ONCE = 2000  # of the dense product with a basis: 80 MB
CARRIES = 1e-9  # a row carries self-stress if its entry exceeds this share of the largest one
COMBINATIONS = 4  # random ones that find the rows that carry self-stress; one is enough but for rounding


@dataclass(frozen=True)
class FloppyModes:
    """Orthonormal motions without relative displacement, orthogonal to the translations (m = k - 2 of them).

    ``grains`` (m, N, 3): u_1, u_2 and theta (zero without friction); ``cell`` (m, 2): eps_1, eps_2 (zero if fixed).
    """

    grains: Floats
    cell: Floats


@dataclass(frozen=True)
class Mobility:
    """``mechanisms`` k - 2; ``grains`` (N,): mean square motion of each grain over all of them (u_1, u_2, theta d).

    The values add up to k - 2; a grain without contacts has 3 - 2/N (2 - 2/N without friction), a rigid backbone none.
    """

    mechanisms: int
    grains: Floats


@dataclass(frozen=True)
class SelfStress:
    """Systems of self-balanced forces, as local as the network allows.

    ``normal``, ``tangential``, ``moment``: sparse (H, interactions), each row one independent system (G07 signs: n
    from i to j, repulsion positive); a basis, neither orthogonal nor normalised.  ``clusters`` (interactions,) int64:
    number of the hyperstatic cluster an interaction belongs to, -1 if no self-stress passes through it; two
    interactions belong to the same cluster if grains and self-stressed interactions connect them.  Largest cluster
    first.
    """

    normal: csr_array
    tangential: csr_array
    moment: csr_array
    clusters: Ints


def floppy_modes(frame: Frame, *, friction: bool = True, rolling: bool = False, free_cell: bool = False) -> FloppyModes:
    """Orthonormal basis of the floppy modes beyond the translations; dense, so meant for a few hundred modes.

    The scalar product is the sum over u_1, u_2, theta d and eps d, with d the mean diameter; returned in the frame's
    units.
    """
    book = degrees(frame, friction=friction, rolling=rolling, free_cell=free_cell)
    factorised = factorise(dimensionless(frame, book), *grain_order(frame, book))
    basis = qr(factorised.null_space().toarray(), mode="economic")[0]
    translations = np.zeros((book.columns, TRANSLATIONS))
    for axis in range(TRANSLATIONS):
        translations[axis : book.per_grain * book.grains : book.per_grain, axis] = 1.0
    modes = (basis @ null_space((basis.T @ translations).T)).T
    grains = np.zeros((len(modes), book.grains, 3))
    grains[:, :, : book.per_grain] = modes[:, : book.columns - book.cell].reshape(-1, book.grains, book.per_grain)
    cell = modes[:, book.columns - book.cell :] if book.cell else np.zeros((len(modes), 2))
    length = length_unit(frame)
    return FloppyModes(grains / [1.0, 1.0, length], cell / length)


def mobility(frame: Frame, *, friction: bool = True, rolling: bool = False) -> Mobility:
    """How much each grain takes part in the mechanisms of the fixed cell, whatever basis describes them: see `Mobility`.

    The diagonal of the projector B (B^T B)^-1 B^T on the null space B of G, less that on the translations.  Raises
    InputError for more than MOST_MECHANISMS of them (B^T B is dense), WorkflowError if its trace is not their number.
    """
    book = degrees(frame, friction=friction, rolling=rolling)
    basis = csr_array(factorise(dimensionless(frame, book), *grain_order(frame, book)).null_space())
    count = basis.shape[1]
    if count > MOST_MECHANISMS:
        raise InputError(
            f"mobility: {count} mechanisms, at most {MOST_MECHANISMS} fit; leave grains without contacts out (`without_loose`)"
        )
    basis = csr_array(basis / np.sqrt((basis**2).sum(axis=0)))
    inverse = inv((basis.T @ basis).toarray())
    rows = (basis[first : first + ROWS_AT_ONCE] for first in range(0, book.columns, ROWS_AT_ONCE))
    share = np.concatenate([np.asarray(part.multiply(part @ inverse).sum(axis=1)).ravel() for part in rows])
    if not abs(share.sum() - count) < 1e-3:  # the trace of a projector; also catches NaN
        raise WorkflowError(f"mobility: the shares add up to {share.sum():.6g}, not to {count} mechanisms; take another frame")
    grains = share.reshape(book.grains, book.per_grain).sum(axis=1) - TRANSLATIONS / book.grains
    return Mobility(count - TRANSLATIONS, np.maximum(grains, 0.0))


def without_loose(frame: Frame) -> Frame:
    """``frame`` without the grains that interact with none: their free motions say nothing about the network."""
    held = np.zeros(frame.grains, dtype=bool)
    held[frame.interactions.i] = held[frame.interactions.j] = True
    return frame.select(held)


def self_stress(frame: Frame, *, friction: bool = True, rolling: bool = False, free_cell: bool = False) -> SelfStress:
    """Basis of the self-balanced contact forces and the hyperstatic clusters that carry them: see ``SelfStress``."""
    book = degrees(frame, friction=friction, rolling=rolling, free_cell=free_cell)
    matrix = dimensionless(frame, book)
    forces = factorise_forces(frame, book, matrix)
    basis = coo_array(_without_stress(forces.null_space(), cell_coupling(forces, matrix, book)))
    owners = row_owners(frame, book)
    kinds = np.repeat(range(3), [len(frame.interactions), book.contacts * book.friction, book.contacts * book.rolling])
    shape, parts = (basis.shape[1], len(frame.interactions)), []
    for kind in range(3):
        here = kinds[basis.row] == kind
        parts.append(csr_array((basis.data[here], (basis.col[here], owners[basis.row[here]])), shape=shape))
    normal, tangential, moment = parts
    carrying = _carrying(owners, forces, cell_coupling(forces, matrix, book))
    return SelfStress(normal, tangential, moment * length_unit(frame), _clusters(frame, carrying))


def hyperstatic_clusters(frame: Frame, *, friction: bool = True, rolling: bool = False) -> tuple[Ints, Ints]:
    """``clusters`` as in `SelfStress` (fixed cell) and the degree of hyperstaticity of each, without a basis.

    Memory as for the counts alone, where a basis of a large cluster would fill it: a random combination of all systems of
    self-balanced forces vanishes only where all of them do.
    """
    book = degrees(frame, friction=friction, rolling=rolling)
    matrix = dimensionless(frame, book)
    forces = factorise_forces(frame, book, matrix)
    owners = row_owners(frame, book)
    clusters = _clusters(frame, _carrying(owners, forces, cell_coupling(forces, matrix, book)))
    return clusters, np.bincount(clusters[owners[forces.dependent]], minlength=int(clusters.max(initial=-1)) + 1)


def _without_stress(basis: csc_array, coupling: Floats) -> csc_array:
    """Combinations of the columns of ``basis`` with zero ``coupling``: pivot systems balance those that have any."""
    rank = coupling_rank(coupling)
    if not rank:
        return basis
    _, upper, order = qr(coupling, mode="economic", pivoting=True)
    combine = np.linalg.solve(upper[:rank, :rank], upper[:rank, rank:])
    combine[np.abs(combine) < CARRIES] = 0.0
    return csc_array(basis[:, order[rank:]] - basis[:, order[:rank]] @ csc_array(combine))


def _carrying(owners: Ints, forces: Factorisation, coupling: Floats) -> Ints:
    """Interactions that can carry self-stress, from random combinations of the systems with zero ``coupling``."""
    weights = np.random.default_rng(0).standard_normal((forces.nullity, COMBINATIONS))
    if coupling.size:
        weights -= np.linalg.lstsq(coupling, coupling @ weights, rcond=None)[0]
    size = np.abs(forces.combine_null_space(weights)).max(axis=1, initial=0.0)
    return np.unique(owners[size > CARRIES * size.max(initial=0.0)])


def _clusters(frame: Frame, carrying: Ints) -> Ints:
    """Number of the connected self-stressed cluster of every interaction, -1 for none, largest first."""
    incidence = incidence_matrix(frame)[carrying]
    count, label = connected_components(incidence @ incidence.T, directed=False)
    by_size = np.argsort(-np.bincount(label, minlength=count), kind="stable")
    clusters = np.full(len(frame.interactions), -1, dtype=np.int64)
    clusters[carrying] = np.argsort(by_size)[label]
    return clusters

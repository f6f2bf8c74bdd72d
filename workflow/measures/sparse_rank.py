"""Rank, null space and inertia of large sparse matrices whose graph lies in the plane, with NumPy and SciPy alone.

Two methods that share no arithmetic:

* ``factorise``: multifrontal rank-revealing QR.  Columns are eliminated block by block along a nested dissection of the
  plane; inside each dense front a column-pivoted Householder QR finds the columns that depend on the others.  It works
  on the matrix itself, so singular values are not squared, and the dependent columns give a sparse null-space basis.
* ``eigenvalues_below``: inertia of a symmetric matrix from the signs of the pivots of its L D L^T (Sylvester's law).

SuiteSparseQR would do the first task, but its Python bindings have no wheels and need the C library and its headers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import get_lapack_funcs, qr, solve_triangular
from scipy.sparse import csc_array, csr_array, eye_array
from scipy.sparse.linalg import splu

from workflow.data.frame import Floats, Ints
from workflow.errors import WorkflowError

# A column whose remainder is shorter than this (rows of order one) depends on those eliminated before it.  Measured on
# packings of 1e5 grains: round-off leaves up to 3e-11, pivots stay above 1e-5, even without friction near isostaticity.
DEPENDENT = 1e-9
# A column whose remainder is shorter than this, but not negligible, waits for the next front, where longer ones go first.
# Eliminating it at once would be no error of its own, but the coefficients 1/remainder multiply from front to front: in
# cohesive packings of 20 000 grains, a hair from isostatic, round-off grew to 1e-9 that way and the ranks came out wrong.
SHORT = 1e-2
NOISE = 1e-11  # entries of a null vector (whose pivot entry is 1) below this are round-off
LEAF = 12  # nodes eliminated together at the bottom of the dissection: smaller fronts cost more Python than arithmetic


@dataclass(frozen=True)
class Front:
    """One dense elimination step: ``upper`` x[live] + ``rest`` x[dead, border] = 0 on the null space."""

    live: Ints
    dead: Ints
    border: Ints
    upper: Floats
    rest: Floats


@dataclass(frozen=True)
class Factorisation:
    """Result of ``factorise``: the rank, how clear-cut it is, and what the null space is computed from.

    ``smallest_live`` and ``largest_dead``: smallest accepted and largest rejected pivot; their ratio is the gap.
    """

    columns: int
    fronts: tuple[Front, ...]
    smallest_live: float
    largest_dead: float

    @property
    def rank(self) -> int:
        """Rank of the matrix."""
        return len(self.independent)

    @property
    def independent(self) -> Ints:
        """A largest set of independent columns, (rank,) int64, in the order of elimination."""
        return np.concatenate([front.live for front in self.fronts])

    @property
    def nullity(self) -> int:
        """Dimension of the null space, columns - rank."""
        return self.columns - self.rank

    def null_space(self) -> csc_array:
        """Basis of the null space, (columns, nullity), one dependent column per vector, where its entry is 1.

        Each vector is the only combination of that column with independent ones that vanishes, so its support is
        minimal and connected; the basis is sparse and local, not orthogonal.
        """
        known: dict[int, tuple[Ints, Floats]] = {}
        started = 0
        for front in reversed(self.fronts):
            own = np.arange(started, started + len(front.dead))
            started += len(own)
            inherited = [(row, *known[c]) for row, c in enumerate(front.border.tolist(), len(own)) if c in known]
            known.update((c, (own[k : k + 1], np.ones(1))) for k, c in enumerate(front.dead.tolist()))
            active = np.unique(np.concatenate([own, *(vectors for _, vectors, _ in inherited)]))
            if not len(active) or not len(front.live):
                continue
            right = np.zeros((len(own) + len(front.border), len(active)))
            right[np.arange(len(own)), np.searchsorted(active, own)] = 1.0
            for row, vectors, values in inherited:
                right[row, np.searchsorted(active, vectors)] = values
            solution = -solve_triangular(front.upper, front.rest @ right, check_finite=False)
            for c, values in zip(front.live.tolist(), solution, strict=True):
                keep = np.abs(values) > NOISE
                if keep.any():
                    known[c] = active[keep], values[keep]
        rows = np.repeat(np.fromiter(known, np.int64, len(known)), [len(v) for v, _ in known.values()])
        vectors = np.concatenate([np.empty(0, np.int64), *(v for v, _ in known.values())])
        values = np.concatenate([np.empty(0), *(v for _, v in known.values())])
        return csc_array((values, (rows, vectors)), shape=(self.columns, self.nullity))

    def combine_null_space(self, weights: Floats) -> Floats:
        """The basis of ``null_space`` times ``weights`` (nullity, m), (columns, m), without forming the basis."""
        motion, started = np.zeros((self.columns, weights.shape[1])), 0
        for front in reversed(self.fronts):
            motion[front.dead] = weights[started : started + len(front.dead)]
            started += len(front.dead)
            known = motion[np.concatenate((front.dead, front.border))]
            motion[front.live] = -solve_triangular(front.upper, front.rest @ known, check_finite=False)
        return motion

    @property
    def dependent(self) -> Ints:
        """The dependent columns, (nullity,) int64, in the order of the vectors of ``null_space``."""
        return np.concatenate([front.dead for front in reversed(self.fronts)])

    def times_null_space(self, rows: Floats) -> Floats:
        """``rows`` (m, columns) times the basis of ``null_space``, (m, nullity), without forming the basis."""
        remainder = np.array(rows, dtype=float)
        for front in self.fronts:
            share = solve_triangular(front.upper, remainder[:, front.live].T, trans=1, check_finite=False).T
            remainder[:, np.concatenate((front.dead, front.border))] -= share @ front.rest
        return remainder[:, self.dependent]


def dissect(position: Floats, adjacency: csr_array) -> tuple[list[Ints], list[int]]:
    """Nested dissection of nodes in the plane: blocks of nodes, children before parents, and each block's parent.

    ``position`` (n, 2); ``adjacency`` (n, n) symmetric pattern (bonds across a periodic border are allowed).  No bond
    joins two blocks unless one is an ancestor of the other.  The last block is the root, its own parent.
    """
    blocks: list[Ints] = []
    parents: list[int] = []
    beyond = np.zeros(len(position))

    def split(nodes: Ints) -> int:
        children = []
        if len(nodes) > LEAF:
            axis = int(np.argmax(np.ptp(position[nodes], axis=0)))
            nodes = nodes[np.argsort(position[nodes, axis], kind="stable")]
            left, right = np.split(nodes, [len(nodes) // 2])
            beyond[right] = 1.0
            shared = adjacency[left] @ beyond > 0.0
            beyond[right] = 0.0
            children = [split(left[~shared]), split(right)]
            nodes = left[shared]
        blocks.append(nodes)
        parents.append(len(blocks) - 1)
        for child in children:
            parents[child] = parents[-1]
        return parents[-1]

    split(np.arange(len(position)))
    return blocks, parents


def factorise(matrix: csr_array, blocks: Sequence[Ints], parents: Sequence[int]) -> Factorisation:
    """Rank-revealing QR of ``matrix`` (rows, columns) whose columns are eliminated in ``blocks`` (see ``dissect``).

    Rows should be of order one.  Work about n^1.5 and memory about n log n for n columns of a planar network.
    """
    waiting: list[list[tuple[Ints, Floats]]] = [[] for _ in blocks]
    local = np.empty(matrix.shape[1], dtype=np.int64)
    fronts, live, dead = [], [np.inf], [0.0]
    late: list[list[Ints]] = [[] for _ in blocks]
    for block, rows in enumerate(_rows_by_block(matrix, blocks)):
        pieces = [(part.indices, part) for part in [matrix[rows]] if len(rows)] + waiting[block]
        pivots = np.concatenate((blocks[block], *late[block]))
        waiting[block] = []
        touched = np.unique(np.concatenate([np.empty(0, np.int64), *(columns for columns, _ in pieces)]))
        border = np.setdiff1d(touched, pivots, assume_unique=True)
        local[pivots], local[border] = np.arange(len(pivots)), np.arange(len(pivots), len(pivots) + len(border))
        root = parents[block] == block
        assembled = _assemble(pieces, local, len(pivots) + len(border))
        front, below, kept, lost = _eliminate(assembled, pivots, border, DEPENDENT if root else SHORT)
        fronts.append(front)
        live.append(kept)
        dead.append(lost)
        if not root:
            late[parents[block]].append(front.border[: len(front.border) - len(border)])
            if len(below) and len(front.border):
                waiting[parents[block]].append((front.border, below))
    return Factorisation(matrix.shape[1], tuple(fronts), float(min(live)), float(max(dead)))


def _rows_by_block(matrix: csr_array, blocks: Sequence[Ints]) -> list[Ints]:
    """Rows of each block: those whose first eliminated column is in it."""
    block_of = np.empty(matrix.shape[1], dtype=np.int64)
    for block, columns in enumerate(blocks):
        block_of[columns] = block
    filled = np.flatnonzero(np.diff(matrix.indptr))
    first = np.minimum.reduceat(block_of[matrix.indices], matrix.indptr[filled]) if len(filled) else filled
    order = np.argsort(first, kind="stable")
    return np.split(filled[order], np.searchsorted(first[order], np.arange(1, len(blocks))))


def _assemble(pieces: list, local: Ints, width: int) -> Floats:
    """Dense front from sparse rows of the matrix and dense rows left over by the children."""
    front = np.zeros((sum(rows.shape[0] for _, rows in pieces), width), order="F")
    top = 0
    for columns, rows in pieces:
        if isinstance(rows, csr_array):
            front[np.repeat(np.arange(rows.shape[0]), np.diff(rows.indptr)), local[columns]] = rows.data
        else:
            front[top : top + len(rows), local[columns]] = rows
        top += rows.shape[0]
    return front


def _eliminate(front: Floats, pivots: Ints, border: Ints, least: float) -> tuple[Front, Floats, float, float]:
    """Eliminate the pivot columns longer than ``least``: the front, the rows left for the parent, the shortest column
    eliminated and the longest one found dependent.  Columns in between head the border: the parent eliminates them.
    """
    width = len(pivots)
    if not front.size or not width:
        empty = np.zeros((0, 0)), np.zeros((0, width + len(border)))
        return Front(pivots[:0], pivots, border, *empty), _compress(front[:, width:]), np.inf, 0.0
    (raw, tau), upper, order = qr(front[:, :width], mode="raw", pivoting=True, check_finite=False)
    rest = np.asfortranarray(front[:, width:])
    if len(border):
        (ormqr,) = get_lapack_funcs(("ormqr",), (raw,))
        rest = ormqr("L", "T", raw[:, : len(tau)], tau, rest, lwork=64 * len(border))[0]
    diagonal = np.abs(upper.diagonal())
    rank = int(np.count_nonzero(diagonal > least))
    length = np.sqrt((upper[rank:, rank:] ** 2).sum(axis=0))
    gone, late = np.flatnonzero(length <= DEPENDENT) + rank, np.flatnonzero(length > DEPENDENT) + rank
    right = np.hstack((upper[:rank, gone], upper[:rank, late], rest[:rank]))
    below = np.zeros((len(rest) - rank, len(late) + len(border)))
    below[: len(upper) - rank, : len(late)] = upper[rank:, late]
    below[:, len(late) :] = rest[rank:]
    columns = pivots[order]
    done = Front(columns[:rank], columns[gone], np.concatenate((columns[late], border)), upper[:rank, :rank].copy(), right)
    return done, _compress(below), float(diagonal[:rank].min(initial=np.inf)), float(length[gone - rank].max(initial=0.0))


def _compress(rows: Floats) -> Floats:
    """The same row space in at most as many rows as columns."""
    return qr(rows, mode="r", check_finite=False)[0][: rows.shape[1]] if rows.shape[0] > rows.shape[1] > 0 else rows


def eigenvalues_below(matrix: csc_array, shift: float, order: Ints) -> int:
    """Number of eigenvalues of the symmetric ``matrix`` below ``shift``: negative pivots of matrix - shift I.

    ``order``: the rows and columns to keep, in the order of elimination.  The pivots stay on the diagonal, so the
    distance of ``shift`` to the next eigenvalue should exceed round-off.  Raises WorkflowError if one vanishes.
    """
    shifted = csc_array(matrix[order][:, order] - shift * eye_array(len(order)))
    factor = splu(shifted, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    if not np.array_equal(factor.perm_r, factor.perm_c):
        raise WorkflowError(
            f"inertia: a pivot of the {matrix.shape[0]} x {matrix.shape[0]} matrix vanished at the shift {shift:g}, so "
            "its signs say nothing; the matrix has an eigenvalue there, count at another shift"
        )
    return int(np.count_nonzero(factor.U.diagonal() < 0.0))

"""Connected parts of the interaction network in the periodic cell, and the force at which it percolates.

In a periodic cell "percolates" means *wraps*: the network holds a closed path whose image offsets do not cancel, so
that its periodic repetition reaches infinity.  A path that merely spans the cell does not count.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from workflow.data.frame import Bools, Floats, Frame, Interactions, Ints
from workflow.errors import InputError


@dataclass(frozen=True)
class Components:
    """Connected components of a graph in a periodic cell.

    ``label`` (V,) int64: component of each node.  ``image`` (V, 2) int64: x + image * cell joins a component in one
    piece. ``wraps`` (n, 2): the component holds a closed path that wraps around the cell along axis 1, axis 2.
    """

    label: Ints
    image: Ints
    wraps: Bools


@dataclass(frozen=True)
class Clusters:
    """Connected sets of interactions, largest first (number of grains, then interactions, then lowest grain row).

    ``label`` (N,) int64: cluster of each grain, -1 for grains in none.  Per cluster (n,): ``grains``,
    ``interactions`` and ``loops`` = interactions - grains + 1, the number of independent loops (cycle rank; loops
    around the cell included); ``wraps`` (n, 2): it wraps around the cell along axis 1, axis 2.  ``image`` (N, 2): see
    ``Components``.
    """

    label: Ints
    image: Ints
    grains: Ints
    interactions: Ints
    loops: Ints
    wraps: Bools


@dataclass(frozen=True)
class Percolation:
    """F_perc [force]: the largest F such that the interactions with ||F|| >= F wind around the cell; None: never.

    ``axis``: along axis 1 and axis 2.  ``any``: along at least one of them, hence the larger of the two.
    """

    axis: tuple[float | None, float | None]

    @property
    def any(self) -> float | None:
        return max((f for f in self.axis if f is not None), default=None)


def image_offsets(frame: Frame, contacts: Interactions | None = None) -> Ints:
    """Cells crossed by each interaction, n = [branch - (x_j - x_i)] / L, (M, 2) int64.

    Raises InputError where that is not an integer (1e-3 of the cell allowed): the branch and the positions disagree.
    """
    c = frame.interactions if contacts is None else contacts
    crossed = (c.branch - (frame.position[c.j] - frame.position[c.i])) / frame.cell
    offsets = np.rint(crossed)
    error = np.abs(crossed - offsets).max(axis=1, initial=0.0)
    if not (error < 1e-3).all():  # written so that NaN fails too
        row = int(np.argmax(~(error < 1e-3)))
        raise InputError(
            f"branch of grains {frame.ids[c.i[row]]} and {frame.ids[c.j[row]]} differs from their separation by "
            f"{error[row]:.3g} of a cell besides whole cells, at most 1e-3 is allowed; take both from the same step"
        )
    return offsets.astype(np.int64)


def components(nodes: int, i: Ints, j: Ints, offset: Ints) -> Components:
    """Components of the graph with edges i-j that cross ``offset`` (M, 2) cells from i to j.

    A spanning tree fixes the image of each node; an edge that does not close on it belongs to a winding path.
    """
    count, label = connected_components(_adjacency(nodes, i, j), directed=False)
    first = np.unique(label, return_index=True)[1]
    root = nodes  # an extra node joined to every component makes one search tree of all
    tree = _adjacency(nodes + 1, np.append(i, first), np.append(j, np.full(count, root)))
    parent = breadth_first_order(tree, root, directed=False)[1].astype(np.int64)
    parent[root] = root
    image = _sum_to_root(parent, _tree_steps(parent, nodes, i, j, offset))[:nodes]
    wraps = np.zeros((count, 2), dtype=bool)
    open_rows, axes = np.nonzero(image[i] + offset - image[j])
    wraps[label[i[open_rows]], axes] = True
    return Components(label.astype(np.int64), image, wraps)


def network_clusters(frame: Frame, rows: NDArray | None = None, *, singles: bool = False) -> Clusters:
    """Clusters of the interactions in ``rows`` (mask or indices; None: all); ``singles`` keeps grains without any."""
    contacts = frame.interactions if rows is None else frame.interactions.select(rows)
    parts = components(frame.grains, contacts.i, contacts.j, image_offsets(frame, contacts))
    count = len(parts.wraps)
    grains = np.bincount(parts.label, minlength=count)
    bonds = np.bincount(parts.label[contacts.i], minlength=count)
    lowest = np.unique(parts.label, return_index=True)[1]
    order = np.lexsort((lowest, -bonds, -grains))
    if not singles:
        order = order[bonds[order] > 0]
    rank = np.full(count, -1)
    rank[order] = np.arange(len(order))
    grains, bonds = grains[order], bonds[order]
    return Clusters(rank[parts.label], parts.image, grains, bonds, bonds - grains + 1, parts.wraps[order])


def stressed_clusters(frame: Frame, tolerance: float) -> Clusters:
    """Clusters of the interactions with ||F|| > ``tolerance`` [force] (G07 sec. IV B 1; 1e-4 F0, with RR 1e-2 F0)."""
    return network_clusters(frame, force_magnitude(frame) > tolerance)


def percolation(frame: Frame) -> Percolation:
    """Percolation threshold of ||F|| = ||N n + T t|| (G07 sec. IV B 1), by bisection over its values."""
    contacts, offset = frame.interactions, image_offsets(frame)
    magnitude = force_magnitude(frame)
    values = np.unique(magnitude)[::-1]

    def wraps(rank: int, axis: int) -> bool:
        rows = magnitude >= values[rank]
        parts = components(frame.grains, contacts.i[rows], contacts.j[rows], offset[rows])
        return bool(parts.wraps[:, axis].any())

    def threshold(axis: int) -> float | None:
        rank = bisect_left(range(len(values)), True, key=lambda r: wraps(r, axis))
        return float(values[rank]) if rank < len(values) else None

    return Percolation((threshold(0), threshold(1)))


def force_magnitude(frame: Frame) -> Floats:
    """||F|| = sqrt(N^2 + T^2) of each interaction [force], (M,)."""
    return np.hypot(frame.interactions.normal_force, frame.interactions.tangential)


def _adjacency(nodes: int, i: Ints, j: Ints) -> coo_array:
    return coo_array((np.ones(len(i), dtype=np.int8), (i, j)), shape=(nodes, nodes)).tocsr()


def _tree_steps(parent: Ints, nodes: int, i: Ints, j: Ints, offset: Ints) -> Ints:
    """Cells crossed from the parent of each node to the node, (V + 1, 2); of parallel edges the first counts."""
    key = np.concatenate((i * (nodes + 1) + j, j * (nodes + 1) + i))
    value = np.concatenate((offset, -offset))
    key, where = np.unique(key, return_index=True)
    steps = np.zeros((nodes + 1, 2), dtype=np.int64)
    child = np.flatnonzero(parent != nodes)
    steps[child] = value[where[np.searchsorted(key, parent[child] * (nodes + 1) + child)]]
    return steps


def _sum_to_root(parent: Ints, steps: Ints) -> Ints:
    """Sum of the steps on the way to the root, all nodes at once: each pass doubles the stretch of way covered."""
    root = len(parent) - 1
    while (parent != root).any():
        steps = steps + steps[parent]
        parent = parent[parent]
    return steps

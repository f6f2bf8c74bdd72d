"""Aggregates, coordination of the backbone grain by grain, bridges, and the pair correlation function."""

from __future__ import annotations

from array import array
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.spatial import cKDTree

from workflow.data.frame import Bools, Floats, Frame, Ints
from workflow.errors import InputError
from workflow.measures.percolation import Clusters, force_magnitude, network_clusters


@dataclass(frozen=True)
class Aggregates:
    """Connected aggregates, largest first.

    ``clusters``: topology (a lone grain is an aggregate of one).  ``mass`` (n,).  ``centre`` (n, 2): centre of mass,
    in the cell.  ``gyration`` (n,): radius of gyration of the centres, sqrt(sum m |x - centre|^2 / mass) [length].
    Centre and gyration are NaN where the aggregate wraps around the cell: it then has no inside.
    """

    clusters: Clusters
    mass: Floats
    centre: Floats
    gyration: Floats


@dataclass(frozen=True)
class PairCorrelation:
    """g(r) between ``edges`` (B + 1,) [length]: ``g`` (B,), 1 for uncorrelated centres."""

    edges: Floats
    g: Floats


def aggregates(frame: Frame) -> Aggregates:
    """Aggregates joined by interactions (contacts and distant pairs, G07 sec. III B)."""
    clusters = network_clusters(frame, singles=True)
    unwrapped = frame.position - frame.origin + clusters.image * frame.cell

    def total(weights: Floats) -> Floats:
        return np.bincount(clusters.label, weights, minlength=len(clusters.grains)).astype(np.float64)

    mass = total(frame.mass)
    centre = np.column_stack([total(frame.mass * unwrapped[:, a]) / mass for a in (0, 1)])
    arm = ((unwrapped - centre[clusters.label]) ** 2).sum(axis=1)
    gyration = np.sqrt(total(frame.mass * arm) / mass)
    endless = clusters.wraps.any(axis=1)
    centre[endless], gyration[endless] = np.nan, np.nan
    return Aggregates(clusters, mass, frame.origin + centre % frame.cell, gyration)


def local_coordination(frame: Frame, *, least: int, tolerance: float | None = None) -> Ints:
    """Interactions of each grain on the network freed of rattlers, (N,) int64; rattlers have 0.

    Interactions with ||F|| <= ``tolerance`` [force] are left out (None: all count), then grains with fewer than
    ``least`` interactions are removed, again and again until none is left to remove.  Cohesionless packings: least =
    2 and the force tolerance; cohesive ones: least = 1 and None (an unstressed contact still holds).
    """
    carrying = np.ones(len(frame.interactions), bool) if tolerance is None else force_magnitude(frame) > tolerance
    i, j = frame.interactions.i[carrying], frame.interactions.j[carrying]
    while True:
        number = np.bincount(i, minlength=frame.grains) + np.bincount(j, minlength=frame.grains)
        kept = (number[i] >= least) & (number[j] >= least)
        if kept.all():
            return number
        i, j = i[kept], j[kept]


def bridges(frame: Frame) -> Bools:
    """True for interactions without which their two grains would not be connected, (M,).

    Every interaction outside a spanning forest closes a loop and gets a random number of 63 bits; one of the forest is in a
    loop unless the numbers of those that leave the branch behind it cancel, none being there.
    """
    i, j, count = frame.interactions.i, frame.interactions.j, frame.grains
    network = csr_array((np.ones(len(i)), (i, j)), shape=(count + 1, count + 1))
    _, label = connected_components(network, directed=False)
    first = np.unique(label, return_index=True)[1][:-1]  # a grain of each part; the root, of no grain, joins them
    network += csr_array((np.ones(len(first)), (np.full(len(first), count), first)), shape=network.shape)
    order, above = breadth_first_order(network, count, directed=False)
    keys = np.sort(np.column_stack((i, j)), axis=1) @ [count, 1]
    once = np.zeros(len(i), dtype=bool)  # two grains that meet twice, around the cell, are a loop
    once[np.unique(keys, return_index=True)[1]] = True
    forest = once & ((above[i] == j) | (above[j] == i))
    marks = np.random.default_rng(0).integers(1, 2**63, len(i))
    behind = np.zeros(count + 1, dtype=np.int64)
    for end in (i, j):
        np.bitwise_xor.at(behind, end[~forest], marks[~forest])
    # from the leaves to the root, in arrays of the standard library: their single elements are read fast
    total, parent = array("q", behind.tobytes()), array("i", above.tobytes())
    for grain in array("i", order[:0:-1].tobytes()):
        total[parent[grain]] ^= total[grain]
    below = np.where(above[i] == j, i, j)
    return forest & (np.array(total)[below] == 0)


def pair_correlation(frame: Frame, edges: Floats) -> PairCorrelation:
    """g(r) = (pairs of centres in the ring) / (N rho pi (r2^2 - r1^2)), rho = N/A, ordered pairs, periodic.

    ``edges`` (B + 1,) ascending radii, at most half the shorter cell length (beyond, rings overlap their images).
    """
    edges = ring_edges(frame, edges)
    tree = cKDTree(wrapped(frame), boxsize=frame.cell)
    # the counts are cumulative and contain the N self pairs at r = 0: both drop out of the differences
    pairs = np.diff(tree.count_neighbors(tree, edges).astype(np.float64))
    ring = np.pi * np.diff(edges**2)
    return PairCorrelation(edges, pairs * frame.area / (float(frame.grains) ** 2 * ring))


def ring_edges(frame: Frame, edges: Floats) -> Floats:
    """``edges`` as an array; InputError unless they ascend within 0 .. half the shorter cell length."""
    edges = np.asarray(edges, dtype=np.float64)
    half = 0.5 * float(frame.cell.min())
    if edges.ndim != 1 or len(edges) < 2 or not (np.diff(edges) > 0).all() or not 0 <= edges[0] < edges[-1] <= half:
        raise InputError(f"edges = {edges} must ascend within 0 .. {half:.6g} (half the cell); shorten the range")
    return edges


def wrapped(frame: Frame) -> Floats:
    """Positions relative to the origin of the cell, in [0, L), (N, 2); InputError for one that is not finite."""
    if not (finite := np.isfinite(frame.position).all(axis=1)).all():
        row = int(np.argmin(finite))
        raise InputError(
            f"position of grain {frame.ids[row]} = {frame.position[row]} must be finite; this frame cannot be measured"
        )
    inside = (frame.position - frame.origin) % frame.cell
    return np.where(inside >= frame.cell, 0.0, inside)  # -tiny % L rounds to L itself

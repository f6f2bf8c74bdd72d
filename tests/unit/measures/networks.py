"""Interaction networks for the rigidity tests: lattices, clusters and random packings as synthetic frames."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from workflow.data.frame import Floats, Frame, Interactions
from workflow.measures.synthetic import ballistic_aggregate

TOUCH = -1e-12  # gap of a contact that carries no force


def frame_of(
    position: ArrayLike,
    diameter: ArrayLike,
    cell: ArrayLike,
    i: ArrayLike,
    j: ArrayLike,
    branch: ArrayLike,
    gap: ArrayLike = TOUCH,
    sliding: ArrayLike = False,
) -> Frame:
    """Frame with the given interactions and no forces; ``diameter``, ``gap``, ``sliding`` may be scalars."""
    position = np.asarray(position, dtype=float)
    grains, rows = len(position), np.size(i)
    diameter, zero = np.broadcast_to(diameter, grains).astype(float), np.zeros(rows)
    forces = dict.fromkeys(("elastic", "viscous", "attraction", "tangential", "moment", "xi_t", "xi_r"), zero)
    contacts = Interactions(
        i=np.asarray(i, dtype=np.int64),
        j=np.asarray(j, dtype=np.int64),
        branch=np.asarray(branch, dtype=float).reshape(rows, 2),
        gap=np.broadcast_to(gap, rows).astype(float),
        sliding=np.broadcast_to(sliding, rows),
        rolling=zero > 0.0,
        **forces,
    )
    vectors, scalars = np.zeros((grains, 2)), np.zeros(grains)
    state = {"velocity": vectors, "force": vectors, "omega": scalars, "torque": scalars}
    cell = np.broadcast_to(cell, 2).astype(float)
    ids = np.arange(1, grains + 1)
    return Frame(0, 0.0, "test", np.zeros(2), cell, ids, diameter, diameter**2, position, interactions=contacts, **state)


def network(position: ArrayLike, cell: ArrayLike, pairs: ArrayLike, force: ArrayLike = 1.0, mass: float = 1.0) -> Frame:
    """Discs of diameter 1 with interactions ``pairs`` (i, j), each to the nearest image, normal forces ``force``."""
    position, cell = np.asarray(position, dtype=float), np.asarray(cell, dtype=float)
    i, j = np.asarray(pairs, dtype=np.int64).reshape(-1, 2).T
    branch = position[j] - position[i]
    branch -= cell * np.rint(branch / cell)
    zero, n = np.zeros(len(i)), len(position)
    contacts = Interactions(
        i,
        j,
        branch,
        np.hypot(*branch.T) - 1.0,
        zero + np.asarray(force, dtype=float),
        zero,
        zero,
        zero,
        zero,
        zero,
        zero,
        zero > 0,
        zero > 0,
    )
    grain = np.zeros(n)
    return Frame(
        0, 0.0, "", np.array([-1.0, 2.0]), cell, np.arange(n), grain + 1, grain + mass, position, np.zeros((n,
        2)), grain, np.zeros((n, 2)), grain, contacts,
    )  # fmt: skip


def joined(position: ArrayLike, diameter: ArrayLike, cell: ArrayLike, reach: float = 1.02) -> Frame:
    """Frame whose pairs within ``reach`` times the sum of radii are contacts (nearest images)."""
    position, cell = np.asarray(position, dtype=float), np.broadcast_to(cell, 2).astype(float)
    diameter = np.broadcast_to(diameter, len(position)).astype(float)
    tree = cKDTree(position % cell, boxsize=cell)
    pairs = np.array(sorted(tree.query_pairs(reach * diameter.max())), dtype=np.int64).reshape(-1, 2)
    branch = position[pairs[:, 1]] - position[pairs[:, 0]]
    branch -= cell * np.round(branch / cell)
    near = np.hypot(*branch.T) <= reach * diameter[pairs].mean(axis=1)
    return frame_of(position, diameter, cell, pairs[near, 0], pairs[near, 1], branch[near])


def packing(grains: int, solid: float, seed: int, open_cell: bool = False) -> Frame:
    """Random discs, diameters 1/2 to 1, pushed apart until they about touch; ``open_cell``: nothing crosses it."""
    rng = np.random.default_rng(seed)
    diameter = rng.uniform(0.5, 1.0, grains)
    side = np.sqrt(np.pi * np.sum(diameter**2) / 4.0 / solid)
    position = rng.uniform(0.0, side, (grains, 2))
    for _ in range(40):
        frame = joined(position, diameter, side, reach=1.0)
        pairs = frame.interactions
        overlap = diameter[[pairs.i, pairs.j]].mean(axis=0) - pairs.distance
        push = 0.4 * overlap[:, None] * pairs.normal
        np.subtract.at(position, pairs.i, push)
        np.add.at(position, pairs.j, push)
    position %= side
    return joined(position, diameter, 10.0 * side if open_cell else side)


def angle_between(before: Floats, after: Floats) -> Floats:
    """Angle by which each vector turned, counterclockwise positive."""
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.arctan2(cross, (before * after).sum(axis=1))


def triangular(side: int) -> Frame:
    """Periodic triangular lattice of side x side touching discs of diameter 1 (``side`` even)."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(side), np.arange(side)))
    position = np.column_stack((x + 0.5 * (y % 2), np.sqrt(0.75) * y))
    return joined(position, 1.0, (side, np.sqrt(0.75) * side), reach=1.001)


def square(side: int) -> Frame:
    """Periodic square lattice of side x side touching discs of diameter 1."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(side), np.arange(side)))
    return joined(np.column_stack((x, y)), 1.0, side, reach=1.001)


def ring(grains: int) -> Frame:
    """Straight row of touching discs that closes on itself through the periodic cell."""
    return joined(np.column_stack((np.arange(grains), np.zeros(grains))), 1.0, (grains, 10.0), reach=1.001)


def row(grains: int) -> Frame:
    """Straight row of touching discs with two ends."""
    return joined(np.column_stack((np.arange(grains), np.zeros(grains))), 1.0, 10.0 * grains, reach=1.001)


def double_triangle(distance: float = 1.0) -> Frame:
    """Four equal discs and five contacts of G07 figs. 13 and 18: 1 and 2 side by side, D below and D' above."""
    half, height = 0.5 * distance, np.sqrt(0.75) * distance
    return joined([(-half, 0.0), (half, 0.0), (0.0, -height), (0.0, height)], 1.0, 50.0, reach=1.001)


def strip(grains: int, seed: int = 0) -> Frame:
    """Discs of random size, each touching the two before it exactly: a straightish triangulated strip."""
    radius = 0.5 * np.random.default_rng(seed).uniform(0.7, 1.0, grains)
    position = [np.zeros(2), np.array([radius[0] + radius[1], 0.0])]
    for k in range(2, grains):
        to_a, to_b = radius[k] + radius[k - 2], radius[k] + radius[k - 1]
        base = position[k - 1] - position[k - 2]
        length = np.hypot(*base)
        along = (length**2 + to_a**2 - to_b**2) / (2.0 * length)
        side = np.sqrt(to_a**2 - along**2) * (-1.0) ** k
        axis = base / length
        position.append(position[k - 2] + along * axis + side * np.array([-axis[1], axis[0]]))
    i, j = np.concatenate([[(k - 1, k) for k in range(1, grains)], [(k - 2, k) for k in range(2, grains)]]).T
    centre = np.array(position) + 100.0
    return frame_of(centre, 2.0 * radius, 1000.0, i, j, centre[j] - centre[i])


def together(*frames: Frame, apart: float = 20.0) -> Frame:
    """Frames without bonds across their cells, side by side in one large cell."""
    offsets = np.cumsum([0, *(f.grains for f in frames)])
    position = np.concatenate([f.position + np.array((k * apart, 0.0)) for k, f in enumerate(frames)])
    i = np.concatenate([f.interactions.i + offset for f, offset in zip(frames, offsets, strict=False)])
    j = np.concatenate([f.interactions.j + offset for f, offset in zip(frames, offsets, strict=False)])
    branch = np.concatenate([f.interactions.branch for f in frames])
    diameter = np.concatenate([f.diameter for f in frames])
    return frame_of(position, diameter, 1000.0, i, j, branch)


@cache
def aggregate(grains: int, seed: int) -> Floats:
    """Centres of a ballistic aggregate; several tests look at the same ones, do not change them."""
    centres = ballistic_aggregate(grains, np.random.default_rng(seed))
    centres.flags.writeable = False
    return centres

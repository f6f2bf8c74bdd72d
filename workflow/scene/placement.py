"""Grains: sizes, masses and random non-overlapping positions in a periodic cell."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from workflow.data.discs import Discs, strips
from workflow.data.frame import Floats
from workflow.errors import InputError

_PROPOSALS = 40_000  # points tried per round; enough to fill the last holes of a dense cell in few rounds
_AT_ONCE = 65_536  # points whose neighbours are looked at
_CLASSES = 16  # classes placed one after the other
_ROUNDS_WITHOUT_SUCCESS = 100


def diameters(count: int, smallest: float, rng: np.random.Generator) -> Floats:
    """N diameters drawn uniformly from [smallest, 1] a (G07 sec. II A: smallest = 1/2)."""
    return rng.uniform(smallest, 1.0, count) if smallest < 1.0 else np.ones(count)


def cell_length(diameter: Floats, solid_fraction: float) -> float:
    """Side L of the square cell in which the discs fill ``solid_fraction``: L^2 = sum(pi d^2/4)/Phi.

    Raises InputError if a disc would touch its own image.
    """
    length = float(np.sqrt(np.sum(np.pi * diameter**2 / 4.0) / solid_fraction))
    if 2.0 * diameter.max() > length:
        raise InputError(
            f"cell length L = {length:.4g} a for {len(diameter)} grain(s) at solid fraction {solid_fraction} is below two "
            "diameters: a grain would touch its own image; use more grains or a lower solid fraction"
        )
    return length


VELOCITIES = ("temperature", "same", "unit_disc", "mean_energy")  # what ``speed`` of `gaussian` is


def gaussian(diameter: Floats, speed: float, meaning: str, rng: np.random.Generator) -> Floats:
    """Gaussian velocities (N, 2) without total momentum; a single grain has none.  Masses are m = d^2.

    ``meaning`` of ``speed`` V0 (`VELOCITIES`): ``temperature``, the variance goes like 1/m and the root mean square over
    the grains is V0; ``unit_disc``, the same with V0 that of a disc of mass 1, sqrt(<m v^2>); ``same``, one variance for
    every grain, and root mean square V0; ``mean_energy``, one variance with <m v^2> = V0^2.
    """
    mass = diameter[:, None] ** 2
    equal = meaning in ("temperature", "unit_disc")
    velocity = rng.normal(size=(len(diameter), 2)) / (np.sqrt(mass) if equal else 1.0)
    velocity -= np.sum(mass * velocity, axis=0) / np.sum(mass)
    weight = mass if meaning in ("unit_disc", "mean_energy") else np.ones_like(mass)
    scale = np.sqrt(np.mean(np.sum(weight * velocity**2, axis=1)))
    return velocity * (speed / scale) if scale > 0.0 and len(diameter) > 1 else np.zeros_like(velocity)


def place_randomly(
    diameter: Floats, solid_fraction: float, gap: float, rng: np.random.Generator, *, by_size: bool = True
) -> Discs:
    """Random sequential addition, larger discs first (``by_size``) or in random order, every gap at least ``gap``.

    A round proposes uniform points for the next class and keeps what overlaps neither a placed disc nor a proposal of an
    earlier one; the cells of a grid tell which discs are near, so the cost grows as N.

    Raises InputError if the discs do not fit: discs with diameters in [a/2, a] jam near Phi = 0.6, in random order near 0.47.
    """
    length = cell_length(diameter, solid_fraction)
    grid = _Grid(np.sort(diameter)[::-1] if by_size else rng.permutation(diameter), length, gap)
    placed = np.zeros(len(diameter), dtype=bool)
    failures = 0
    while not placed.all():
        waiting = np.flatnonzero(~placed)[: -(-len(placed) // _CLASSES)]
        accepted = _propose(waiting, grid, rng)
        placed[accepted] = True
        failures = 0 if len(accepted) else failures + 1
        if failures == _ROUNDS_WITHOUT_SUCCESS:
            mixed = "0.61" if by_size else "0.47"
            raise InputError(
                f"initial solid fraction {solid_fraction} is too high: {np.sum(~placed)} of {len(placed)} discs found no free "
                f"place in {failures * _PROPOSALS} tries; use --initial fluid or a lower --phi0: "
                f"equal discs jam near 0.547, sizes in [0.5, 1] near {mixed}"
            )
    cell = np.array([length, length])
    order = strips(grid.position, cell)
    return Discs(grid.size[order], grid.position[order], cell)


def _propose(waiting: NDArray[np.intp], grid: _Grid, rng: np.random.Generator) -> NDArray[np.intp]:
    """One round of placement: the discs (rows of ``grid``) that found a place, and are there now."""
    disc = np.repeat(waiting, max(1, _PROPOSALS // len(waiting)))
    points = rng.uniform(0.0, grid.length, (len(disc), 2))
    free = np.flatnonzero(~grid.clash(disc, points))
    disc, first = np.unique(disc[free], return_index=True)  # one try per disc; earlier discs have lower rows
    points = points[free[first]]
    before = grid.add(disc, points)
    keep = ~grid.clash(disc, points, earlier=True)
    grid.newest[grid.cell(points)] = before  # all out again
    grid.add(disc[keep], points[keep])
    return disc[keep]


class _Grid:
    """Discs of ``size`` in cells of a periodic square: each a chain from its ``newest`` disc to ``older`` ones.

    A cell is wider than the distance at which the largest two clash, so what clashes is in one cell or in two that touch.
    """

    def __init__(self, size: Floats, length: float, gap: float) -> None:
        self.size, self.length, self.gap = size, length, gap
        widest = length / ((size.max() + gap) * (1.0 + 1e-9))  # a point at a border may be rounded across it
        self.across = max(1, int(min(widest, np.sqrt(2 * len(size)))))
        self.position = np.empty((len(size), 2))
        self.newest = np.full(self.across**2, -1, dtype=np.int32)  # LAMMPS numbers grains so too
        self.older = np.empty(len(size), dtype=np.int32)

    def cell(self, points: Floats, right: int = 0, up: int = 0) -> NDArray[np.intp]:
        """Cell of each point (n, 2), or the one so many to the right and up."""
        column, row = np.minimum((points / self.length * self.across).astype(np.intp), self.across - 1).T
        return (row + up) % self.across * self.across + (column + right) % self.across

    def add(self, disc: NDArray[np.intp], points: Floats) -> NDArray[np.int32]:
        """Put discs at ``points``; the newest in the cell of each before."""
        cell = self.cell(points)
        before = self.newest[cell]
        self.position[disc] = points
        order = np.argsort(cell, kind="stable")
        same = np.diff(cell[order]) == 0  # as the cell of the one before
        self.older[disc] = before
        self.older[disc[order[1:][same]]] = disc[order[:-1][same]]
        last = np.append(~same, True)[: len(order)]
        self.newest[cell[order[last]]] = disc[order[last]]
        return before

    def clash(self, disc: NDArray[np.intp], points: Floats, *, earlier: bool = False) -> NDArray[np.bool_]:
        """Whether each disc at its point comes too near to one that is in the cells, or to an ``earlier`` one there."""
        parts = [slice(k, k + _AT_ONCE) for k in range(0, len(disc), _AT_ONCE)]
        return np.concatenate([disc[:0] > 0, *(self._clash(disc[part], points[part], earlier) for part in parts)])

    def _clash(self, disc: NDArray[np.intp], points: Floats, earlier: bool) -> NDArray[np.bool_]:
        found, size = np.zeros(len(disc), dtype=bool), self.size[disc]
        for right, up in product((-1, 0, 1), repeat=2):
            ask = np.flatnonzero(~found)
            other = self.newest[self.cell(points[ask], right, up)]
            while len(ask):
                ask, other = ask[other >= 0], other[other >= 0]
                apart = np.abs(points[ask] - self.position[other])
                apart = np.minimum(apart, self.length - apart)
                near = np.sqrt(apart[:, 0] ** 2 + apart[:, 1] ** 2) < 0.5 * (size[ask] + self.size[other]) + self.gap
                found[ask] |= near & (other < disc[ask]) if earlier else near
                other = self.older[other]
        return found

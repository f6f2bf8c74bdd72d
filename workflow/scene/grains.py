"""Grains: sizes, masses and random non-overlapping positions in a periodic cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workflow.errors import InputError

Floats = NDArray[np.float64]

_PROPOSALS = 40_000  # points tried per round; enough to fill the last holes of a dense cell in few rounds
_CLASSES = 16  # size classes placed one after the other, largest first
_ROUNDS_WITHOUT_SUCCESS = 100


@dataclass(frozen=True)
class Discs:
    """Discs in a rectangular periodic cell with its lower corner at the origin.

    ``diameter`` (N,), ``position`` (N, 2), ``cell`` (2,), the side lengths, and ``velocity`` (N, 2), None at rest; float64
    in units of a and T0.  Rows from `place` are in a spatial order (strips of cells), so that neighbours in space are
    neighbours in memory.
    """

    diameter: Floats
    position: Floats
    cell: Floats
    velocity: Floats | None = None

    @property
    def kinetic_energy(self) -> float:
        """sum(m v^2/2) with m = d^2."""
        return 0.0 if self.velocity is None else 0.5 * float(np.sum(self.diameter**2 * (self.velocity**2).sum(axis=1)))


def diameters(count: int, smallest: float, rng: np.random.Generator) -> Floats:
    """N diameters drawn uniformly from [smallest, 1] a (G07 sec. II A: smallest = 1/2)."""
    return rng.uniform(smallest, 1.0, count) if smallest < 1.0 else np.ones(count)


def cell_length(diameter: Floats, solid_fraction: float) -> float:
    """Side L of the square cell in which the discs fill ``solid_fraction``: L^2 = sum(pi d^2/4)/Phi."""
    return float(np.sqrt(np.sum(np.pi * diameter**2 / 4.0) / solid_fraction))


def maxwell(diameter: Floats, speed: float, rng: np.random.Generator) -> Floats:
    """Velocities (N, 2) of equal temperature (variance of each component proportional to 1/m, m = d^2), without total
    momentum, with root mean square ``speed`` over the grains.  A single grain has none."""
    mass = diameter[:, None] ** 2
    velocity = rng.normal(size=(len(diameter), 2)) / np.sqrt(mass)
    velocity -= np.sum(mass * velocity, axis=0) / np.sum(mass)
    scale = np.sqrt(np.mean(np.sum(velocity**2, axis=1)))
    return velocity * (speed / scale) if scale > 0.0 and len(diameter) > 1 else np.zeros_like(velocity)


def place(diameter: Floats, solid_fraction: float, gap: float, rng: np.random.Generator) -> Discs:
    """Random sequential addition, larger discs first, every gap at least ``gap``.

    A round proposes uniform points for the next size class and keeps what overlaps neither a placed disc nor a proposal of
    a larger one; a k-d tree in the periodic cell finds the overlaps, so the cost grows as N log N.

    Raises InputError if the discs do not fit: random addition of discs with diameters in [a/2, a] jams near Phi = 0.6.
    """
    length = cell_length(diameter, solid_fraction)
    if 2.0 * diameter.max() > length:
        raise InputError(
            f"cell length L = {length:.4g} a for {len(diameter)} grain(s) at solid fraction {solid_fraction} is below two "
            "diameters: a grain would touch its own image; use more grains or a lower solid fraction"
        )
    size = np.sort(diameter)[::-1]
    position = np.empty((len(size), 2))
    placed = np.zeros(len(size), dtype=bool)
    failures = 0
    while not placed.all():
        waiting = np.flatnonzero(~placed)[: -(-len(size) // _CLASSES)]
        accepted, points = _propose(waiting, size, position[placed], size[placed], length, gap, rng)
        position[accepted] = points
        placed[accepted] = True
        failures = 0 if len(accepted) else failures + 1
        if failures == _ROUNDS_WITHOUT_SUCCESS:
            raise InputError(
                f"initial solid fraction {solid_fraction} is too high: {np.sum(~placed)} of {len(size)} discs found no free "
                f"place in {failures * _PROPOSALS} tries; use a lower --phi0: "
                "equal discs jam near 0.547, sizes in [0.5, 1] near 0.61"
            )
    cell = np.array([length, length])
    order = strips(position, cell)
    return Discs(size[order], position[order], cell)


def _propose(
    waiting: NDArray[np.intp],
    size: Floats,
    placed: Floats,
    placed_size: Floats,
    length: float,
    gap: float,
    rng: np.random.Generator,
) -> tuple[NDArray[np.intp], Floats]:
    """One round of placement: the discs (rows of ``size``) that found a place, and their positions."""
    tries = max(1, _PROPOSALS // len(waiting))
    disc = np.repeat(waiting, tries)
    points = rng.uniform(0.0, length, (len(disc), 2))
    free = np.ones(len(disc), dtype=bool)
    if len(placed):
        near = _near(points, placed, 0.5 * (size[waiting[0]] + placed_size.max()) + gap, length)
        clash = near["v"] < 0.5 * (size[disc[near["i"]]] + placed_size[near["j"]]) + gap
        free[near["i"][clash]] = False
    winner = np.flatnonzero(free)
    disc, first = np.unique(disc[winner], return_index=True)  # one try per disc; larger discs have lower rows
    points = points[winner[first]]
    if not len(disc):
        return disc, points
    near = _near(points, points, size[disc[0]] + gap, length)
    clash = (near["v"] < 0.5 * (size[disc[near["i"]]] + size[disc[near["j"]]]) + gap) & (near["i"] < near["j"])
    keep = np.ones(len(disc), dtype=bool)
    keep[near["j"][clash]] = False
    return disc[keep], points[keep]


def _near(a: Floats, b: Floats, reach: float, length: float) -> NDArray:
    """Pairs (i, j, distance v) of points of a and b closer than ``reach`` in the periodic square."""
    from scipy.spatial import cKDTree  # a tenth of a second that most commands need not pay

    trees = (cKDTree(points % length, boxsize=length) for points in (a, b))
    return next(trees).sparse_distance_matrix(next(trees), reach, output_type="ndarray")


def strips(position: Floats, cell: Floats) -> NDArray[np.intp]:
    """Order of positions (N, 2) inside ``cell`` by squares of about one diameter, row by row, every other row backwards."""
    cells = np.maximum(1, cell.astype(int))
    column, row = np.minimum((position / cell * cells).astype(int), cells - 1).T
    return np.lexsort((np.where(row % 2, -column, column), row))

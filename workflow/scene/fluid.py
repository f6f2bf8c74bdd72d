"""The initial state as a fluid of hard discs in equilibrium: sizes and places independent of each other but for the exclusion.

Event-chain Monte Carlo (Bernard, Krauth, Wilson, PRE 80, 056704 (2009)): a disc moves along +x or +y until it meets another,
which moves on in its place, until the displacements of the chain sum up to a fixed length.  Disc and axis of every chain are
drawn uniformly.  Why the uniform distribution over allowed configurations is kept: every chain can be traced back uniquely,
by moving along -x or -y for the same length, so that each configuration is reached by as many chains (N for each axis) as
leave it (global balance; the lack of moves back does not matter in a periodic cell).  Sizes enter only through the distance
at which two discs meet.
"""

from __future__ import annotations

import ctypes
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.ctypeslib import ndpointer

from workflow.data.discs import Discs, strips
from workflow.data.installed import installed_file
from workflow.errors import EnvironmentFault, InputError
from workflow.scene.placement import Floats, cell_length, place_randomly

LIBRARY = "hard_discs.so"
CHAIN = 4.0  # length of a chain in largest diameters: a few free paths at the lowest densities
MIXING = 32.0  # way of a disc on average in largest diameters; near pairs forget any start within 16 (docs/model.md)
GROWING = 0.25  # the same between two passes of growth, of which there are 10 to 40
_THIN = 0.3  # solid fraction at which random addition is easy whatever the sizes
_PASSES = 1000  # of growth
_AT_ONCE = 1_000_000  # chains drawn


def fluid(diameter: Floats, solid_fraction: float, gap: float, rng: np.random.Generator) -> Discs:
    """Hard discs of diameters d + ``gap`` in equilibrium at sum(pi d^2/4)/A = ``solid_fraction``, every gap at least ``gap``.

    They start where smaller discs lie that were added at random in random order, which has nearly the long-wave density
    fluctuations of the fluid.  There each grows as far as its neighbours allow, between event chains, until all have their
    size; then chains mix them.

    Raises InputError if they do not fit.
    """
    length = cell_length(diameter, solid_fraction)
    reach = diameter + gap
    full = solid_fraction * float(np.sum(reach**2) / np.sum(diameter**2))
    shrink = min(1.0, float(np.sqrt(_THIN / full)))
    start = place_randomly(shrink * reach, shrink**2 * full, 0.0, rng, by_size=False)
    size = np.empty_like(diameter)
    size[np.argsort(start.diameter, kind="stable")] = np.sort(diameter)
    position = equilibrate(start.position, size, gap, length, rng)
    cell = np.array([length, length])
    order = strips(position, cell)
    return Discs(size[order], position[order], cell)


def equilibrate(start: Floats, diameter: Floats, gap: float, length: float, rng: np.random.Generator) -> Floats:
    """Positions (N, 2) of the fluid in a periodic square of side ``length`` that began at the points ``start`` (N, 2).

    Raises InputError if not all discs find room to grow to ``diameter`` + ``gap``.
    """
    position, radius = np.array(start, dtype=float, order="C"), np.zeros(len(diameter))
    wanted = 0.5 * (diameter + gap) + 4.0 * np.finfo(float).eps * length  # a step is rounded as coordinates are
    widest = 2.0 * float(wanted.max())
    for _ in range(_PASSES):
        small = _library().hard_discs_grow(len(radius), position, radius, wanted, widest, length)
        if not _mix(position, radius, widest, length, GROWING if small else MIXING, rng):
            break
        if not small:
            return position
    raise InputError(
        f"initial solid fraction {np.pi / 4 * np.sum(diameter**2) / length**2:.4g} is too high: with gaps of {gap:g} the discs "
        f"jam before all have their size ({small} of {len(radius)} are still too small); use a lower --phi0"
    )


def _mix(position: Floats, radius: Floats, widest: float, length: float, way: float, rng: np.random.Generator) -> bool:
    """Event chains until discs went ``way`` x ``widest`` on average, or False if one got stuck.

    Their number is fixed beforehand: to stop when something is met would favour what is met.
    """
    count = len(radius)
    chains = -int(-way * count // CHAIN)
    for done in range(0, chains, _AT_ONCE):
        now = min(chains - done, _AT_ONCE)
        first = rng.integers(count, size=now, dtype=np.int32)
        axis = rng.integers(2, size=now, dtype=np.int8)
        moved = _library().hard_discs_chains(count, position, radius, widest, length, now, first, axis, CHAIN * widest)
        if moved < now:
            return False
    return True


@cache
def _library() -> ctypes.CDLL:
    """The compiled moves of this package or, where this code is a checkout's, of the installed one."""
    path = Path(__file__).resolve().parents[1] / "plugin" / LIBRARY
    if not path.is_file():
        path = installed_file(LIBRARY) or path
    return load(path)


def load(path: Path) -> ctypes.CDLL:
    """The library of monte_carlo/hard_discs.cpp at ``path``.  Raises EnvironmentFault if it does not load."""
    try:
        library = ctypes.CDLL(str(path))
    except OSError as fault:
        raise EnvironmentFault(
            f"library {path} does not load ({fault}): build it with 'pip install .' in a checkout"
        ) from fault
    count, real, reals = ctypes.c_int64, ctypes.c_double, ndpointer(np.float64, flags="C_CONTIGUOUS")
    first, axis = ndpointer(np.int32, flags="C_CONTIGUOUS"), ndpointer(np.int8, flags="C_CONTIGUOUS")
    grow: list[Any] = [count, reals, reals, reals, real, real]
    mix: list[Any] = [count, reals, reals, real, real, count, first, axis, real]
    library.hard_discs_grow.argtypes, library.hard_discs_grow.restype = grow, count
    library.hard_discs_chains.argtypes, library.hard_discs_chains.restype = mix, count
    return library

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
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from numpy.ctypeslib import ndpointer

from workflow.errors import EnvironmentFault, InputError
from workflow.scene.grains import Discs, Floats, cell_length, place, strips

LIBRARY = "hard_discs.so"
CHAIN = 4.0  # length of a chain in largest diameters: a few free paths at the lowest densities
MIXING = 32.0  # way of a disc on average in largest diameters; nothing measured changes after 16 (docs/model.md)
_THIN = 0.3  # solid fraction at which random addition is easy whatever the sizes
_PASSES = 1000  # of growth, which takes about 20
_AT_ONCE = 1_000_000  # chains drawn


def fluid(diameter: Floats, solid_fraction: float, gap: float, rng: np.random.Generator) -> Discs:
    """Hard discs of diameters d + ``gap`` in equilibrium at sum(pi d^2/4)/A = ``solid_fraction``, every gap at least ``gap``.

    They start as smaller discs added at random in random order, which has nearly the long-wave density fluctuations of the
    fluid; between event chains each grows as far as its neighbours allow until all have their size; then chains mix them.

    Raises InputError if they do not fit.
    """
    length = cell_length(diameter, solid_fraction)
    reach = diameter + gap
    full = solid_fraction * float(np.sum(reach**2) / np.sum(diameter**2))
    shrink = min(1.0, float(np.sqrt(_THIN / full)))
    start = place(shrink * reach, shrink**2 * full, 0.0, rng, by_size=False)
    size = np.empty_like(diameter)
    size[np.argsort(start.diameter, kind="stable")] = np.sort(diameter)
    chains = _Chains(start.position, 0.5 * start.diameter, 0.5 * (size + gap) + 4.0 * np.finfo(float).eps * length, length)
    for _ in range(_PASSES):
        small = chains.grow()
        if not small:
            break
        chains.mix(1.0, rng)
    else:
        raise InputError(
            f"initial solid fraction {solid_fraction} is too high: {small} of {len(size)} discs found no room to grow to their "
            f"size with gaps of {gap:g}; use a lower --phi0"
        )
    chains.mix(MIXING, rng)
    cell = np.array([length, length])
    order = strips(chains.position, cell)
    return Discs(size[order], chains.position[order], cell)


class _Chains:
    """Discs of ``radius`` (N,) up to ``wanted`` at ``position`` (N, 2) in a periodic square, and what moves them."""

    def __init__(self, position: Floats, radius: Floats, wanted: Floats, length: float) -> None:
        self.position, self.radius = np.ascontiguousarray(position), np.minimum(radius, wanted)
        self.wanted, self.length, self.widest = wanted, length, 2.0 * float(wanted.max())

    def grow(self) -> int:
        """Each disc in turn grows as far as the others allow, up to its size; how many are still too small."""
        return _library().hard_discs_grow(len(self.radius), self.position, self.radius, self.wanted, self.widest, self.length)

    def mix(self, way: float, rng: np.random.Generator) -> None:
        """Event chains until the discs went ``way`` largest diameters on average; their number is fixed beforehand."""
        count = len(self.radius)
        left = -int(-way * count // CHAIN)
        while left > 0:
            now = min(left, _AT_ONCE)
            first = rng.integers(count, size=now, dtype=np.int32)
            axis = rng.integers(2, size=now, dtype=np.int8)
            _library().hard_discs_chains(
                count, self.position, self.radius, self.widest, self.length, now, first, axis, CHAIN * self.widest
            )
            left -= now


@cache
def _library() -> ctypes.CDLL:
    """The compiled moves, of this package or, where this code is a checkout's, of the installed one."""
    path = Path(__file__).resolve().parents[1] / "plugin" / LIBRARY
    if not path.is_file():
        path = next((Path(str(file.locate())) for file in _installed() if file.name == LIBRARY), path)
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
    library.hard_discs_chains.argtypes, library.hard_discs_chains.restype = mix, None
    return library


def _installed() -> list[metadata.PackagePath]:
    try:
        return metadata.files("workflow") or []
    except metadata.PackageNotFoundError:
        return []

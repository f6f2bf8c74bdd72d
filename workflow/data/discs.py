"""Grains as an initial state: sizes, positions and velocities in a periodic cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workflow.data.frame import Floats


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


def strips(position: Floats, cell: Floats) -> NDArray[np.intp]:
    """Order of positions (N, 2) inside ``cell`` by squares of about one diameter, row by row, every other row backwards."""
    cells = np.maximum(1, cell.astype(int))
    column, row = np.minimum((position / cell * cells).astype(int), cells - 1).T
    return np.lexsort((np.where(row % 2, -column, column), row))

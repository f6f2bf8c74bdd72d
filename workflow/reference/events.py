"""Location of the instants at which a mode of the law ends."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from workflow.reference.discs import Floats
from workflow.reference.system import Piece

SAMPLES = 4  # intervals per step searched for sign changes

Solution = Callable[[float], Floats]


class Hit(NamedTuple):
    """A trigger that fired: local time, row and pair."""

    tau: float
    row: int
    pair: int


class Search:
    """Looks for the first trigger of ``piece`` to fall below -``tolerance`` within a step."""

    def __init__(self, piece: Piece, tolerance: float, resolution: float) -> None:
        self.piece, self.tolerance, self.resolution = piece, tolerance, resolution

    def first(self, solution: Solution, begin: float, end: float) -> Hit | None:
        """Earliest hit in [begin, end], None if the mode holds throughout."""
        times = np.linspace(begin, end, SAMPLES + 1)
        seen = [self._sample(solution, tau) for tau in times]
        for k in range(SAMPLES):
            (before, falling), (after, rising) = seen[k], seen[k + 1]
            crossed = (before > 0.0) & (after <= 0.0)
            # a mode that was wrong from its very start, e.g. two triggers reached at the same instant
            at_once = (before <= 0.0) & (after < before) & (begin == 0.0 and k == 0)
            dips = (before > 0.0) & (after > 0.0) & (falling < 0.0) & (rising > 0.0)
            hits = [Hit(0.0, *at) for at in np.argwhere(at_once)]
            hits += [self._root(solution, times[k], times[k + 1], *at) for at in np.argwhere(crossed)]
            hits += [hit for at in np.argwhere(dips) if (hit := self._graze(solution, times[k], times[k + 1], *at))]
            if hits:
                earliest = min(hit.tau for hit in hits) + self.resolution
                return min((hit for hit in hits if hit.tau <= earliest), key=lambda hit: (hit.row, hit.pair))
        return None

    def _sample(self, solution: Solution, tau: float) -> tuple[Floats, Floats]:
        values, slopes = self.piece.triggers(tau, solution(tau))
        return values + self.tolerance, slopes

    def _root(self, solution: Solution, begin: float, end: float, row: int, pair: int) -> Hit:
        tau = brentq(lambda t: self._sample(solution, t)[0][row, pair], begin, end, xtol=1e-300, rtol=1e-15)
        return Hit(tau, row, pair)

    def _graze(self, solution: Solution, begin: float, end: float, row: int, pair: int) -> Hit | None:
        """A trigger that falls and rises again between two samples, e.g. a tangential pass through the tail."""
        lowest = brentq(lambda t: self._sample(solution, t)[1][row, pair], begin, end)
        if self._sample(solution, lowest)[0][row, pair] > 0.0:
            return None
        return self._root(solution, begin, lowest, row, pair)

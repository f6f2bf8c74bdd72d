"""Sums over the grains and the contact table of a frame that tell whether its data hold together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workflow.data.frame import Floats, Frame


@dataclass(frozen=True)
class Balance:
    """Net force (N, 2) and moment (N,) of each grain summed over the contact table, and the engine's own sums.

    ``force_difference``, ``moment_difference``: largest deviation between the two over all grains (gravity, a
    background damping or a lost table row show here).
    """

    force: Floats
    moment: Floats
    force_difference: float
    moment_difference: float

    @property
    def largest_force(self) -> float:
        """max over grains of |net force|."""
        return float(np.hypot(*self.force.T).max(initial=0.0))

    @property
    def largest_moment(self) -> float:
        """max over grains of |net moment|."""
        return float(np.abs(self.moment).max(initial=0.0))


def solid_fraction(frame: Frame) -> float:
    """Phi = sum(pi d_i^2/4)/A; overlaps count twice, as in G07."""
    return float(np.pi / 4 * (frame.diameter**2).sum() / frame.area)


def balance(frame: Frame) -> Balance:
    """Net force and moment of each grain from the contact table.

    j receives +F, i receives -F; the moments about the centres are -R_i T - m on i and -R_j T + m on j (lever arms R as
    in G07 eq. 9, m the rolling moment of i on j).
    """
    table, n, radius = frame.interactions, frame.grains, frame.diameter / 2

    def net(on_i: Floats, on_j: Floats) -> Floats:
        sums: Floats = np.bincount(table.i, weights=on_i, minlength=n).astype(np.float64)
        return sums + np.bincount(table.j, weights=on_j, minlength=n)

    force = np.column_stack([net(-component, component) for component in table.force.T])
    moment = net(-radius[table.i] * table.tangential - table.moment, -radius[table.j] * table.tangential + table.moment)
    return Balance(
        force=force,
        moment=moment,
        force_difference=float(np.hypot(*(force - frame.force).T).max(initial=0.0)),
        moment_difference=float(np.abs(moment - frame.torque).max(initial=0.0)),
    )

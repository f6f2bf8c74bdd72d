"""A scene that the package does not have: a granular gas cools by its collisions alone, in a cell of fixed size.

export WORKFLOW_SCENES=.../free_cooling.py
wf run free_cooling --n 1000 --zeta 0.05
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from workflow.data.discs import Discs
from workflow.scene.packing import Packing
from workflow.scene.parameter import parameter
from workflow.scene.placement import gaussian

# what a cell under stress and the laws of LAMMPS need, and this deck has not
LEFT_OUT = (
    "stress", "cell", "cell_mass", "rate_cap", "wall_cap", "momentum_convention", "background_damping", "dashpots",
    "rolling_dashpots", "pair_radius",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class FreeCooling(Packing):
    """Scene `free_cooling`.  Units: a, the mass of a disc of diameter a, and a force by which K_N = kappa."""

    name: ClassVar[str] = "free_cooling"
    title: ClassVar[str] = "granular gas that cools by its collisions"
    template: ClassVar[Path] = Path(__file__).with_name("free_cooling.in")
    stages: ClassVar[dict[int, str]] = {1: "cool"}
    ends_in_equilibrium: ClassVar[bool] = False  # it cools until its time is over

    # a new parameter, and other defaults for known ones; everything else is that of Packing
    v0: float = parameter(
        1.0, float, "root mean square of the initial velocities", symbol="V0", unit="a/T0", above=0.0, high=1e3
    )
    cohesion: bool = parameter(False, bool, "attraction F0 of range D0")
    phi0: float = parameter(0.2, float, "solid fraction", symbol="Phi", low=1e-3, high=0.6)
    smallest: float = parameter(1.0, float, "smallest diameter", unit="a", low=0.01, high=1.0)
    mu: float = parameter(0.0, float, "friction coefficient", symbol="mu", low=0.0)
    zeta: float = parameter(0.05, float, "damping, fraction of critical", symbol="zeta", low=0.0, high=2.0)
    max_time: float = parameter(20.0, float, "time to cool", unit="T0", above=0.0, high=1e9)

    @property
    def approach_speed(self) -> float:
        """Of two grains, root mean square."""
        return math.sqrt(2.0) * self.v0

    def pressure_of(self, stage: str) -> None:
        """The cell is fixed."""

    @cached_property
    def gas(self) -> Discs:
        """That of the other scenes, with velocities of a Maxwell distribution."""
        still = super().gas
        return replace(still, velocity=gaussian(still.diameter, self.v0, "temperature", self.random("velocities")))

    @property
    def start_energy(self) -> float:
        """Zero of the energy account."""
        return self.gas.kinetic_energy

    def variables(self) -> dict[str, Any]:
        """Values of the variables of free_cooling.in."""
        return {name: value for name, value in super().variables().items() if name not in LEFT_OUT}


SCENES = [FreeCooling]

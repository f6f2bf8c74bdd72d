"""Method 1 of G07 (sec. III A): compress a random gas of discs, at rest, under a constant isotropic stress."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from workflow.scene.packing import Packing
from workflow.scene.routes import mean_pair_mass


@dataclass(frozen=True, kw_only=True, repr=False)
class Method1(Packing):
    """Scene `method1`."""

    name: ClassVar[str] = "method1"
    title: ClassVar[str] = "compression of a granular gas under constant stress (G07 method 1)"
    stages: ClassVar[dict[int, str]] = {1: "compress", 2: "settle"}
    settling = ("settle",)
    relaxations = (("compress", "settle"),)

    @property
    def approach_speed(self) -> float:
        """Speed of grains just before they jam, from the work of the pressure on the shrinking cell."""
        return self.fall_speed(self.pressure)

    @property
    def berendsen_modulus(self) -> float:
        """Modulus B (with a period of 1 T0) in dL/dt / L = -(S - sigma)/(3 B), as LAMMPS scales the lengths.

        P/(3 B) is the rate of an empty cell.  A first-order barostat knows no inertia: it must answer more slowly than sound
        crosses the packing, K_N/(3 B) <= c/L with c = sqrt(K_N/rho), or it feeds the grains with energy for ever.
        """
        length = math.sqrt(self.n * self.mean_area / 0.8)
        speed = math.sqrt(self.law_in_units.kn / (0.8 * 4.0 / math.pi))
        return max(self.pressure / (3.0 * self.berendsen_rate), self.law_in_units.kn * length / (3.0 * speed))

    @property
    def nph_period(self) -> float:
        """Period p of LAMMPS's barostat nph, whose inertia (N + 1) p^2 is that of the equation of the cell, W or M, times the
        area half way between the start and a solid fraction of 0.8 [T0]."""
        area = 0.5 * self.n * self.mean_area * (1.0 / self.phi0 + 1.0 / 0.8)
        return math.sqrt(self.cell_inertia * area / (self.n + 1))

    @property
    def nph_drag(self) -> float:
        """Drag of that barostat in the stage with dashpots: critical for a cell of stiffness K_N, sqrt(K_N/W) p."""
        return math.sqrt(self.law_in_units.kn / self.cell_inertia) * self.nph_period

    @property
    def compression_time(self) -> float:
        """Time in which the barostat closes the initial gas to a solid fraction of 0.8 [T0]."""
        strain = 1.0 - math.sqrt(self.phi0 / 0.8)
        if self.barostat == "berendsen":
            return 3.0 * self.berendsen_modulus * strain / self.pressure
        length = math.sqrt(self.n * self.mean_area / self.phi0)
        slowest = max(
            strain / self.rate_cap if self.rate_cap else 0.0, strain * length / self.wall_cap if self.wall_cap else 0.0
        )
        return max(slowest, math.sqrt(2.0 * strain * self.cell_inertia / self.pressure))

    def variables(self) -> dict[str, Any]:
        """Values of the variables of the deck method1.in."""
        nph = self.barostat == "nph"
        return super().variables() | {
            "barostat": self.barostat, "nph_period": self.nph_period if nph else 1.0, "nph_drag": self.nph_drag if nph else 0.0,
            "pair_mass": mean_pair_mass(self.smallest), "berendsen_modulus": self.berendsen_modulus,
            "unchanged_time": 2.0 * self.hold_time,
        }  # fmt: skip

"""Method 2 of G07 (sec. III B): a gas of moving discs sticks together before it feels any stress."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

from workflow.data.contact_law import ContactLaw
from workflow.data.discs import Discs
from workflow.errors import InputError
from workflow.scene.packing import Packing
from workflow.scene.parameter import parameter
from workflow.scene.parts import idle
from workflow.scene.placement import VELOCITIES, gaussian
from workflow.scene.time_step import Step, choose_step

# The paper's sets (sec. III B 2); what is given on top replaces the set's value.
SERIES: dict[str, dict[str, float]] = {
    "A": {"phi0": 0.36, "kappa": 1e5, "soft_kappa": 1e5},
    "A0": {"phi0": 0.13, "kappa": 1e5, "soft_kappa": 1e5, "max_time": 20000.0},
    "B": {"phi0": 0.26, "kappa": 1e4, "soft_kappa": 1e2},
}


@dataclass(frozen=True, kw_only=True, repr=False)
class Method2(Packing):
    """Scene `method2`.

    Stages: 1 aggregate (fixed cell, until one aggregate is left whose contacts do not change), 2 relax (dashpots, to
    equilibrium), 3 free (the cell, at sigma = 0), 4 stiffen (K_N from soft_kappa to kappa, if they differ), 5 load (P*, no
    dashpots), 6 settle (dashpots, to equilibrium).  Without dashpots and drag the same stages wait for equilibrium without
    help.
    """

    name: ClassVar[str] = "method2"
    title: ClassVar[str] = "aggregation of a granular gas, relaxation and loading (G07 method 2)"
    stages: ClassVar[dict[int, str]] = {1: "aggregate", 2: "relax", 3: "free", 4: "stiffen", 5: "load", 6: "settle"}
    figures: ClassVar[tuple[str, ...]] = (*Packing.figures, "aggregation")
    settling = ("relax", "free", "stiffen", "settle")
    relaxations = (("aggregate", "relax"), ("load", "settle"))

    series: str = parameter(
        "A", str, "the paper's set of samples: it sets phi0, kappa and soft_kappa where they are not given",
        choices=tuple(SERIES), source="G07 sec. III B 2",
    )  # fmt: skip
    v0: float = parameter(
        9.48, float, "initial velocities (see velocities) in units of V* = sqrt(F0 D0/m)", symbol="V0", unit="V*",
        low=0.0, high=1e4, group="grains", source="G07 sec. III B, table VI: 0.095 to 95",
    )  # fmt: skip
    velocities: str = parameter(
        None, str, "what V0 says of the initial velocities: rms of grains of equal temperature, of the same Gaussian for every "
        "mass, of a disc of mass 1 at equal temperature, or sqrt(2 x mean energy/m(a)) of the same Gaussian",
        choices=VELOCITIES, automatic=True, source="G07 sec. III B", group="grains",
    )  # fmt: skip
    phi0: float = parameter(
        None, float, "initial solid fraction, default that of the series", symbol="Phi_I", low=1e-3, high=0.6,
        automatic=True, source="G07 table IV",
    )  # fmt: skip
    kappa: float = parameter(
        None, float, "stiffness K_N a/F0, default that of the series", symbol="kappa", low=1e2, high=1e8, automatic=True,
        source="G07 table I",
    )  # fmt: skip
    soft_kappa: float = parameter(
        None, float, "stiffness K_N a/F0 until the cell is free, default that of the series, or kappa", symbol="kappa",
        low=10.0, high=1e8, automatic=True, source="G07 sec. III B 2", group="contact law",
    )  # fmt: skip
    stiffening: float = parameter(
        100.0, float, "time in which the stiffness grows from soft_kappa to kappa", unit="T0", low=0.0, high=1e9
    )
    pstar: float = parameter(
        0.01, float, "reduced pressure P* = P a/F0 of the last stages, 0: end in equilibrium without stress", symbol="P*",
        unit="F0/a", low=0.0, high=100.0, source="G07 sec. III B",
    )  # fmt: skip
    quiet: float = parameter(
        20.0, float, "time without a change of contacts after which an aggregate, or a loaded packing, is taken as complete",
        unit="T0", low=0.0, high=1e9,
    )  # fmt: skip
    max_time: float = parameter(
        None, float, "longest time of each stage, default 5000, in series A0, whose last aggregates meet late, 20000",
        unit="T0", above=0.0, high=1e9, automatic=True,
    )  # fmt: skip

    READINGS: ClassVar[Mapping[str, tuple[Any, Any]]] = {
        **Packing.READINGS, "rate_cap": (0.0, 0.05), "wall_cap": (0.05, 0.0), "velocities": ("unit_disc", "temperature"),
    }  # fmt: skip

    def __post_init__(self) -> None:
        if self.barostat in ("nph", "berendsen"):
            raise InputError(f"barostat = '{self.barostat}' is not allowed in method2, whose cell starts at no stress: "
                             "use inertial")  # fmt: skip
        preset = {"max_time": 5000.0, **SERIES.get(self.series, {})}
        if self.series != "B" and self.kappa is not None:
            preset["soft_kappa"] = self.kappa
        for name, value in preset.items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)
        super().__post_init__()
        if not self.cohesion:
            raise InputError("cohesion = false is not allowed: grains without attraction form no aggregate; use method1")
        if not self.exact and self.soft_kappa != self.kappa:
            raise InputError(f"law = {self.law} is not allowed with soft_kappa = {self.soft_kappa:g}: LAMMPS's pair styles "
                             f"cannot stiffen while they run; use soft_kappa = {self.kappa:g}, or the exact law")  # fmt: skip

    @property
    def pressure(self) -> float:
        """Stress imposed in the last stages, F0/a."""
        return self.pstar

    @property
    def speed(self) -> float:
        """The scale V0 V* of the initial velocities [a/T0]; see ``velocities``."""
        return self.v0 * math.sqrt(self.d0)

    @property
    def approach_speed(self) -> float:
        """Speed at which grains of the aggregate meet: what P* and, from rest, the attraction give them, sqrt(2) V*."""
        return math.hypot(self.fall_speed(self.pressure), math.sqrt(2.0 * self.d0))

    @cached_property
    def soft_law(self) -> ContactLaw:
        """The law until the stiffness grows."""
        law, ratio = self.law_in_units, self.soft_kappa / self.kappa
        return replace(law, kn=law.kn * ratio, kt=law.kt * ratio, kr=law.kr * ratio)

    @cached_property
    def step_choice(self) -> Step:
        """The time step of the stages under load, from the stiffest contacts of any stage."""
        stiffest = max(self.law_in_units, self.soft_law, key=lambda law: law.kn)
        return choose_step(stiffest, self.smallest, self.approach_speed, self, self.dashpots)

    def step_of(self, stage: str) -> Step:
        """That of soft contacts until they stiffen; in the gas it resolves the tail at sqrt(2) V0, the root mean square of
        the relative velocity."""
        if stage not in ("start", "aggregate", "relax", "free"):
            return self.step_choice
        speed = self.approach_speed if stage in ("relax", "free") else math.sqrt(2.0) * self.speed
        return choose_step(self.soft_law, self.smallest, speed, self, self.dashpots)

    @property
    def softest(self) -> float:
        """Smallest K_N of any stage."""
        return min(self.soft_law.kn, self.law_in_units.kn)

    @property
    def compression_time(self) -> float:
        """Time in which the cell, at the capped rate, could close from the initial solid fraction to 0.8 [T0]."""
        strain, length = 1.0 - math.sqrt(self.phi0 / 0.8), math.sqrt(self.n * self.mean_area / self.phi0)
        return max(strain / self.rate_cap if self.rate_cap else 0.0, strain * length / self.wall_cap if self.wall_cap else 0.0)

    def law_of(self, stage: str) -> ContactLaw:
        """Soft until the stage `stiffen` has ended."""
        return self.soft_law if stage in ("start", "aggregate", "relax", "free") else self.law_in_units

    def pressure_of(self, stage: str) -> float | None:
        """The cell is fixed while grains aggregate, then free, then under P*."""
        return {"start": None, "aggregate": None, "relax": None, "free": 0.0, "stiffen": 0.0}.get(stage, self.pressure)

    @cached_property
    def gas(self) -> Discs:
        """The gas of method 1 with velocities of a Maxwell distribution."""
        still = super().gas
        return replace(still, velocity=gaussian(still.diameter, self.speed, self.velocities, self.random("velocities")))

    @property
    def start_energy(self) -> float:
        """Kinetic energy of the gas, in which nothing touches."""
        return self.gas.kinetic_energy

    def warnings(self) -> list[str]:
        """The steps of the stages with a step of their own, and those of every packing."""
        steps = {stage: self.step_of(stage) for stage in ("aggregate", "relax")}
        other = {stage: step for stage, step in steps.items() if step.step != self.step_choice.step}
        return [*(f"step in {stage} {step.step:.3g} T0: {step.reason}" for stage, step in other.items()), *super().warnings()]

    def variables(self) -> dict[str, Any]:
        """Values of the variables of the deck method2.in."""
        soft, values = self.soft_law, super().variables()
        del values["stress"]
        return values | {
            "stress_first": self.pressure, "stress_ratio": 1.0, "stress_rises": 0, "stress_count": 1,
            "kn": soft.kn, "kt": soft.kt, "kr": soft.kr,
            "stiffness_ratio": self.law_in_units.kn / soft.kn,
            "stiffness_ramp_time": self.stiffening, "unchanged_time": self.quiet,
            "gas_step": self.step_of("aggregate").step, "soft_step": self.step_of("relax").step,
        }  # fmt: skip

    def without_effect(self) -> dict[str, str]:
        """As of every packing; and the time of a ramp without one, and velocities of grains that start at rest."""
        ramp = ("soft_kappa is kappa: the stiffness does not grow", self.soft_kappa == self.kappa, "stiffening")
        return super().without_effect() | idle(ramp, ("V0 is 0: the grains start at rest", self.v0 == 0.0, "velocities"))

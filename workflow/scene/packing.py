"""What the assembling methods share: checks, units, step, grains, random streams and the deck's common variables."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

from workflow.data.contact_law import ContactLaw
from workflow.data.discs import Discs
from workflow.data.frame import Floats
from workflow.errors import InputError
from workflow.scene.base import Scene, Units
from workflow.scene.fluid import fluid
from workflow.scene.parts import Cell, Equilibrium, Grains, Material, Numerics, idle
from workflow.scene.placement import diameters, place_randomly
from workflow.scene.progress import of_packing, packing_left
from workflow.scene.routes import check_route, route_variables, route_warnings
from workflow.scene.time_step import Step, choose_step, rolling_dashpot

MOST_STEPS = 2_000_000_000  # of one run of LAMMPS
ENDLESS = 1e100  # stands for infinity, which LAMMPS does not read
LONGEST = 1e9  # time of a stage [T0]
DENSEST = 0.91  # solid fraction of the densest packing of equal discs; the cell never gets smaller than this


@dataclass(frozen=True, kw_only=True, repr=False)
class Packing(Scene, Numerics, Equilibrium, Cell, Material, Grains):  # fields count from the last: grains first
    """Base of the scenes that assemble a packing; every parameter is a field, every derived number a property.

    ``settling``: the stages with dashpots or drag; ``relaxations``: (stage before, settling stage), pairs that show what
    these did.
    """

    kind: ClassVar[str] = "packing"
    figures: ClassVar[tuple[str, ...]] = ("network", "history")
    ends_in_equilibrium: ClassVar[bool] = True
    stream: ClassVar[str | None] = "method1"  # every method starts from the same gas
    settling: ClassVar[tuple[str, ...]] = ()
    relaxations: ClassVar[tuple[tuple[str, str], ...]] = ()

    READINGS: ClassVar[Mapping[str, tuple[Any, Any]]] = {
        "initial": ("fluid", "random_addition"), "cell": ("lengths", "strain"), "rate_cap": (0.0, 0.0), "wall_cap": (0.0, 0.0),
    }  # fmt: skip

    @classmethod
    def readings(cls) -> set[str]:
        """Parameters whose default depends on ``as_printed``: the inertia of the cell is that of its equation."""
        return super().readings() | {"cell_mass"}

    def __post_init__(self) -> None:
        super().__post_init__()
        check_route(self)
        if self.law == "exact":
            object.__setattr__(self, "law", None)  # the default, which is not written down: names of runs stay
        elif not self.exact and self.scheme == "second":
            object.__setattr__(self, "scheme", "paper")  # the only one that the law has
        if self.cell_mass is None:
            object.__setattr__(self, "cell_mass", 0.6 if self.cell == "lengths" else 0.3)
        if self.max_time is None:
            object.__setattr__(self, "max_time", min(max(500.0, 5.0 * self.compression_time), LONGEST))
        choice = self.step_choice
        if choice.step > choice.limit:
            raise InputError(
                f"step = {choice.step:g} is not allowed: beyond {choice.limit:.2g} T0 the integration of contacts of this "
                f"stiffness and damping is unstable; use at most {0.5 * choice.limit:.2g}, or leave it out"
            )
        if self.neighbour_skin <= self.law_in_units.d0:
            raise InputError(
                f"skin = {self.neighbour_skin:g} is not allowed: it must exceed the range of attraction d0 = {self.d0:g} "
                "[a], or pairs would be missed; leave it out"
            )
        shortest = math.sqrt(self.n * self.mean_area / DENSEST)
        needed = 2.0 * (1.0 + self.neighbour_skin)
        if shortest < needed:
            least = math.ceil(needed**2 * DENSEST / self.mean_area)
            raise InputError(
                f"n = {self.n} is not allowed: compressed, {self.n} grain(s) fill a cell of {shortest:.2f} a, in which a "
                f"grain would touch two images of its neighbour (the cell must stay above {needed:.2f} a); "
                f"use n = {least} or more"
            )

    @property
    def size(self) -> int:
        """Number of grains."""
        return self.n

    @property
    def units(self) -> Units:
        """Length a, force F0 or, without cohesion, a P."""
        return Units("a", "F₀" if self.cohesion else "aP", "T₀")

    @property
    def tolerance(self) -> float:
        """Forces below ``tolerance`` F1 count as none."""
        return self.force_tolerance

    @property
    def cohesive(self) -> bool:
        """An attraction acts."""
        return self.cohesion

    @property
    def mean_area(self) -> float:
        """Mean disc area pi <d^2>/4 for d uniform in [smallest, 1]."""
        s = self.smallest
        return math.pi / 4.0 * (1.0 + s + s * s) / 3.0

    @property
    def pressure(self) -> float:
        """Imposed stress, F0/a (cohesionless: 1)."""
        return self.pstar if self.cohesion else 1.0

    @property
    def force_unit(self) -> float:
        """F1 = max(F0, P a) (G07 sec. II D)."""
        return max(1.0, self.pressure) if self.cohesion else self.pressure

    @cached_property
    def law_in_units(self) -> ContactLaw:
        """The contact law's coefficients in scene units."""
        return self.contact_law(self.pressure)

    @property
    def approach_speed(self) -> float:
        """Speed of two approaching grains that the step must resolve [a/T0]."""
        raise NotImplementedError

    def law_of(self, stage: str) -> ContactLaw:
        """The law at the end of a stage; one law for all unless a scene changes its stiffness on the way."""
        return self.law_in_units

    @property
    def lammps_law(self) -> tuple[ContactLaw, float] | None:
        """The law that a pair style of LAMMPS stands for, and the radius of its rolling spring."""
        return None if self.exact else (self.law_in_units, route_variables(self)["pair_radius"])

    @property
    def needs_plugin(self) -> bool:
        """A law of LAMMPS without attraction, and a barostat of LAMMPS, need no plugin."""
        return self.exact or self.cohesion or self.barostat == "inertial"

    @property
    def resumes_exactly(self) -> bool:
        """Under a law of LAMMPS the plugin keeps the forces of a checkpoint; berendsen moves grains after the lists are made,
        which then differ in their order."""
        return self.exact or (self.needs_plugin and self.barostat != "berendsen")

    def pressure_of(self, stage: str) -> float | None:
        """Stress imposed in a stage, None in a cell of fixed size."""
        return self.pressure

    def alike(self, one: str, other: str) -> bool:
        """The grains have the same law and load at the ends of two stages."""
        same = (self.pressure_of(one) or 0.0) == (self.pressure_of(other) or 0.0)
        return same and self.law_of(one) == self.law_of(other)

    @cached_property
    def step_choice(self) -> Step:
        """The time step with its reason."""
        return choose_step(self.law_in_units, self.smallest, self.approach_speed, self, self.dashpots)

    @property
    def compression_time(self) -> float:
        """Time that a compression takes at least, 0 where there is none [T0]."""
        return 0.0

    def step_of(self, stage: str) -> Step:
        """The time step of a stage; one step for all unless stiffness or speeds change on the way."""
        return self.step_choice

    def fall_speed(self, pressure: float) -> float:
        """Speed of grains on which a pressure has done work until they jam, sqrt(2 P dA/sum(m)) [a/T0]."""
        mean_mass = 4.0 / math.pi * self.mean_area
        return math.sqrt(2.0 * pressure * self.mean_area * (1.0 / self.phi0 - 1.0 / 0.8) / mean_mass)

    @property
    def neighbour_skin(self) -> float:
        """Skin of the neighbour list [a]."""
        return self.skin if self.skin is not None else max(0.1, 2.0 * self.law_in_units.d0)

    @property
    def rolling_dashpots(self) -> float:
        """Dashpots of the rolling springs in the settling stages, fraction of critical; every step is stable with them."""
        stages = [(self.law_of(stage), self.step_of(stage).step) for stage in self.settling]
        return min((rolling_dashpot(law, self.smallest, self.dashpots, step) for law, step in stages), default=0.0)

    @property
    def relaxation(self) -> str:
        """What is done to the packing that the law does not do, for the record."""
        aids = [
            f"{name} {value:g}"
            for name, value in (("dashpots and quench of the cell", self.dashpots), ("drag", self.drag))
            if value
        ]
        return f"{' and '.join(aids)} in {', '.join(self.settling)}" if aids else "none"

    @property
    def cell_inertia(self) -> float:
        """W of the equation of the lengths, or M of that of the strain, at the start [mass of a disc of diameter a]."""
        total = self.n * 4.0 / math.pi * self.mean_area
        length = math.sqrt(self.n * self.mean_area / self.phi0)
        return self.cell_mass * (total if self.cell == "lengths" else total / length)

    @property
    def softest(self) -> float:
        """Smallest K_N of any stage."""
        return self.law_in_units.kn

    @property
    def hold_time(self) -> float:
        """50 periods of a contact of two largest discs and 10 of the cell (its inertia on a stiffness of order K_N)."""
        if self.hold is not None:
            return self.hold
        kn = self.softest
        contact = 2.0 * math.pi * math.sqrt(0.5 / kn)
        return max(50.0 * contact, 10.0 * 2.0 * math.pi * math.sqrt(self.cell_inertia / kn))

    def record(self) -> dict[str, Any]:
        """What is done to the packing that the law does not do; what a law of LAMMPS does not tell of a contact."""
        return {"relaxation": self.relaxation} | ({} if self.exact else {"lacks": ["xi_r", "xi_t"]})

    def discs(self) -> Discs:
        """The initial discs, as the data file holds them."""
        return self.gas

    @property
    def start_energy(self) -> float:
        """Energy of the initial state, the zero of the energy account."""
        return 0.0

    @cached_property
    def gas(self) -> Discs:
        """The initial discs: random, not overlapping, every gap at least D0; the sizes do not depend on ``initial``."""
        rng = self.random("placement")
        size, gap = diameters(self.n, self.smallest, rng), self.law_in_units.d0
        if self.initial == "fluid":
            return fluid(size, self.phi0, gap, self.random("fluid"))
        return place_randomly(size, self.phi0, gap, rng, by_size=self.initial == "addition_by_size")

    @property
    def check_interval(self) -> int:
        """Steps between two looks at the criteria of equilibrium, 0.02 T0."""
        return max(1, round(0.02 / self.step_choice.step))

    def every(self, time: float) -> int:
        """Steps in ``time``, a multiple of the interval between checks that LAMMPS can count."""
        check = self.check_interval
        return check * min(math.ceil(time / (check * self.step_choice.step)), MOST_STEPS // check)

    def variables(self) -> dict[str, Any]:
        """Values of the variables that the decks share."""
        law, every = self.law_in_units, self.every
        return {
            **route_variables(self),
            "kn": law.kn, "kt": law.kt, "zeta": law.zeta, "mu": min(law.mu, ENDLESS), "f0": law.f0, "d0": law.d0,
            "kr": law.kr, "mur": min(law.mur, ENDLESS),
            "stress": self.pressure, "force_unit": self.force_unit,
            "cell": self.cell, "cell_mass": self.cell_mass, "rate_cap": self.rate_cap, "wall_cap": self.wall_cap,
            "momentum_convention": self.convention,
            "force_tolerance": self.force_tolerance, "energy_tolerance": self.energy_tolerance,
            "hold": self.hold_time,
            "background_damping": self.drag, "dashpots": self.dashpots, "rolling_dashpots": self.rolling_dashpots,
            "step": self.step_choice.step, "skin": self.neighbour_skin, "start_energy": self.start_energy,
            "scheme": self.scheme, "energy_balance": "yes" if self.account else "no",
            "max_steps": every(self.max_time), "check_every": self.check_interval, "series_every": every(self.series_interval),
            "frame_every": every(self.frame_interval) if self.frame_interval else 0,
            "checkpoint_every": every(self.checkpoint_interval),
        }  # fmt: skip

    def warnings(self) -> list[str]:
        """A compression that takes longer than a stage may; what the law of LAMMPS does otherwise."""
        late = self.compression_time > self.max_time
        words = [f"the compression alone takes about {self.compression_time:.0f} T0: raise --max-time"] if late else []
        return words + route_warnings(self)

    def state_line(self, series: Mapping[str, Floats]) -> str:
        """Solid fraction, coordination number, pressure, unbalanced force, aggregates."""
        return of_packing(series, self.cohesion)

    def time_left(self, rows: Mapping[str, Floats], stage: str) -> float | None:
        """By the physics of the stage; None: unknown."""
        return packing_left(rows, self, stage)

    def left_out(self) -> list[str]:
        """What this scene does not use and therefore does not pay for."""
        law = self.law_in_units
        unused = {
            "attraction and its tail": law.f0 == 0,
            "friction, its memory and rotation": law.mu == 0 and law.mur == 0,
            "friction": law.mu == 0 and law.mur > 0,
            "rolling resistance": law.mur == 0,
            "damping": law.zeta == 0,
            "energy account": not self.account,
        }
        return [what for what, out in unused.items() if out]

    def without_effect(self) -> dict[str, str]:
        """Parameters that change nothing in this scene, as its other ones stand: name -> why."""
        return idle(
            ("without cohesion there is no attraction, and P = 1 is the unit", not self.cohesion, "pstar d0"),
            ("rolling resistance is off (--rolling)", not self.rolling, "mur kr_ratio"),
            ("the barostat is not berendsen", self.barostat != "berendsen", "berendsen_rate"),
            ("the barostat has no inertia", self.barostat == "berendsen" and self.hold is not None, "cell cell_mass"),
            ("mu is 0", self.mu == 0.0, "kt_ratio"),
            ("the step is given", self.step is not None, "steps_per_period"),
        )  # fmt: skip

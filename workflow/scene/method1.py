"""Method 1 of G07 (sec. III A): compress a random gas of discs, at rest, under a constant isotropic stress."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workflow.errors import InputError
from workflow.scene.grains import Discs, diameters, place
from workflow.scene.parts import Cell, Equilibrium, Grains, Law, Material, Numerics, Step, choose_step

MOST_STEPS = 2_000_000_000  # of one run of LAMMPS
ENDLESS = 1e100  # stands for infinity, which LAMMPS does not read
DENSEST = 0.91  # solid fraction of the densest packing of equal discs; the cell never gets smaller than this


@dataclass(frozen=True, kw_only=True)
class Method1(Numerics, Equilibrium, Cell, Material, Grains):  # fields count from the last: grains first
    """Scene `method1`; every parameter is a field, every derived number a property."""

    name = "method1"
    title = "compression of a granular gas under constant stress (G07 method 1)"
    stages = {1: "compress", 2: "settle"}  # noqa: RUF012

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.step_choice.step > 0.25 * self.step_choice.period:
            raise InputError(
                f"step = {self.step_choice.step:g} is not allowed: with "
                f"{self.step_choice.period / self.step_choice.step:.2g} "
                f"steps per stiffest period {self.step_choice.period:.3g} the integration is unstable; use at most "
                f"{0.2 * self.step_choice.period:.2g}, or leave it out"
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
    def law_in_units(self) -> Law:
        """The contact law's coefficients in scene units."""
        return self.law(self.pressure)

    @property
    def approach_speed(self) -> float:
        """Speed of grains just before they jam, sqrt(2 P dA/sum(m)) from the work of the pressure on the shrinking cell."""
        mean_mass = 4.0 / math.pi * self.mean_area
        return math.sqrt(2.0 * self.pressure * self.mean_area * (1.0 / self.phi0 - 1.0 / 0.8) / mean_mass)

    @cached_property
    def step_choice(self) -> Step:
        """The time step with its reason."""
        return choose_step(self.law_in_units, self.smallest, self.approach_speed, self)

    @property
    def neighbour_skin(self) -> float:
        """Skin of the neighbour list [a]."""
        return self.skin if self.skin is not None else max(0.1, 2.0 * self.law_in_units.d0)

    @property
    def hold_time(self) -> float:
        """50 periods of a contact of two largest discs and 10 of the cell (mass M on a stiffness of order K_N)."""
        if self.hold is not None:
            return self.hold
        kn = self.law_in_units.kn
        contact = 2.0 * math.pi * math.sqrt(0.5 / kn)
        total_mass = self.n * 4.0 / math.pi * self.mean_area
        length = math.sqrt(self.n * self.mean_area / self.phi0)
        cell = 2.0 * math.pi * math.sqrt(self.cell_mass * total_mass / length / kn)
        return max(50.0 * contact, 10.0 * cell)

    @property
    def berendsen_modulus(self) -> float:
        """Modulus B (with a period of 1 T0) in dL/dt / L = -(S - sigma)/(3 B), as LAMMPS scales the lengths.

        P/(3 B) is the rate of an empty cell.  A first-order barostat knows no inertia: it must answer more slowly than sound
        crosses the packing, K_N/(3 B) <= c/L with c = sqrt(K_N/rho), or it feeds the grains with energy for ever.
        """
        length = math.sqrt(self.n * self.mean_area / 0.8)
        sound = math.sqrt(self.law_in_units.kn / (0.8 * 4.0 / math.pi))
        return max(self.pressure / (3.0 * self.berendsen_rate), self.law_in_units.kn * length / (3.0 * sound))

    @property
    def compression_time(self) -> float:
        """Time in which the barostat closes the initial gas to a solid fraction of 0.8 [T0]."""
        strain = 1.0 - math.sqrt(self.phi0 / 0.8)
        if self.barostat == "berendsen":
            return 3.0 * self.berendsen_modulus * strain / self.pressure
        mass = self.cell_mass * self.n * 4.0 / math.pi * self.mean_area / math.sqrt(self.n * self.mean_area / self.phi0)
        return math.sqrt(2.0 * strain * mass / self.pressure)

    @property
    def digest(self) -> str:
        """Hash of the resolved scene, the run's identity."""
        text = json.dumps({"scene": self.name, **self.as_mapping()}, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

    def random(self, stage: str) -> np.random.Generator:
        """The random stream of a stage: its seed hashes what the stage depends on, so that stages are independent."""
        words = hashlib.sha256(f"{self.name}/{stage}/{self.seed}".encode()).digest()
        return np.random.default_rng(np.frombuffer(words, dtype=np.uint32))

    def discs(self) -> Discs:
        """The initial discs: random, not overlapping, every gap at least D0."""
        rng = self.random("placement")
        return place(diameters(self.n, self.smallest, rng), self.phi0, self.law_in_units.d0, rng)

    def files(self) -> dict[str, str]:
        """What the deck reads beside its data file: nothing."""
        return {}

    def variables(self) -> dict[str, str | int | float]:
        """Values of the variables of the deck method1.in."""
        step = self.step_choice.step
        law = self.law_in_units
        check = max(1, round(0.02 / step))

        def every(time: float) -> int:
            """Steps in ``time``, a multiple of the interval between checks that LAMMPS can count."""
            return check * min(math.ceil(time / (check * step)), MOST_STEPS // check)

        return {
            "kn": law.kn, "kt": law.kt, "zeta": law.zeta, "mu": min(law.mu, ENDLESS), "f0": law.f0, "d0": law.d0,
            "kr": law.kr, "mur": min(law.mur, ENDLESS),
            "stress": self.pressure, "force_unit": self.force_unit, "barostat": self.barostat,
            "cell_mass": self.cell_mass, "rate_cap": self.rate_cap, "convention": self.convention,
            "berendsen_modulus": self.berendsen_modulus,
            "force_tolerance": self.force_tolerance, "energy_tolerance": self.energy_tolerance,
            "hold": self.hold_time, "quiet": 2.0 * self.hold_time, "drag": self.drag,
            "step": step, "skin": self.neighbour_skin, "start_energy": 0.0, "account": "yes" if self.account else "no",
            "max_steps": every(self.max_time), "check_every": check, "series_every": every(self.series_interval),
            "frame_every": every(self.frame_interval) if self.frame_interval else 0,
            "checkpoint_every": every(self.checkpoint_interval),
        }  # fmt: skip

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

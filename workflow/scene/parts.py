"""What scenes are made of: grains, material, cell, equilibrium, numerics and output.

Units: length a (largest diameter), mass of a disc of diameter a, force F0; without cohesion the force unit is a P
(P = 1).  Time unit T0 = sqrt(m a/F0), or sqrt(m/P).  G07 is Gilabert, Roux, Castellanos, PRE 75, 011303 (2007).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from workflow.data.contact_law import ContactLaw
from workflow.scene.parameter import Parameters, parameter

LAWS = ("exact", "granular", "hooke/history")
LEAST_STEPS = 14.0  # per stiffest period: none is beyond the limit of stability


def idle(*rules: tuple[str, bool, str]) -> dict[str, str]:
    """Names that have no effect -> why: the names, separated by blanks, of every rule (why, whether it applies, names)."""
    return {name: why for why, applies, names in rules if applies for name in names.split()}


@dataclass(frozen=True, kw_only=True)
class Readings(Parameters):
    """Where a paper's procedure is not printed completely: the reading that its numbers speak for, or the printed form.

    ``READINGS``: parameter -> (value of the reading, value as printed), of the parameters that are not given.  What speaks
    for each is in docs/model.md.
    """

    READINGS: ClassVar[Mapping[str, tuple[Any, Any]]] = {}

    as_printed: bool = parameter(
        False, bool, "procedures as the paper prints them, where the default is another reading (docs/model.md)"
    )

    @classmethod
    def readings(cls) -> set[str]:
        """Parameters whose default depends on ``as_printed``."""
        return set(cls.READINGS)

    def __post_init__(self) -> None:
        for name, (read, printed) in self.READINGS.items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, printed if self.as_printed else read)
        super().__post_init__()


@dataclass(frozen=True, kw_only=True)
class Grains(Parameters):
    """How many discs, of what sizes, and where they start."""

    GROUP: ClassVar[str] = "grains"

    n: int = parameter(1400, int, "number of grains", symbol="N", low=1, high=1e9, source="G07 sec. III A")
    phi0: float = parameter(0.36, float, "initial solid fraction", symbol="Phi_I", low=1e-3, high=0.6, source="G07 table II")
    smallest: float = parameter(
        0.5, float, "smallest diameter; sizes are uniform in [smallest, 1]", unit="a", low=0.01, high=1.0,
        source="G07 sec. II A",
    )  # fmt: skip
    initial: str = parameter(
        None, str, "initial state: a hard-disc fluid in equilibrium, as mixing leaves it and at every phi0; or "
        "random_addition, disc by disc, jams earlier (sizes in [0.5, 1] near 0.47); or addition_by_size, largest first, which "
        "puts small discs between large ones", choices=("fluid", "random_addition", "addition_by_size"),
        source="D, G07 sec. III A is silent", automatic=True,
    )  # fmt: skip
    seed: int = parameter(1, int, "seed of sizes and positions", low=0, high=2**63 - 1)


@dataclass(frozen=True, kw_only=True)
class Material(Parameters):
    """The law's dimensionless numbers (G07 table I)."""

    GROUP: ClassVar[str] = "contact law"

    law: str = parameter(
        None, str, "contact law: exact (default, G07), LAMMPS's granular, with the plugin's attraction, or LAMMPS's "
        "hooke/history, without attraction and rolling resistance", choices=LAWS, automatic=True,
    )  # fmt: skip
    mu: float = parameter(0.5, float, "friction coefficient", symbol="mu", low=0.0, source="G07 table I: 0.15, 0.5")
    rolling: bool = parameter(False, bool, "rolling resistance", source="G07 eq. 10")
    cohesion: bool = parameter(True, bool, "attraction F0 of range D0", source="G07 eq. 4")
    kappa: float = parameter(
        1e5, float, "stiffness K_N a/F0 (K_N/P without cohesion or for P* > 1)", symbol="kappa", low=1e2, high=1e8,
        source="G07 table I",
    )  # fmt: skip
    zeta: float = parameter(0.8, float, "damping, fraction of critical", symbol="zeta", low=0.0, high=2.0, source="G07 eq. 6")
    d0: float = parameter(1e-3, float, "range of attraction", symbol="D0", unit="a", low=1e-6, high=0.1, source="G07 eq. 4")
    kt_ratio: float = parameter(1.0, float, "tangential stiffness K_T/K_N", above=0.0, high=10.0, source="G07 table I")
    kr_ratio: float = parameter(1e-4, float, "rolling stiffness K_r/(K_N a^2)", above=0.0, high=1.0, source="G07 table I")
    mur: float | None = parameter(
        None, float, "rolling friction mu_r, default 0.01 mu a", symbol="mu_r", unit="a", low=0.0, automatic=True,
        source="G07 table I",
    )  # fmt: skip

    @property
    def exact(self) -> bool:
        """The law is that of G07 as the plugin integrates it, not one of LAMMPS."""
        return self.law is None

    def contact_law(self, pressure: float) -> ContactLaw:
        """Coefficients in scene units for a pressure P in F0/a (cohesionless: P = 1)."""
        kn = self.kappa * (max(1.0, pressure) if self.cohesion else pressure)
        rolling_length = (0.01 * self.mu if self.mur is None else self.mur) if self.rolling else 0.0
        return ContactLaw(
            kn=kn,
            kt=kn * self.kt_ratio,
            zeta=self.zeta,
            mu=self.mu,
            f0=1.0 if self.cohesion else 0.0,
            d0=self.d0 if self.cohesion else 0.0,
            kr=kn * self.kr_ratio,
            mur=rolling_length,
        )


@dataclass(frozen=True, kw_only=True)
class Cell(Parameters):
    """Stress control of the periodic cell (G07 eq. 3)."""

    pstar: float = parameter(
        0.01, float, "reduced pressure P* = P a/F0 (without cohesion P is 1)", symbol="P*", unit="F0/a",
        above=0.0, high=100.0, source="G07 eq. 12",
    )  # fmt: skip
    barostat: str = parameter(
        "inertial", str, "inertial (G07 eq. 3), LAMMPS's inertial nph, or its first-order berendsen",
        choices=("inertial", "nph", "berendsen"),
    )  # fmt: skip
    cell: str = parameter(
        None, str, "equation of the cell: of its lengths (Parrinello and Rahman; default) or of its strain (G07 eq. 3 as "
        "printed)", choices=("lengths", "strain"), automatic=True, source="G07 sec. II A",
    )  # fmt: skip
    cell_mass: float = parameter(
        None, float, "inertia of the cell: W/sum(m_i), default 0.6, with the equation of the lengths; M L/sum(m_i), default "
        "0.3, with that of the strain", above=0.0, high=1e4, automatic=True, source="G07 sec. II A prints 0.3",
    )  # fmt: skip
    rate_cap: float = parameter(
        None, float, "cap on the strain rate |dL/dt|/L0, 0 for none (default, but 0.05 in method2 as printed)", unit="1/T0",
        low=0.0, high=1e9, automatic=True, source="G07 sec. III B",
    )  # fmt: skip
    wall_cap: float = parameter(
        None, float, "cap on the speed of the walls |dL/dt|, 0 for none (default, but 0.05 in method2)", unit="a/T0", low=0.0,
        high=1e9, automatic=True, source="G07 sec. III B",
    )  # fmt: skip
    convention: int = parameter(
        0, int, "c in m dv/dt = F + c m (dL/dt/L) v: 0 decided here, 1: L s'' = F/m, -1: Hamiltonian", low=-1, high=1
    )
    berendsen_rate: float = parameter(
        0.05, float, "strain rate of an empty cell under the berendsen barostat, lowered where a stiff packing needs it",
        unit="1/T0", above=0.0, high=10.0,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Equilibrium(Parameters):
    """When a stage ends (G07 sec. II D) and how the last vibrations are taken out."""

    force_tolerance: float = parameter(
        1e-4, float, "largest net force and moment, and stress error unless a hundredth of P is less, in units of "
        "F1 = max(F0, P a)", above=0.0, high=1.0, source="G07 sec. II D",
    )  # fmt: skip
    energy_tolerance: float = parameter(
        5e-8, float, "kinetic energy per grain, without cohesion of those that are held, in units of F1 a", above=0.0,
        high=1.0, source="G07 sec. II D",
    )  # fmt: skip
    hold: float | None = parameter(
        None, float, "time the criteria must hold, default 50 contact periods and 10 cell oscillations", unit="T0",
        low=0.0, high=1e9, automatic=True,
    )  # fmt: skip
    dashpots: float = parameter(
        0.5, float, "dashpots on the tangential and rolling springs in the stages that wait for equilibrium, which start once "
        "the force-carrying network is calm; fraction of critical; 0 and drag 0: no such stage", low=0.0, high=1.0,
    )  # fmt: skip
    drag: float = parameter(
        0.0, float, "background drag on grains and cell in the same stages; it also stops grains that roll or fly",
        unit="1/T0", low=0.0, high=100.0,
    )  # fmt: skip
    max_time: float = parameter(
        None, float, "longest time of each stage, default 500 or five times what the compression takes", unit="T0", above=0.0,
        high=1e9, automatic=True,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Numerics(Parameters):
    """Step, neighbour list, energy account and output."""

    GROUP: ClassVar[str] = "numerics"

    step: float | None = parameter(
        None, float, "time step, default from the stiffest period and the tail", unit="T0", low=1e-9, high=1.0, automatic=True
    )
    steps_per_period: float = parameter(28.0, float, "steps per stiffest period", low=LEAST_STEPS, high=1e4)
    skin: float | None = parameter(
        None, float, "neighbour skin, default 0.1 a or twice the range of attraction", unit="a", above=0.0, high=1.0,
        automatic=True,
    )  # fmt: skip
    scheme: str = parameter(
        "second", str, "time integration: second order in the step, or that of the paper (dampers see half-step velocities), "
        "which is that of LAMMPS's laws; synchronized: granular with its synchronized_verlet",
        choices=("second", "paper", "synchronized"),
    )  # fmt: skip
    account: bool = parameter(True, bool, "energy account (what viscosity, sliding and rolling dissipate)")
    frame_interval: float = parameter(
        0.0, float, "time between frames, 0: at the ends of stages only", unit="T0", low=0.0, high=1e9, group="output"
    )
    series_interval: float = parameter(
        0.2, float, "time between rows of the time series", unit="T0", above=0.0, high=1e9, group="output"
    )
    checkpoint_interval: float = parameter(
        5.0, float, "time between checkpoints", unit="T0", above=0.0, high=1e9, group="output"
    )

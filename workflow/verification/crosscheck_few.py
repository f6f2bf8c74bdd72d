"""A few cohesionless discs in several engines, over steps, against the independent reference integrator of our law."""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TextIO

import numpy as np

from workflow.data.contact_law import ContactLaw
from workflow.data.progress import Meter
from workflow.reference.discs import Discs as Group
from workflow.verification.accuracy import period
from workflow.verification.few_discs import CONTACT, Case, trajectory, worst_of_each
from workflow.verification.one_run import Outcome
from workflow.verification.one_run import run as run_own
from workflow.verification.other_engines import PEERS
from workflow.verification.other_engines import run as run_peer

EXACT, TWIN = "exact", "granular"  # ours, and LAMMPS's own style, whose Coulomb limit is that of the others
OWN: dict[str, dict[str, object]] = {
    EXACT: {"contact_model": "disc"}, "exact, paper's scheme": {"contact_model": "disc", "scheme": "paper"},
    TWIN: {"contact_model": "stock"},
}  # fmt: skip
STEPS = (28, 56, 112, 224, 448)  # per stiffest period
COUNT = 8  # groups of each case


@dataclass(frozen=True)
class FewBodyError:
    """One case, engine and step.  ``error``: root mean square over groups of the largest difference of position [a], velocity
    and surface velocity [impact speed] to the reference of our law; ``to_granular``: the same to LAMMPS's `granular` at
    the same step, None where that did not run."""

    case: str
    engine: str
    steps_per_period: float
    step: float
    error: float
    to_granular: float | None


def few_cases(count: int = COUNT, seed: int = 1) -> list[Case]:
    """Head-on; oblique with friction, undamped, stiffer and damped; one disc against two.  Diameters are 1, 3/4 and 1/2."""
    rng = np.random.default_rng(seed)
    speeds = np.linspace(0.3, 1.0, count)

    def impacts(across: float, omega: float) -> list[Group]:
        groups = []
        for k, speed in enumerate(speeds):
            first, second = ((1.0, 0.75), (0.75, 0.5), (1.0, 1.0), (1.0, 0.5))[k % 4]
            distance = 0.5 * (first + second) + rng.uniform(2e-3, 4e-3)
            moving = [-speed, across * speed * (-1) ** k]
            turning = omega * rng.normal(size=2)
            groups.append(Group([[0, 0], [distance, 0]], [[0, 0], moving], turning, [first, second]))  # type: ignore[arg-type]
        return groups

    def against_two() -> list[Group]:
        groups = []
        for speed in speeds:
            gap, high = rng.uniform(2e-3, 4e-3), 0.5 + 1e-4
            away, aside = math.sqrt((0.875 + gap) ** 2 - high**2), rng.uniform(-0.02, 0.02)
            position, velocity = [[0, high], [0, -high], [-away, aside]], [[0, 0], [0, 0], [speed, 0]]
            groups.append(Group(position, velocity, rng.normal(size=3), [1.0, 1.0, 0.75]))  # type: ignore[arg-type]
        return groups

    smooth, rough, damped = {**CONTACT, "zeta": 0.8}, {**CONTACT, "mu": 0.5}, {**CONTACT, "zeta": 0.8, "mu": 0.5}
    stiff = {name: 100.0 * value for name, value in CONTACT.items()} | {"mu": 0.5}

    def case(name: str, meaning: str, law: dict[str, float], groups: list[Group]) -> Case:
        return Case(name, meaning, ContactLaw(**law), groups, 0.06, trajectory, worst_of_each)

    return [
        case("head-on", "damped, no friction", smooth, impacts(0.0, 0.0)),
        case("oblique, undamped", "friction and spin, no damping", rough, impacts(0.7, 1.0)),
        case(
            "oblique, undamped, stiff",
            "the same with 100 times the stiffness: a tenth of the overlap",
            stiff,
            impacts(0.7, 1.0),
        ),
        case("oblique, damped", "friction, spin and damping", damped, impacts(0.7, 1.0)),
        case("one against two, smooth", "damped, no friction", smooth, against_two()),
        case("one against two", "friction, spin and damping", damped, against_two()),
    ]


def few_bodies(
    peers: Sequence[str] = PEERS,
    steps: Sequence[float] = STEPS,
    chosen: Sequence[Case] | None = None,
    out: TextIO = sys.stderr,
) -> list[FewBodyError]:
    """Cases (default: every one) in our engine, LAMMPS's `granular` and ``peers``, at so many steps per stiffest period."""
    chosen, engines = chosen or few_cases(), (TWIN, *(name for name in OWN if name != TWIN), *peers)
    meter = Meter(len(chosen) * len(steps) * len(engines), out)
    rows = []
    for case in chosen:
        exact = case.measure(case.groups, case.reference())
        for many in steps:
            count = math.ceil(case.duration * many / period(case))
            found = {}
            for name in engines:
                end = _run(name, case, case.duration / count, count)
                found[name] = case.measure(case.groups, case.states(end))
                meter.add(1, f"{case.name}, {name}, {many:g} steps per period")
                error, twin = (case.distance(found[name], other) for other in (exact, found[TWIN]))
                rows.append(FewBodyError(case.name, name, many, case.duration / count, error, twin))
    meter.end()
    return rows


def _run(name: str, case: Case, step: float, steps: int) -> Outcome:
    discs, velocity, omega = case.discs()
    if name in OWN:
        values = {**asdict(case.law), **OWN[name], "step": step, "steps": steps}
        return run_own(discs, values, velocity=velocity, omega=omega)
    with tempfile.TemporaryDirectory() as folder:
        return run_peer(Path(folder), name, discs, case.law, {"step": step, "steps": steps}, velocity, omega)

"""The time step of a scene, and why it is what it is: the stiffest period of a packing and the limits of stability."""

from __future__ import annotations

import math
from dataclasses import dataclass

from workflow.data.contact_law import ContactLaw
from workflow.scene.parts import Numerics

CONTACTS_OF_A_DISC = 6  # of equal size around one disc; what the largest frequency is estimated with
ROLLING_DASHPOT = 10.0  # fraction of critical of the dashpot on the rolling spring over that on the tangential one
# steps per period at which a damped contact is at the limit of stability; the default of 28 stays four times below it, or two
# times: the second scheme is accurate there
STEPS_TO_LIMIT = {"paper": 7.0, "synchronized": 7.0, "second": 14.0}


@dataclass(frozen=True)
class Step:
    """The chosen time step and why: ``step`` T0, ``period`` stiffest period, ``limit`` of stability, ``reason`` in words."""

    step: float
    period: float
    limit: float
    reason: str


def choose_step(law: ContactLaw, smallest: float, speed: float, numerics: Numerics, dashpots: float = 0.0) -> Step:
    """The step from the stiffest period and from the tail, D0/(v step) >= 5 at approach speed v.

    The stiffest period is 2 pi/omega_max, or STEPS_TO_LIMIT times the largest stable step of a damped contact if that
    is less.  ``smallest``: smallest diameter [a], mass d^2; ``speed``: approach speed that the scene must expect [a/T0];
    ``dashpots``: of the stages that wait for equilibrium, which must be stable too.
    """
    swing = stiffest_period(law, smallest)
    damped = damped_limit(law, smallest, numerics.scheme)
    helped = dashpot_limit(law, smallest, dashpots)
    period, limit = min(swing, STEPS_TO_LIMIT[numerics.scheme] * damped), min(0.25 * swing, damped, helped)
    if numerics.step is not None:
        words = f"given; {period / numerics.step:.1f} steps per stiffest period {period:.3g}"
        return Step(numerics.step, period, limit, words)
    step = period / numerics.steps_per_period
    reason = f"stiffest period {period:.3g} / {numerics.steps_per_period:g}" + (
        ", set by the damping" if period < swing else ""
    )
    if 0.8 * helped < step:
        step, reason = (
            0.8 * helped,
            f"0.8 of the largest step that dashpots {dashpots:g} allow for the smallest discs: lower them",
        )
    tail = law.d0 / (5.0 * speed) if law.f0 > 0 and speed > 0 else math.inf
    if tail < step:
        step, reason = tail, f"five steps in the tail of range {law.d0:g} at approach speed {speed:.3g}"
    return Step(step, period, limit, reason)


def stiffest_period(law: ContactLaw, smallest: float) -> float:
    """2 pi/omega, an estimate for the stiffest vibration of a packing with discs of diameter ``smallest`` (mass d^2).

    A disc held by six equal neighbours: omega^2 m = 3 (K_N + K_T) for translation, 12 K_T (+ 12 K_r/R^2) for rotation
    (I = m R^2/2), and 6 K_T (pair: reduced mass, both rotations) for the tangential mode of two discs.
    """
    kt, kr = _tangential(law), _rolling(law)
    translation = 0.5 * CONTACTS_OF_A_DISC * (law.kn + kt)
    largest = max(translation, 2.0 * CONTACTS_OF_A_DISC * kt + 2.0 * CONTACTS_OF_A_DISC * 16.0 * kr)
    return 2.0 * math.pi * smallest / math.sqrt(largest)


def damped_limit(law: ContactLaw, diameter: float, scheme: str) -> float:
    """Largest stable step of damped discs of ``diameter`` (mass d^2): (2/omega) (sqrt(1 + b^2) - b), b = z or 2 z.

    A damping force that sees the velocity of half a step before makes velocity Verlet unstable beyond this step with
    b = z (scheme ``paper``); one that sees it extrapolated from the last two half steps, with b = 2 z (``second``).
    omega^2 = 6 K_N/m and z = sqrt(3) zeta are those of the fastest vibration of equal discs, each held by six:
    neighbours against each other, damping 6 eta/m with m* = m/2.
    """
    b = math.sqrt(0.5 * CONTACTS_OF_A_DISC) * law.zeta * (2.0 if scheme == "second" else 1.0)
    return 2.0 * diameter / math.sqrt(CONTACTS_OF_A_DISC * law.kn) * (math.sqrt(1.0 + b * b) - b)


def dashpot_limit(law: ContactLaw, diameter: float, share: float) -> float:
    """Largest stable step of a disc of ``diameter`` that turns between six of diameter 1, with dashpots ``share`` of critical
    on the tangential springs: (2/omega) (sqrt(1 + z^2) - z), z = Gamma/(2 omega), as in `damped_limit`.

    omega^2 = 6 (K_T R^2 + K_r)/I and Gamma = 6 gamma_t R^2/I.
    """
    if share == 0.0 or law.mu == 0.0:
        return math.inf
    omega, per_inertia, damping = _turning(law, diameter, share)
    z = 0.5 * per_inertia * damping / omega
    return 2.0 / omega / (math.sqrt(1.0 + z * z) + z)


def rolling_dashpot(law: ContactLaw, diameter: float, share: float, step: float) -> float:
    """Dashpot of the rolling springs, fraction of critical: ROLLING_DASHPOT times ``share``, or what such a ``step`` is
    stable with.

    Critical is that of equal discs, I* = m* (R_i + R_j)^2/8; for a disc much smaller than its neighbours it would be far
    more, and shorten the step.
    """
    wanted = ROLLING_DASHPOT * share
    if wanted == 0.0 or law.mur == 0.0:
        return wanted
    omega, per_inertia, damping = _turning(law, diameter, share)
    phase = 1.25 * step * omega
    room = (1.0 - 0.25 * phase * phase) / phase * 2.0 * omega / per_inertia - damping
    mass = diameter**2
    critical = math.sqrt(4.0 * law.kr * mass / (1.0 + mass) * (0.5 * (1.0 + diameter)) ** 2 / 2.0)
    return min(wanted, max(room, 0.0) / critical)


def _turning(law: ContactLaw, diameter: float, share: float) -> tuple[float, float, float]:
    """omega of `dashpot_limit`, 6/I, and the damping gamma_t R^2 of one contact."""
    radius, mass = 0.5 * diameter, diameter**2
    kt, kr = _tangential(law), _rolling(law)
    per_inertia = CONTACTS_OF_A_DISC * 2.0 / (mass * radius**2)
    omega = math.sqrt(per_inertia * (kt * radius**2 + kr))
    return omega, per_inertia, share * math.sqrt(4.0 * kt * mass / (1.0 + mass)) * radius**2


def _tangential(law: ContactLaw) -> float:
    """K_T of springs that act."""
    return law.kt if law.mu > 0 else 0.0


def _rolling(law: ContactLaw) -> float:
    """K_r of springs that act."""
    return law.kr if law.mur > 0 else 0.0

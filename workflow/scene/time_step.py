"""The time step of a scene, and why it is what it is."""

from __future__ import annotations

import math
from dataclasses import dataclass

from workflow.scene.parts import STEPS_TO_LIMIT, Law, Numerics


@dataclass(frozen=True)
class Step:
    """The chosen time step and why: ``step`` T0, ``period`` stiffest period, ``limit`` of stability, ``reason`` in words."""

    step: float
    period: float
    limit: float
    reason: str


def choose_step(law: Law, smallest: float, speed: float, numerics: Numerics, dashpots: float = 0.0) -> Step:
    """The step from the stiffest period and from the tail, D0/(v step) >= 5 at approach speed v.

    The stiffest period is 2 pi/omega_max, or STEPS_TO_LIMIT times the largest stable step of a damped contact if that
    is less.  ``smallest``: smallest diameter [a], mass d^2; ``speed``: approach speed that the scene must expect [a/T0];
    ``dashpots``: of the stages that wait for equilibrium, which must be stable too.
    """
    swing = 2.0 * math.pi * smallest / math.sqrt(law.largest_frequency_per_mass)
    damped = law.damped_limit(smallest, numerics.scheme)
    helped = law.dashpot_limit(smallest, dashpots)
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

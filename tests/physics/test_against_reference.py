"""Collisions of a few discs against the independent reference integrator, as the step shrinks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from workflow.data.frame import Frame
from workflow.reference.cohesive import CohesiveLaw
from workflow.reference.discs import Cell, Discs, Trajectory
from workflow.reference.integrate import integrate

LENGTH, DURATION, SPEED = 8.0, 0.5, 1.5
FREQUENCY = 110.0  # sqrt(K_N/m*) of two discs of diameter 1/2 and the largest K_N
LEVELS = (1000, 4000, 16000)
JITTER = (1.0, 1.13, 1.29)  # an event falls anywhere between two steps: three counts per level average over that
CONTACT = {"kn": 1e3, "kt": 700.0}
TAIL = {"f0": 1.5, "d0": 1e-2}
ROLLING = {"kr": 20.0, "mur": 2e-2}
LAWS = {
    "elastic": CONTACT,
    "damped": {**CONTACT, "zeta": 0.3},
    "overdamped": {**CONTACT, "zeta": 1.5},
    "friction": {**CONTACT, "zeta": 0.2, "mu": 0.3},
    "cohesion": {**CONTACT, **TAIL},
    "sticky": {**CONTACT, **TAIL, "zeta": 0.8, "mu": 0.5},
    "rolling": {**CONTACT, **ROLLING, "zeta": 0.1, "mu": 0.2},
    "full": {**CONTACT, **TAIL, **ROLLING, "zeta": 0.4, "mu": 0.15},
}
SHRINK = {"none": (0.0, 0.0), "both": (0.2, 0.2), "one": (0.3, 0.0)}
# two to six discs under every law: 2, 5; 3, 6; 4, 2; ...
CASES = [(name, 2 + (k + more) % 5, "none") for k, name in enumerate(LAWS) for more in (0, 3)]
CASES += [(name, 5, shrink) for name in ("elastic", "sticky", "full") for shrink in ("both", "one")]


def random_law(name: str, rng: np.random.Generator) -> dict[str, float]:
    """A law of this kind, every coefficient between half of it and one and a half."""
    return {key: value * rng.uniform(0.5, 1.5) for key, value in LAWS[name].items()}


def scene(count: int, rng: np.random.Generator) -> Discs:
    """Random discs close around a point near the middle of the cell and thrown at it, spinning."""
    angle = 2.0 * np.pi * (np.arange(count) + rng.uniform(-0.2, 0.2, count)) / count
    outward = np.column_stack((np.cos(angle), np.sin(angle)))
    diameter = rng.uniform(0.5, 1.0, count)
    i, j = np.triu_indices(count, 1)
    radius = np.max(((diameter[i] + diameter[j]) / 2.0 + 0.05) / np.hypot(*(outward[i] - outward[j]).T))
    velocity = -rng.uniform(0.5, SPEED, (count, 1)) * outward + rng.normal(scale=0.1, size=(count, 2))
    return Discs(LENGTH / 2.0 + radius * outward, velocity, rng.normal(scale=2.0, size=count), diameter)


def errors(frame: Frame, run: Trajectory) -> float:
    """Largest difference of positions, velocities and surface velocities."""
    # the engine wraps positions into its cell
    away = (frame.position - run.position[-1] + frame.cell / 2.0) % frame.cell - frame.cell / 2.0
    turning = (frame.omega - run.omega[-1]) * frame.diameter / 2.0
    return max(np.abs(away).max(), np.abs(frame.velocity - run.velocity[-1]).max(), np.abs(turning).max())


@pytest.mark.parametrize(("name", "count", "shrink"), CASES)
def test_converges_to_the_reference(discs: Callable[..., Any], name: str, count: int, shrink: str) -> None:
    rng = np.random.default_rng([count, list(LAWS).index(name), list(SHRINK).index(shrink)])
    law, start, rate = random_law(name, rng), scene(count, rng), SHRINK[shrink]
    cell = Cell(np.array([LENGTH, LENGTH]), rate)
    run = integrate(CohesiveLaw(**law), start, DURATION, cell=cell)
    # a stress far beyond what the grains bear holds the strain rate at its cap from the first half step on
    stress = " ".join("1e9" if r else "NULL" for r in rate)
    move = f"stress {stress} rate {max(rate)}" if max(rate) else ""
    shared = {"position": start.position, "velocity": start.velocity, "omega": start.omega, "diameter": start.diameter}

    def error(steps: int) -> float:
        sample = discs(**shared, law=law, cell=(LENGTH, LENGTH), step=DURATION / steps, move=move)
        return errors(sample.run(steps).frame(), run)

    found = [np.sqrt(np.mean([error(round(factor * level)) ** 2 for factor in JITTER])) for level in LEVELS]
    slope = np.polyfit(np.log(LEVELS), np.log(found), 1)[0]
    assert run.events
    # three counts leave 0.35 of scatter in the slope
    assert slope < 0.35 - 2
    assert found[-1] < SPEED * (FREQUENCY * DURATION / LEVELS[-1]) ** 2


@pytest.mark.parametrize("name", ["elastic", "damped", "friction"])
def test_scheme_of_the_paper_is_first_order_with_damping_and_friction(
    discs: Callable[..., Any], rewrite: Callable[[str, str], None], name: str
) -> None:
    """Forces that see the velocity of half a step before, and springs that slip, make it first order."""
    rewrite("pair_style disc/cohesive", "pair_style disc/cohesive scheme paper")
    start = scene(3, np.random.default_rng(list(LAWS).index(name)))
    run = integrate(CohesiveLaw(**LAWS[name]), start, DURATION, cell=Cell(np.array([LENGTH, LENGTH])))
    shared = {"position": start.position, "velocity": start.velocity, "omega": start.omega, "diameter": start.diameter}

    def error(steps: int) -> float:
        sample = discs(**shared, law=LAWS[name], cell=(LENGTH, LENGTH), step=DURATION / steps)
        return errors(sample.run(steps).frame(), run)

    found = [np.sqrt(np.mean([error(round(factor * level)) ** 2 for factor in JITTER])) for level in LEVELS]
    slope = np.polyfit(np.log(LEVELS), np.log(found), 1)[0]
    order = 2 if name == "elastic" else 1
    assert abs(slope + order) < 0.35


@pytest.mark.parametrize("smallest", [0.1, 0.01])
def test_second_order_at_a_large_size_ratio(discs: Callable[..., Any], smallest: float) -> None:
    """A small disc glances off a large one, spinning: lever arms of 1/2 and 1/200, masses of 1 and 1e-4."""
    law = LAWS["full"] | {"d0": 1e-3, "f0": 0.01 * smallest}
    touch, frequency = (1.0 + smallest) / 2.0, np.sqrt(law["kn"] * (1.0 + smallest**-2))
    start = Discs(
        np.array([[3.0, 3.0], [3.0 + 0.8 * touch, 3.0 + 0.6 * touch + 1.5e-3]]),
        np.array([[0.0, 0.0], [-0.6, -0.5]]), np.array([0.5, 20.0 / smallest]), np.array([1.0, smallest]),
    )  # fmt: skip
    duration = 0.02
    run = integrate(CohesiveLaw(**law), start, duration, cell=Cell(np.array([LENGTH, LENGTH])))
    shared = {"position": start.position, "velocity": start.velocity, "omega": start.omega, "diameter": start.diameter}
    levels = [round(duration * frequency / phase) for phase in (0.1, 0.025, 0.00625)]

    def error(steps: int) -> float:
        return errors(discs(**shared, law=law, cell=(LENGTH, LENGTH), step=duration / steps).run(steps).frame(), run)

    found = [np.sqrt(np.mean([error(round(factor * level)) ** 2 for factor in JITTER])) for level in levels]
    assert run.events
    assert np.polyfit(np.log(levels), np.log(found), 1)[0] < 0.35 - 2

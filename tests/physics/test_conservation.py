"""Conservation laws of many discs, and the energy account."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from workflow.data.frame import Frame

LAW = {"kn": 1e3, "kt": 800.0, "zeta": 0.3, "mu": 0.3, "f0": 0.5, "d0": 2e-2, "kr": 1.0, "mur": 1e-2}
MOVES = {
    "fixed": "",
    "stressed": "stress 3 2 mass 1",
    "capped": "stress 50 50 rate 0.2",
    "dragged": "stress 3 3 drag 0.5",
}
MOVES |= {"Parrinello-Rahman": "stress 3 2 mass 1 convention -1", "affine": "stress 3 2 mass 1 convention 1"}
MOVES |= {"strain": "stress 3 2 cell strain mass 1", "walls": "stress 50 50 wall 1", "quenched": "stress 3 3 quench 1"}


def test_momentum_is_conserved(discs: Callable[..., Any], gas: Callable[..., Any]) -> None:
    scene = gas(100, 0.45, seed=2, speed=1.0)
    sample = discs(**scene, law=LAW, step=5e-4)
    frames = sample.record(4000, 400)
    scale = np.sum(frames[0].mass[:, None] * np.abs(frames[0].velocity))
    for frame in frames:
        # 4000 steps of 100 grains round at 1e-16 each, as a random walk: 6e-14 of a momentum
        np.testing.assert_allclose(frame.mass @ frame.velocity, 0.0, rtol=0.0, atol=1e-14 * scale)
    assert sum(len(frame.interactions) for frame in frames) > 300


def angular(frame: Frame) -> float:
    x, v = frame.position, frame.velocity
    return float(frame.mass @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]) + frame.mass * frame.diameter**2 / 8.0 @ frame.omega)


def test_angular_momentum_changes_by_overlap_times_tangential_force(discs: Callable[..., Any]) -> None:
    """T acts on the radii, which exceed the distance by the overlap: d/dt of the total angular momentum is sum of h T."""
    rng = np.random.default_rng(3)
    grid = np.stack(np.meshgrid(np.arange(5), np.arange(5)), -1).reshape(-1, 2)
    position = 10.0 + 1.05 * (grid - 2.0) + rng.uniform(-0.02, 0.02, (25, 2))
    scene = {"position": position, "diameter": rng.uniform(0.9, 1.0, 25), "cell": (20, 20),
             "velocity": -0.5 * (position - 10.0) + rng.normal(scale=0.2, size=(25, 2)), "omega": rng.normal(scale=3.0, size=25)}  # fmt: skip
    step = 1e-4
    frames = discs(**scene, law={**LAW, "kn": 200.0, "kt": 200.0}, step=step).record(8000, 4)
    moment = np.array([angular(frame) for frame in frames])
    rate = np.array([np.minimum(frame.interactions.gap, 0.0) @ frame.interactions.tangential for frame in frames])
    change = moment - moment[0]
    integral = np.concatenate(([0.0], np.cumsum(2.0 * step * (rate[1:] + rate[:-1]))))
    assert np.ptp(change) > 1e-3
    # trapezoidal rule over 4 steps of contacts that last some 500, with kinks at their ends
    np.testing.assert_allclose(change, integral, rtol=0.0, atol=1e-3 * np.ptp(change))


def residual(sample: Any, steps: int) -> tuple[float, float]:
    """Residual of the energy account after ``steps``, and the energy that was dissipated in them."""

    def account() -> tuple[float, float]:
        frame, energy, move = sample.frame(), sample.energy(), sample.vector("move", 7)
        kinetic = frame.mass @ (frame.velocity**2).sum(axis=1) / 2.0 + frame.mass * frame.diameter**2 @ frame.omega**2 / 16.0
        return kinetic + energy.sum() + move[6] - move[4], energy[4:].sum() + move[6]

    start = account()
    sample.run(steps)
    return account()[0] - start[0], account()[1] - start[1]


@pytest.mark.parametrize("name", MOVES)
def test_energy_account_closes_to_second_order(discs: Callable[..., Any], gas: Callable[..., Any], name: str) -> None:
    """kinetic + stored + lost + taken by drag - work of the cell stays what it was."""
    found = []
    for refinement in (1, 4, 16):
        sample = discs(**gas(60, 0.5, seed=4, speed=1.0), law=LAW, step=1e-3 / refinement, move=MOVES[name])
        error, lost = residual(sample, 800 * refinement)
        found.append(abs(error) / lost)
    assert lost > 1.0
    # what is counted is what the kicks take, so that only the conservative part of the scheme is left: (omega dt)^2/24 per contact;
    # 16^2 = 256 between the first and the last, less where a few contacts begin or end at another phase of a step
    assert found[0] < 1e-3 and found[2] < found[0] / 60


@pytest.mark.parametrize("name", ["fixed", "stressed"])
def test_account_of_the_scheme_of_the_paper_closes_too(
    discs: Callable[..., Any], gas: Callable[..., Any], rewrite: Callable[[str, str], None], name: str
) -> None:
    """Its dampers see the velocity of half a step before, which changes what is lost, but not that it is counted."""
    rewrite("pair_style disc/cohesive", "pair_style disc/cohesive scheme paper")
    found = []
    for refinement in (1, 16):
        sample = discs(**gas(60, 0.5, seed=4, speed=1.0), law=LAW, step=1e-3 / refinement, move=MOVES[name])
        error, lost = residual(sample, 800 * refinement)
        found.append(abs(error) / lost)
    # 0.2 counted the damper at the half-step velocity: the order of sqrt(2 K_N/m) dt, 0.06
    assert found[0] < 2e-3 and found[1] < found[0] / 60

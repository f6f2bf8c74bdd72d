"""The continuous law of B97 in the reference integrator: closed forms and conservation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from workflow.errors import InputError
from workflow.reference.continuous import ContinuousLaw
from workflow.reference.discs import Discs, Trajectory
from workflow.reference.integrate import integrate

LAWS = [{"index": 36}, {"index": 144, "cutoff": 1.047}, {"index": 12, "cutoff": 1.5}, {"stiffness": 500.0}]


def above(height: float, velocity: Any = (0.0, 0.0), omega: float = 0.0) -> Discs:
    """A unit disc above a fixed one."""
    return Discs([[0.0, 0.0], [0.0, height]], [[0.0, 0.0], list(velocity)], [0.0, omega], [1.0, 1.0], [math.inf, 1.0])


def fall(law: ContinuousLaw, start: Discs, times: Any) -> Trajectory:
    return integrate(law, start, times[-1], t_eval=times, gravity=(0.0, -1.0), rtol=1e-10)


@pytest.mark.parametrize("law", LAWS)
def test_unit_weight_rests_at_unit_distance(law: dict[str, Any]) -> None:
    """Hooke: the overlap is m g/k; the continuous law is made so that r = sigma for every index."""
    run = fall(ContinuousLaw(**law), above(1.01), np.linspace(0.0, 10.0, 2))
    expected = -1.0 / law["stiffness"] if "stiffness" in law else 0.0
    # after 10 time units what is left of the first swing is below 1e-2 exp(-0.5 * 3.6 * 10) = 2e-10
    assert run.gap[-1, 0] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("index", [12, 36, 144])
def test_damping_is_half_critical(index: int) -> None:
    """Small swings about r = sigma are those of m x'' + sqrt(m k) x' + k x = 0, k = n + 1: damping ratio 1/2."""
    omega, start, times = math.sqrt(index + 1.0), 1e-7, np.linspace(0.0, 1.0, 20)
    run = fall(ContinuousLaw(index=index), above(1.0 + start), times)
    damped = math.sqrt(0.75) * omega
    swing = np.cos(damped * times) + 0.5 * omega / damped * np.sin(damped * times)
    # the force is not linear: relative error (n + 2)/2 times the swing
    assert run.gap[:, 0] / start == pytest.approx(np.exp(-0.5 * omega * times) * swing, abs=1e-4)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("mu", [0.2, 0.6])
def test_friction_reaches_amontons_law(law: dict[str, Any], mu: float) -> None:
    """A disc that turns against another, both held at r = 0.98: T rises by eq. 5 and stays at mu N."""
    distance, omega = 0.98, 0.5
    start = Discs([[0.0, 0.0], [0.0, distance]], np.zeros((2, 2)), [0.0, omega], [1.0, 1.0], [math.inf] * 2)
    r0 = 1.0 if "stiffness" in law else law.get("cutoff", 1.2)
    largest, speed = 1.214 * mu * (r0 - distance), 0.5 * distance * omega
    times = np.array([0.0, 0.3, 3.0]) * largest / speed
    run = integrate(ContinuousLaw(**law, mu=mu), start, times[-1], t_eval=times, rtol=1e-10)
    elastic = 500.0 * 0.02 if "stiffness" in law else 0.98 ** -(law["index"] + 1.0)
    damping = math.sqrt(1.5 * elastic / (1.214 * (r0 - distance)) * math.sqrt(0.7))
    assert run.normal[:, 0] == pytest.approx(elastic, rel=1e-12)
    assert run.tangential[1, 0] == pytest.approx(mu * elastic * (1.0 - 0.7**1.5) + damping * speed, rel=1e-9)
    assert run.tangential[2, 0] == pytest.approx(mu * elastic, rel=1e-12)


@pytest.mark.parametrize("law", LAWS[:3])
def test_oblique_collision_keeps_both_momenta_and_the_energy_account(law: dict[str, Any]) -> None:
    diameter = np.array([1.0, 0.8])
    start = Discs([[0.0, 0.0], [1.5, 0.2]], [[0.7, 0.1], [-1.6, 0.0]], [2.0, -1.0], diameter)
    sigma, mass = 0.9, 2.0 * 0.64 / 1.64
    run = integrate(ContinuousLaw(**law, sigma=sigma, mass=mass), start, 1.5, t_eval=np.linspace(0.0, 1.5, 9), rtol=1e-10)
    assert "close" in [event.kind for event in run.events]
    (x, y), (vx, vy) = np.moveaxis(run.position, 2, 0), np.moveaxis(run.velocity, 2, 0)
    angular = (x * vy - y * vx) @ start.mass + run.omega @ (1.0 / start.inverse_inertia)
    assert angular == pytest.approx(angular[0], abs=1e-9)
    assert np.abs(run.energy.residual).max() < 1e-8
    assert run.energy.viscous[-1] > 0.1


def test_printed_forms_differ_only_where_grains_move_sideways() -> None:
    def end(velocity: tuple[float, float], **printed: bool) -> float:
        return float(fall(ContinuousLaw(**printed), above(1.1, velocity), np.linspace(0.0, 0.4, 2)).position[-1, 1, 0])

    for name in ("printed_rotation", "printed_damping"):
        assert end((0.0, -0.5), **{name: True}) == pytest.approx(0.0, abs=1e-12)
        assert abs(end((0.5, -0.5), **{name: True}) - end((0.5, -0.5))) > 1e-4


@pytest.mark.parametrize("wrong", [{"index": 0}, {"cutoff": 0.9}, {"mu": -0.1}, {"alpha": 0.0}, {"force": math.inf}])
def test_values_out_of_range_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(wrong))):
        ContinuousLaw(**wrong)

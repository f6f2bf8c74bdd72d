"""Two discs against closed forms."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

KN, CELL = 1e5, 10.0


def pair(d1: float, d2: float, gap: float, angle: float = 0.0, vn: float = 0.0) -> dict[str, Any]:
    """Disc 2 a ``gap`` away from disc 1 along ``angle`` (degrees), centre of mass at rest near a corner of the cell, so
    that the pair lies across the periodic boundary."""
    n = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    m1, m2 = d1**2, d2**2
    velocity = vn * np.outer([-m2, m1], n) / (m1 + m2)
    position = np.array([[0.1, 0.1], [0.1, 0.1] + ((d1 + d2) / 2.0 + gap) * n]) % CELL
    return {"position": position, "diameter": np.array([d1, d2]), "cell": (CELL, CELL), "velocity": velocity}


def reduced(d1: float, d2: float) -> float:
    return d1**2 * d2**2 / (d1**2 + d2**2)


def vn(frame: Any, angle: float = 0.0) -> float:
    n = [math.cos(math.radians(angle)), math.sin(math.radians(angle))]
    return float((frame.velocity[1] - frame.velocity[0]) @ n)


@pytest.mark.parametrize("angle", [0.0, 37.0, 90.0, 200.0])
@pytest.mark.parametrize(("d1", "d2"), [(1.0, 1.0), (1.0, 0.5), (0.6, 0.8)])
@pytest.mark.parametrize("zeta", [0.0, 0.1, 0.5, 0.8])
def test_restitution_is_the_closed_form(discs: Callable[..., Any], zeta: float, d1: float, d2: float, angle: float) -> None:
    omega = math.sqrt(KN / reduced(d1, d2))
    damped = math.sqrt(1.0 - zeta**2)
    step, speed, gap = 2e-4 / omega, 0.02, 1e-6
    steps = int(1.05 * (gap / speed + math.pi / damped / omega) / step)
    sample = discs(**pair(d1, d2, gap, angle, -speed), law={"kn": KN, "zeta": zeta}, step=step).run(steps)
    # half a step of the viscous force 2 zeta omega v is lost or won where the contact begins and ends; the force sees the velocity
    # of half a step before, like a zeta larger by zeta^2 omega dt/2, and -d ln e/d zeta = pi/(1 - zeta^2)^1.5; 1e-6: zeta = 0
    error = 2e-4 * (2.0 * zeta + math.pi / damped**3 * zeta**2 / 2.0) + 1e-6
    assert vn(sample.frame(), angle) / speed == pytest.approx(math.exp(-math.pi * zeta / damped), rel=error)


def test_normal_force_of_g07_eqs_4_and_5(discs: Callable[..., Any]) -> None:
    """Forty pairs at forty gaps, at rest."""
    f0, d0 = 2.0, 1e-3
    gaps = np.concatenate((np.linspace(-5e-4, -1e-6, 20), np.linspace(1e-6, 1.1e-3, 20)))
    d1, d2 = np.linspace(0.5, 1.0, 40), np.linspace(1.0, 0.6, 40)
    left = np.column_stack((0.1 + 4.0 * (np.arange(40) % 5), 2.0 * (np.arange(40) // 5)))
    right = left + np.column_stack(((d1 + d2) / 2.0 + gaps, np.zeros(40)))
    law = {"kn": KN, "f0": f0, "d0": d0}
    table = (
        discs(position=np.vstack((left, right)), diameter=np.concatenate((d1, d2)), cell=(20, 16), law=law).frame().interactions
    )
    bound = gaps < d0
    assert table.i.tolist() == np.flatnonzero(bound).tolist() and (table.j == table.i + 40).all()
    # positions up to 20 are rounded at 4e-15, and K_N times that is 4e-10
    np.testing.assert_allclose(table.gap, gaps[bound], rtol=0.0, atol=1e-14)
    inside = gaps[bound] < 0.0
    expected = np.where(inside, -KN * gaps[bound] - f0, -f0 * (1.0 - gaps[bound] / d0))
    np.testing.assert_allclose(table.normal_force, expected, rtol=0.0, atol=1e-9)


def test_force_is_minus_the_slope_of_the_energy(discs: Callable[..., Any]) -> None:
    gaps = np.linspace(-4e-4, 1.2e-3, 81)
    law = {"kn": KN, "f0": 2.0, "d0": 1e-3}
    energy, force = [], []
    for gap in gaps:
        sample = discs(**pair(1.0, 0.7, gap), law=law)
        energy.append(sample.energy()[:4].sum())
        force.append(float((sample.frame().force[1] - sample.frame().force[0]) @ [1.0, 0.0]) / 2.0)
    # N is piecewise linear with kinks (K_N: 0, tail: 0 and D0) on the grid of gaps, where the trapezoidal rule is exact
    work = np.diff(gaps) * (np.array(force)[1:] + np.array(force)[:-1]) / 2.0
    np.testing.assert_allclose(-np.diff(energy), work, rtol=0.0, atol=1e-13)


def test_slow_separation_meets_the_pull_off_force(discs: Callable[..., Any]) -> None:
    f0, d0, speed, step = 2.0, 1e-3, 0.08, 1e-7  # the speed leaves little more than the work of the tail
    sample = discs(**pair(1.0, 1.0, -f0 / KN, vn=speed), law={"kn": KN, "f0": f0, "d0": d0}, step=step)
    frames = sample.record(4000, 10)
    tension = np.array([-frame.interactions.normal_force.sum() for frame in frames])
    # between two frames the gap moves by speed*10*step, the force by K_N times that
    assert f0 - KN * speed * 10 * step < tension.max() <= f0
    opening = int(np.argmax(tension))
    assert abs(frames[opening].interactions.gap[0]) <= speed * 10 * step


@pytest.mark.parametrize(("factor", "escapes"), [(0.999, False), (1.001, True)])
@pytest.mark.parametrize(("d1", "d2"), [(1.0, 1.0), (1.0, 0.5)])
def test_a_pair_escapes_above_the_escape_speed_alone(
    discs: Callable[..., Any], d1: float, d2: float, factor: float, escapes: bool
) -> None:
    """G07 eq. 7: at h = 0 the relative receding velocity must exceed sqrt(F0 D0/m*)."""
    f0, d0 = 1.0, 1e-3
    speed = factor * math.sqrt(f0 * d0 / reduced(d1, d2))
    sample = discs(**pair(d1, d2, 1e-12, vn=speed), law={"kn": 1e4, "f0": f0, "d0": d0}, step=1e-5).run(40000)
    # the stay near D0 lasts log(1000) e-foldings of sqrt(F0/(D0 m*)) > 44, less than the 0.4 of the run
    assert (len(sample.frame().interactions) == 0) is escapes
    assert (vn(sample.frame()) > 0.0) is escapes or not escapes


@pytest.mark.parametrize(("d1", "d2"), [(1.0, 1.0), (0.5, 0.9)])
def test_equilibrium_overlap_is_f0_over_kn(discs: Callable[..., Any], d1: float, d2: float) -> None:
    omega = math.sqrt(KN / reduced(d1, d2))
    law = {"kn": KN, "f0": 2.0, "d0": 1e-3, "zeta": 0.8}
    sample = discs(**pair(d1, d2, -5e-5), law=law, step=0.01 / omega).run(4000)  # exp(-0.8*40) = 1e-14
    # positions near 10 are rounded at 2e-15 in steps that add up while the pair comes to rest
    assert sample.frame().interactions.gap[0] == pytest.approx(-2.0 / KN, abs=1e-13)


def test_a_disc_keeps_two_thirds_of_its_sliding_velocity(discs: Callable[..., Any]) -> None:
    """Pressed together by F0, T = mu F0 until the slip v_t ends: dv_t/dt = -3 mu F0/m*, of which 1/3 goes to the centres
    (1/m* + R_1^2/I_1 + R_2^2/I_2 = 3/m* for discs)."""
    f0, mu, slip, d1, d2 = 1.0, 0.01, 0.02, 1.0, 0.8
    law = {"kn": KN, "kt": KN, "mu": mu, "zeta": 0.8, "f0": f0, "d0": 1e-3}
    scene = pair(d1, d2, -f0 / KN)
    mass = np.array([d1, d2]) ** 2
    scene["velocity"] = slip * np.outer([-mass[1], mass[0]], [0.0, 1.0]) / mass.sum()
    sample = discs(**scene, law=law, step=1e-5)
    duration = slip * reduced(d1, d2) / (3.0 * mu * f0)

    def motion() -> tuple[float, float]:
        frame = sample.frame()
        normal = frame.interactions.normal[0]
        vt = float((frame.velocity[1] - frame.velocity[0]) @ [-normal[1], normal[0]])
        return vt, vt - float(frame.omega @ frame.diameter) / 2.0

    sample.run(int(0.5 * duration / 1e-5))
    vt, left = motion()
    # the overlap changes by h0/r = 1e-5 and by the centrifugal m* v^2/(r F0) = 2e-4
    assert left == pytest.approx(0.5 * slip, rel=2e-3)
    assert vt == pytest.approx(slip * (1.0 - 0.5 / 3.0), rel=2e-3)
    sample.run(int(duration / 1e-5))
    vt, left = motion()
    swing = mu * f0 * math.sqrt(3.0 / (KN * reduced(d1, d2)))  # of v_t, by the tangential spring, for ever
    assert abs(left) < 1.01 * swing
    assert vt - left / 3.0 == pytest.approx(2.0 / 3.0 * slip, rel=2e-3)
    assert vt == pytest.approx(2.0 / 3.0 * slip, abs=swing)


def test_rolling_decays_linearly(discs: Callable[..., Any]) -> None:
    """Without friction the rolling moment mu_r F0 slows the relative rotation; the spins' angular momentum stays."""
    f0, mur, kr, d1, d2, step = 1.0, 1e-2, 100.0, 1.0, 0.8, 2e-5
    scene = pair(d1, d2, -f0 / KN)
    omega = np.array([0.5, -0.3])
    inertia = np.array([d1, d2]) ** 4 / 8.0
    law = {"kn": KN, "f0": f0, "d0": 1e-3, "zeta": 0.8, "kr": kr, "mur": mur}
    sample = discs(**scene, omega=omega, law=law, step=step)
    torque = mur * f0
    duration = (omega[0] - omega[1]) / (torque * np.sum(1.0 / inertia))
    sample.run(int(0.5 * duration / step))
    # the slider yields after mu_r F0/K_r = 1e-4 of relative rotation, which takes 1e-4 time units of 2.2
    np.testing.assert_allclose(sample.frame().omega, omega + torque * 0.5 * duration * np.array([-1, 1]) / inertia, rtol=1e-3)
    sample.run(int(duration / step))
    frame = sample.frame()
    # 2e5 equal increments, each rounded the same way at 1e-16
    assert inertia @ frame.omega == pytest.approx(inertia @ omega, rel=1e-10)
    swing = torque / kr * math.sqrt(kr * np.sum(1.0 / inertia))
    assert abs(frame.omega[0] - frame.omega[1]) < 1.01 * swing
    # K_N times the rounding of positions pushes the pair a little
    assert np.abs(frame.velocity).max() < 1e-12


def test_second_order_whenever_in_a_step_the_contact_opens(discs: Callable[..., Any]) -> None:
    """The worst of 200 damped head-on impacts that meet the steps at phases spread over one: e = exp(-pi z/sqrt(1 - z^2)).

    A damper that is missed, or counted twice, for half a step changes e by zeta omega dt: first order, and for a share of the
    phases of that order too, so that single impacts hardly show it."""
    zeta, kn, speed, count = 0.3, 1e3, 0.5, 200
    omega = np.sqrt(2.0 * kn)  # m* = 1/2
    exact = np.exp(-np.pi * zeta / np.sqrt(1.0 - zeta**2))

    def worst(steps_per_period: int) -> float:
        step = 2.0 * np.pi / omega / steps_per_period
        gap = 0.01 + speed * step * np.arange(count) / count
        left = np.column_stack((np.full(count, 2.0), 3.0 * np.arange(count) + 1.0))
        position = np.vstack((left, left + np.column_stack((1.0 + gap, np.zeros(count)))))
        velocity = np.repeat([[0.5 * speed, 0.0], [-0.5 * speed, 0.0]], count, axis=0)
        sample = discs(position=position, velocity=velocity, diameter=np.ones(2 * count), law={"kn": kn, "zeta": zeta},
                       cell=(6.0, 3.0 * count), step=step)  # fmt: skip
        away = sample.run(round((gap.max() / speed + 4.5 / omega) / step)).frame().velocity[:, 0]
        return float(np.abs((away[count:] - away[:count]) / speed / exact - 1.0).max())

    coarse, fine = worst(28), worst(112)
    assert coarse < (2.0 * np.pi / 28) ** 2  # (omega dt)^2
    assert np.log(coarse / fine) / np.log(4.0) > 1.8

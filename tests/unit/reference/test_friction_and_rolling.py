"""Tangential and rolling springs: closed forms at constant normal force, and a crude explicit twin."""

import math

import numpy as np
import pytest

from workflow.reference.cohesive import CohesiveLaw
from workflow.reference.discs import Discs
from workflow.reference.integrate import integrate


def stuck_pair(law: CohesiveLaw, speed: float = 0.0, spins: tuple[float, float] = (0.0, 0.0), first: float = 1.0) -> Discs:
    """Unit discs at the equilibrium overlap, disc 1 moving along t with ``speed``; mass ``first`` of disc 0."""
    position = np.array([[0.0, 0.0], [1.0 - law.f0 / law.kn, 0.0]])
    velocity = np.array([[0.0, 0.0], [0.0, speed]])
    return Discs(position, velocity, np.array(spins), np.ones(2), np.array([first, 1.0]))


def oblique(vt: float) -> Discs:
    """Unit discs about to meet along x while disc 1 moves along y with ``vt``."""
    velocity = np.array([[0.1, 0.0], [-0.1, vt]])
    return Discs(np.array([[0.0, 0.0], [1.001, 0.0]]), velocity, np.array([1.0, 3.0]), np.ones(2))


def test_slip_cessation_of_a_disc_on_a_fixed_disc() -> None:
    """Stick, slip and cessation under N_e = F0: v = 2/3 v0 and w = (2/3) v0/R when slip ends, whatever mu."""
    law, v0 = CohesiveLaw(kn=1e5, kt=1e5, mu=0.15, f0=1.0, d0=1e-3), 2e-3
    discs = stuck_pair(law, speed=v0, first=math.inf)
    omega = math.sqrt(3.0 * law.kt)  # 1/m + R^2/I = 3/m
    onset = math.asin(law.mu * law.f0 / law.kt * omega / v0) / omega
    cessation = onset + v0 * math.cos(omega * onset) / (3.0 * law.mu * law.f0)
    first = integrate(law, discs, 1.1 * cessation)
    # centrifugal acceleration v0^2/R = 4e-6 F0 changes N_e (and, swinging, v_n) by that order, relative to F0
    assert [event.kind for event in first.events[:2]] == ["slip", "stick"]
    assert first.events[0].time == pytest.approx(onset, rel=2e-5)
    assert first.events[1].time == pytest.approx(cessation, rel=2e-5)
    end = integrate(law, discs, first.events[1].time)
    assert end.velocity[-1, 1, 1] == pytest.approx(2.0 / 3.0 * v0, rel=2e-5)
    assert end.omega[-1, 1] == pytest.approx(2.0 / 3.0 * v0 / 0.5, rel=2e-5)
    assert end.tangential[-1, 0] == pytest.approx(-law.mu * law.f0, rel=2e-5)


def test_gross_sliding_impulse_is_mu_times_the_elastic_one() -> None:
    """zeta = 0, no cohesion: the impulse of N_e is 2 m* v_n, so v_t drops by 2 mu v_n and R w grows by twice that."""
    vn, vt, mu = 0.01, 0.1, 0.3
    law = CohesiveLaw(kn=1e9, kt=1e9, mu=mu)
    position = np.array([[0.0, 0.0], [1.0 + 1e-6, 0.0]])
    discs = Discs(position, np.array([[0.0, 0.0], [-vn, vt]]), np.zeros(2), np.ones(2), np.array([math.inf, 1.0]))
    run = integrate(law, discs, 3e-4)
    # the normal turns by vt pi sqrt(m/K_N)/R = 2e-5 during the contact: 2e-6 when multiplied by vt
    assert run.velocity[-1, 1] == pytest.approx([vn, vt - 2.0 * mu * vn], abs=4e-6)
    assert 0.5 * run.omega[-1, 1] == pytest.approx(4.0 * mu * vn, abs=4e-6)
    assert [event.kind for event in run.events] == ["close", "open"]  # slipping from the first touch


def test_rolling_decays_linearly_and_locks() -> None:
    """Opposite spins roll without sliding: moment mu_r F0, exactly constant since nothing else moves."""
    law = CohesiveLaw(kn=1e3, kt=1e3, mu=0.5, f0=1.0, d0=1e-3, kr=10.0, mur=5e-3)
    omega, inertia = 0.05, 1.0 / 16.0  # two discs of I = 1/8
    omega = math.sqrt(law.kr / inertia)
    onset = math.asin(law.mur * law.f0 * omega / (law.kr * 2.0 * omega)) / omega
    at_onset = 2.0 * omega * math.cos(omega * onset)
    lock = onset + at_onset * inertia / (law.mur * law.f0)
    times = np.linspace(0.0, lock + 3.5 * math.pi / omega, 200)
    run = integrate(law, stuck_pair(law, spins=(-omega, omega)), times[-1], t_eval=times)
    # closed form without approximation; the overlap F0/K_N is rounded to 2e-16 of 1e-3
    assert [event.kind for event in run.events[:2]] == ["roll", "lock"]
    assert [event.time for event in run.events[:2]] == pytest.approx([onset, lock], rel=1e-9)
    assert run.energy.rolling_friction[-1] == pytest.approx(0.5 * inertia * at_onset**2, rel=1e-9)
    after = times > lock
    swing = law.mur * law.f0 / law.kr * np.cos(omega * (times[after] - lock))
    np.testing.assert_allclose(run.xi_r[after, 0], swing, rtol=0.0, atol=1e-9 * law.mur / law.kr)
    np.testing.assert_allclose(run.moment, -law.kr * run.xi_r, rtol=1e-14)
    assert np.all(run.omega[:, 0] == pytest.approx(-run.omega[:, 1], abs=1e-13))


@pytest.mark.parametrize("law", [CohesiveLaw(kn=1e4, kt=1e4, mu=0.0), CohesiveLaw(kn=1e4, kt=0.0, mu=0.5)])
def test_without_friction_nothing_turns(law: CohesiveLaw) -> None:
    run = integrate(law, oblique(0.1), 0.1, t_eval=np.linspace(0.0, 0.1, 50))
    assert np.ptp(run.omega, axis=0).max() == 0.0
    assert np.abs(run.tangential).max() == 0.0
    assert [event.kind for event in run.events] == ["close", "open"]


def test_infinite_friction_never_slips_and_forgets_its_spring_at_opening() -> None:
    law = CohesiveLaw(kn=1e4, kt=3e3, zeta=0.1, mu=math.inf, kr=1.0, mur=math.inf)
    discs = oblique(0.3)
    run = integrate(law, discs, 0.1)
    assert [event.kind for event in run.events] == ["close", "open"]
    before = integrate(law, discs, run.times_of("open")[0]).energy
    assert before.opening[-1] == 0.0
    assert run.energy.opening[-1] > 1e-3 * run.energy.kinetic[0]
    # the same trajectory cut at the event: equal up to the tolerance
    assert run.energy.opening[-1] == pytest.approx(before.tangential[-1] + before.rolling[-1], rel=1e-9)
    assert run.xi_t[-1, 0] == 0.0
    # rounding of a sum of energies of order 1e-2 and errors of 1e-12 in each of some 100 steps
    assert np.abs(run.energy.residual).max() < 1e-10 * run.energy.kinetic[0]


def crude_run(law: CohesiveLaw, discs: Discs, t_end: float, steps: int) -> tuple[list[float], list[float]]:
    """Semi-implicit Euler with scalars, "advance du, then clamp" (physics.md); velocities and spins of two discs."""
    dt = t_end / steps
    (x0, y0), (x1, y1) = discs.position.tolist()
    (u0, w0), (u1, w1) = discs.velocity.tolist()
    s0, s1 = discs.omega.tolist()
    (m0, m1), (d0, d1) = discs.mass.tolist(), discs.diameter.tolist()
    eta = law.zeta * math.sqrt(4.0 * law.kn * m0 * m1 / (m0 + m1))
    xi_t = turn = 0.0
    for _ in range(steps):
        r = math.hypot(x1 - x0, y1 - y0)
        nx, ny, gap = (x1 - x0) / r, (y1 - y0) / r, r - 0.5 * (d0 + d1)
        normal = tangential = moment = 0.0
        if gap < 0.0:
            normal = -law.kn * gap - eta * ((u1 - u0) * nx + (w1 - w0) * ny) - law.f0
            xi_t += ((w1 - w0) * nx - (u1 - u0) * ny - 0.5 * (d0 * s0 + d1 * s1)) * dt
            turn += (s1 - s0) * dt
            largest = -law.mu * law.kn * gap / law.kt
            xi_t = max(-largest, min(largest, xi_t))
            largest = -law.mur * law.kn * gap / law.kr
            turn = max(-largest, min(largest, turn))
            tangential, moment = -law.kt * xi_t, -law.kr * turn
        else:
            xi_t = turn = 0.0
            if gap < law.d0:
                normal = -law.f0 * (1.0 - gap / law.d0)
        fx, fy = normal * nx - tangential * ny, normal * ny + tangential * nx
        u0, w0, u1, w1 = u0 - fx / m0 * dt, w0 - fy / m0 * dt, u1 + fx / m1 * dt, w1 + fy / m1 * dt
        s0 += (-0.5 * d0 * tangential - moment) * 8.0 / (m0 * d0**2) * dt
        s1 += (-0.5 * d1 * tangential + moment) * 8.0 / (m1 * d1**2) * dt
        x0, y0, x1, y1 = x0 + u0 * dt, y0 + w0 * dt, x1 + u1 * dt, y1 + w1 * dt
    return [u0, w0, u1, w1], [s0, s1]


def test_agrees_with_a_crude_explicit_integration_to_first_order() -> None:
    law = CohesiveLaw(kn=1e4, kt=9e3, zeta=0.2, mu=0.3, f0=1.0, d0=1e-3, kr=1.0, mur=1e-3)
    position, velocity = np.array([[0.0, 0.0], [0.6, 0.6]]), np.array([[0.1, 0.4], [-0.2, -0.3]])
    discs = Discs(position, velocity, np.array([0.5, -0.6]), np.array([1.0, 0.695]))
    run = integrate(law, discs, 0.04)
    assert {"enter", "close", "open", "leave", "stick", "slip", "roll"} <= {event.kind for event in run.events}
    errors = []
    for steps in (20_000, 80_000):
        velocities, spins = crude_run(law, discs, 0.04, steps)
        errors.append(max(np.abs(run.velocity[-1].ravel() - velocities).max(), np.abs(run.omega[-1] - spins).max()))
    # omega dt = 7e-5 at 80,000 steps, with speeds of 0.5
    assert errors[1] < 1e-4
    # a fourth of the step, a fourth of the error, up to where the steps fall relative to the events
    assert 2.0 < errors[0] / errors[1] < 8.0

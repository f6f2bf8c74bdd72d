"""Central impacts and separations: closed forms of the one-dimensional motion."""

import math

import numpy as np
import pytest

from workflow.reference.cohesive import CohesiveLaw
from workflow.reference.discs import Discs, Trajectory
from workflow.reference.integrate import integrate

# closed forms of smooth pieces joined at located events: what is left is the integration error at rtol 1e-12
EXACT = 1e-9


def pair(gap: float, vn: float, diameters: tuple[float, float] = (1.0, 1.0)) -> Discs:
    """Two discs on the x axis, relative velocity ``vn``, centre of mass at rest."""
    diameter = np.array(diameters)
    mass = diameter**2
    velocity = vn * np.array([-mass[1], mass[0]]) / mass.sum()
    position = np.array([[0.0, 0.0], [diameter.sum() / 2.0 + gap, 0.0]])
    return Discs(position, np.column_stack((velocity, np.zeros(2))), np.zeros(2), diameter)


def reduced_mass(diameters: tuple[float, float]) -> float:
    m1, m2 = diameters[0] ** 2, diameters[1] ** 2
    return m1 * m2 / (m1 + m2)


def receding_speed(run: Trajectory) -> float:
    return float(run.velocity[-1, 1, 0] - run.velocity[-1, 0, 0])


@pytest.mark.parametrize("zeta", [0.0, 0.1, 0.5, 0.8])
@pytest.mark.parametrize("diameters", [(1.0, 1.0), (1.0, 0.5)])
def test_cohesionless_restitution_and_duration(zeta: float, diameters: tuple[float, float]) -> None:
    # the contact ends at h = 0, where the viscous force is still attractive: half a damped period, exactly
    law = CohesiveLaw(kn=1e5, zeta=zeta)
    damped = math.sqrt(1.0 - zeta**2)
    half_period = math.pi / (damped * math.sqrt(law.kn / reduced_mass(diameters)))
    run = integrate(law, pair(1e-4, -0.02, diameters), 5e-3 + 1.01 * half_period)
    assert -receding_speed(run) / -0.02 == pytest.approx(math.exp(-math.pi * zeta / damped), rel=EXACT, abs=0.0)
    (close,), (opening,) = run.times_of("close"), run.times_of("open")
    assert close == pytest.approx(1e-4 / 0.02, rel=EXACT, abs=0.0)
    assert opening - close == pytest.approx(half_period, rel=EXACT, abs=0.0)


@pytest.mark.parametrize("zeta", [1.0, 2.0])
def test_overdamped_cohesionless_contact_never_opens(zeta: float) -> None:
    law = CohesiveLaw(kn=1e4, zeta=zeta)
    omega = math.sqrt(law.kn / 0.5)
    run = integrate(law, pair(0.0, -0.02), 12.0 / omega)
    root = omega * math.sqrt(zeta**2 - 1.0)
    growth = math.sinh(root * run.time[-1]) / root if root else run.time[-1]
    assert [event.kind for event in run.events] == ["close"]
    # absolute: the overlap has decayed from its largest value of about 1e-4, to which the error refers
    assert run.gap[-1, 0] == pytest.approx(-0.02 * math.exp(-zeta * omega * run.time[-1]) * growth, abs=1e-4 * EXACT)


@pytest.mark.parametrize("diameters", [(1.0, 1.0), (0.5, 0.9)])
def test_equilibrium_overlap_is_f0_over_kn(diameters: tuple[float, float]) -> None:
    law = CohesiveLaw(kn=1e5, zeta=0.8, f0=2.0, d0=1e-3)
    omega = math.sqrt(law.kn / reduced_mass(diameters))
    run = integrate(law, pair(-5e-5, 0.0, diameters), 40.0 / omega)  # exp(-0.8*40) = 1e-14
    assert run.gap[-1, 0] == pytest.approx(-law.f0 / law.kn, rel=EXACT, abs=0.0)
    assert abs(run.normal[-1, 0]) < 1e-8 * law.f0  # K_N times the error above


def test_small_oscillation_about_equilibrium() -> None:
    law, diameters = CohesiveLaw(kn=1e5, zeta=0.05, f0=1.0, d0=1e-3), (1.0, 0.6)
    amplitude, omega = 0.5 * law.f0 / law.kn, math.sqrt(law.kn / reduced_mass(diameters))
    damped = math.sqrt(1.0 - law.zeta**2)
    times = np.linspace(0.0, 6.0 * math.pi / omega, 40)
    run = integrate(law, pair(-law.f0 / law.kn + amplitude, 0.0, diameters), times[-1], t_eval=times)
    phase = damped * omega * times
    expected = amplitude * np.exp(-law.zeta * omega * times) * (np.cos(phase) + law.zeta / damped * np.sin(phase))
    # the starting gap is a difference of numbers of order 1: 2e-16 of an amplitude of 5e-6
    np.testing.assert_allclose(run.gap[:, 0] + law.f0 / law.kn, expected, rtol=0.0, atol=amplitude * EXACT)


@pytest.mark.parametrize("diameters", [(1.0, 1.0), (1.0, 0.5)])
@pytest.mark.parametrize("start", ["opening", "equilibrium"])
def test_a_pair_escapes_above_the_threshold_alone(start: str, diameters: tuple[float, float]) -> None:
    """m* v^2/2 must exceed the work of the tail F0 D0/2 (v at h = 0), plus F0^2/(2 K_N) from the equilibrium overlap.

    For unit masses and v at h = 0 this is G07 eq. 7: the *relative* receding velocity when the contact opens is
    sqrt(2) V*, V* = sqrt(F0 D0).
    """
    law = CohesiveLaw(kn=1e3, f0=1.0, d0=1e-3)
    work = 0.5 * law.f0 * law.d0 + (0.5 * law.f0**2 / law.kn if start == "equilibrium" else 0.0)
    threshold = math.sqrt(2.0 * work / reduced_mass(diameters))
    if start == "opening" and diameters == (1.0, 1.0):
        assert threshold == pytest.approx(math.sqrt(2.0 * law.f0 * law.d0), rel=1e-15)
    gap = 0.0 if start == "opening" else -law.f0 / law.kn
    # both sides of the threshold within 1e-8; the stay at D0 lasts log(1e8) e-foldings of sqrt(F0/(D0 m*)) > 44
    kinds = []
    for factor in (1.0 - 1e-8, 1.0 + 1e-8):
        events = integrate(law, pair(gap, factor * threshold, diameters), 1.0).events
        kinds.append(next(event.kind for event in events if event.kind in ("leave", "close")))
    assert kinds == ["close", "leave"]


def test_escape_threshold_by_bisection_with_a_fixed_disc() -> None:
    law = CohesiveLaw(kn=1e3, f0=1.0, d0=1e-3)
    low, high = 0.0, 0.1
    for _ in range(14):
        middle = 0.5 * (low + high)
        at_touch = pair(0.0, 0.0)
        velocity = np.array([[0.0, 0.0], [middle, 0.0]])
        discs = Discs(at_touch.position, velocity, np.zeros(2), at_touch.diameter, np.array([math.inf, 1.0]))
        escaped = integrate(law, discs, 1.0, rtol=1e-8).times_of("leave")
        low, high = (low, middle) if escaped else (middle, high)
    assert low == pytest.approx(math.sqrt(law.f0 * law.d0), abs=7e-6)  # 0.1/2^14


def test_pull_off_work_is_what_the_pair_loses() -> None:
    law, speed = CohesiveLaw(kn=1e3, f0=1.0, d0=1e-3), 0.2
    run = integrate(law, pair(-law.f0 / law.kn, speed), 0.05)
    work = 0.5 * law.f0**2 / law.kn + 0.5 * law.f0 * law.d0
    assert run.events[-1].kind == "leave"
    assert 0.5 * 0.5 * (speed**2 - receding_speed(run) ** 2) == pytest.approx(work, rel=EXACT, abs=0.0)
    assert run.energy.adhesive[-1] == 0.0
    assert run.energy.stored[0] == pytest.approx(0.5 * 0.5 * speed**2 - work, rel=EXACT, abs=0.0)


def test_tail_of_zero_range_is_contact_adhesion() -> None:
    law = CohesiveLaw(kn=1e4, f0=1.0, d0=0.0)
    run = integrate(law, pair(1e-4, -0.02), 0.1)
    assert [event.kind for event in run.events] == ["close", "open"]
    assert receding_speed(run) == pytest.approx(0.02, rel=EXACT, abs=0.0)


@pytest.mark.parametrize(("closest", "kinds"), [(0.97e-3, ["enter", "leave"]), (1.001e-3, [])])
def test_fast_tangential_pass_through_the_tail(closest: float, kinds: list[str]) -> None:
    # the chord through the tail is 0.015 long, steps are searched every 0.06 diameters
    position = np.array([[0.0, 0.0], [-0.9, 1.0 + closest]])
    discs = Discs(position, np.array([[0.0, 0.0], [100.0, 0.0]]), np.zeros(2), np.ones(2))
    run = integrate(CohesiveLaw(kn=1e5, f0=1.0, d0=1e-3), discs, 0.02)
    assert [event.kind for event in run.events] == kinds

"""Periodic images and the affine motion of the cell."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from workflow.reference.cohesive import CohesiveLaw
from workflow.reference.discs import Cell, Discs
from workflow.reference.integrate import integrate

TIGHT = {"rtol": 1e-11, "atol": 1e-15}
FULL = CohesiveLaw(kn=1e4, kt=8e3, zeta=0.2, mu=0.3, f0=1.0, d0=1e-3, kr=1.0, mur=1e-3)


def affine_pair(branch: tuple[float, float], mass: float = 1.0, diameter: float = 1.0) -> Discs:
    """Two discs without velocity of their own; ``branch`` from one to the other."""
    position = np.array([[0.3, -0.2], [0.3 + branch[0], -0.2 + branch[1]]])
    return Discs(position, np.zeros((2, 2)), np.zeros(2), np.full(2, diameter), np.full(2, mass))


@pytest.mark.parametrize("image", [(3.0, 0.0), (-3.0, 4.0), (300.0, -40.0)])
def test_impact_across_the_boundary_is_the_impact_in_open_space(image: tuple[float, float]) -> None:
    position, velocity = np.array([[0.0, 0.0], [0.6, 0.6]]), np.array([[0.1, 0.4], [-0.2, -0.3]])
    omega, diameter, cell = np.array([0.5, -0.6]), np.array([1.0, 0.695]), Cell(np.array([3.0, 4.0]))
    near = integrate(FULL, Discs(position, velocity, omega, diameter), 0.04)
    far = integrate(FULL, Discs(position + np.array([[0, 0], image]), velocity, omega, diameter), 0.04, cell=cell)
    # a position of 300 is rounded at 3e-14, K_N = 1e4
    np.testing.assert_allclose(far.velocity[-1], near.velocity[-1], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(far.branch[-1], near.branch[-1], rtol=0.0, atol=1e-9)
    assert [event.kind for event in far.events] == [event.kind for event in near.events]


def test_a_disc_meets_the_images_of_the_other_again_and_again() -> None:
    # elastic head-on chase around a cell of length 4: the free path is 4 - 2 = 2 between contacts, on either side
    law, cell = CohesiveLaw(kn=1e6), Cell(np.array([4.0, 4.0]))
    discs = Discs(np.array([[0.0, 0.0], [2.0, 0.0]]), np.array([[0.0, 0.0], [1.0, 0.0]]), np.zeros(2), np.ones(2))
    run = integrate(law, discs, 10.0, cell=cell)
    duration = math.pi / math.sqrt(law.kn / 0.5)
    expected = [1.0 + k * (2.0 + duration) for k in range(5)]
    assert run.times_of("close") == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("branch", [1.25, 1.25 - 5.0, 1.25 + 10.0])
def test_free_discs_and_their_images_follow_the_cell_until_they_touch(branch: float) -> None:
    cell = Cell(np.array([5.0, 6.0]), (0.1, 0.0))
    run = integrate(CohesiveLaw(kn=1e5), affine_pair((branch, 0.0)), 2.0001, cell=cell)
    assert run.times_of("close") == pytest.approx([2.0], rel=1e-12)  # 1.25 (1 - 0.1 t) = 1


def test_head_on_contact_in_a_shrinking_cell() -> None:
    """dr/dt = u + G r, m* du/dt = N(r - 1, u + G r): the damping sees the affine part, the inertia does not."""
    law, rate, t_end = CohesiveLaw(kn=1e4, zeta=0.4, f0=1.0, d0=1e-3), 0.01, 0.02
    eta, overlap = law.zeta * math.sqrt(4.0 * law.kn * 0.5), law.f0 / law.kn

    def twin(t: float, y: np.ndarray, affine: float) -> list[float]:
        gradient = -rate / (1.0 - rate * t)
        vn = y[1] + gradient * (1.0 + y[0])
        return [vn, (-law.kn * y[0] - eta * (y[1] + affine * (vn - y[1])) - law.f0) / 0.5]

    def last_gap(affine: float) -> float:
        return float(solve_ivp(twin, (0.0, t_end), [-overlap, 0.0], "LSODA", None, args=(affine,), **TIGHT).y[0, -1])

    run = integrate(law, affine_pair((1.0 - overlap, 0.0)), t_end, cell=Cell(np.array([5.0, 6.0]), (rate, 0.0)))
    assert run.events == ()
    assert run.gap[-1, 0] == pytest.approx(last_gap(1.0), rel=1e-7, abs=0.0)  # the twin's own error
    assert abs(last_gap(0.0) - last_gap(1.0)) > 0.1 * overlap  # what leaving the affine part out of the damping does


def test_tangential_spring_and_sliding_work_of_discs_that_follow_the_cell() -> None:
    """Discs of infinite mass move exactly with the cell: du and the sliding loss are integrals over a known path."""
    cell, start = Cell(np.array([5.0, 6.0]), (0.3, -0.2)), (0.7, 0.7)
    discs = affine_pair(start, mass=math.inf)

    def path(t: float) -> tuple[float, float, float]:
        """Gap, its rate and v_t = r d(angle)/dt."""
        x, y, u, v = start[0] * (1 - 0.3 * t), start[1] * (1 + 0.2 * t), -0.3 * start[0], 0.2 * start[1]
        r = math.hypot(x, y)
        return r - 1.0, (x * u + y * v) / r, (x * v - y * u) / r

    # never slips
    t_end = 0.05
    stuck = integrate(CohesiveLaw(kn=1e3, kt=1e3, mu=math.inf), discs, t_end, cell=cell)
    displacement = quad(lambda t: path(t)[2], 0.0, t_end, epsabs=1e-13)[0]
    assert stuck.xi_t[-1, 0] == pytest.approx(displacement, rel=1e-9)
    assert stuck.gap[-1, 0] == pytest.approx(path(t_end)[0], rel=1e-10)
    # no kinetic energy: the cell pays for both springs
    assert stuck.energy.cell_work[-1] == pytest.approx(np.ptp(stuck.energy.stored), rel=1e-9)
    # slips: du is at the limit, the loss is mu N_e times the rate that du does not follow
    mu = 0.3
    slid = integrate(CohesiveLaw(kn=1e3, kt=1e3, mu=mu), discs, t_end, cell=cell)
    (onset,) = slid.times_of("slip")
    loss = quad(lambda t: -mu * 1e3 * path(t)[0] * (path(t)[2] + mu * path(t)[1]), onset, t_end, epsabs=1e-13)[0]
    assert slid.energy.sliding[-1] == pytest.approx(loss, rel=1e-8)
    assert slid.tangential[-1, 0] == pytest.approx(mu * 1e3 * path(t_end)[0], rel=1e-10)
    assert np.abs(slid.energy.residual[-1]) < 1e-10 * slid.energy.cell_work[-1]


def test_energy_account_with_the_work_of_the_cell() -> None:
    position = np.array([[0.05, 0.05], [0.95, 0.1], [1.6, 0.7], [0.5, 0.9]])
    discs = Discs(position, np.zeros((4, 2)), np.zeros(4), np.array([0.9, 0.8, 0.75, 0.85]))
    run = integrate(FULL, discs, 0.5, cell=Cell(np.array([2.2, 2.4]), (0.3, 0.1)), t_eval=np.linspace(0.0, 0.5, 40))
    assert run.energy.cell_work[-1] > 0.0 and run.energy.sliding[-1] > 0.0
    # rtol 1e-12 over some thousand steps
    assert np.abs(run.energy.residual).max() < 1e-9 * np.abs(run.energy.cell_work).max()

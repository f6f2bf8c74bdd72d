from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from workflow.data.contact_law import ContactLaw
from workflow.data.frame import Frame, Interactions
from workflow.measures.energy import adhesion, energies

LAW = ContactLaw(kn=1e4, kt=2e3, kr=0.5, f0=1.0, d0=1e-3)


def attraction(h, f0, d0):
    """The force itself (G07 eqs. 4, 5), repulsion positive."""
    return -f0 if h < 0 else -f0 * max(1 - h / d0, 0)


@pytest.mark.parametrize("h", [-5e-3, -1e-6, 0.0, 4e-4, 1e-3, 2e-3])
def test_adhesion_is_the_work_against_the_attraction(h):
    """U(h) = integral of the force from h to infinity (zero beyond D0)."""
    work = quad(attraction, h, 3e-3, args=(1.5, 1e-3), points=[0, 1e-3], epsabs=1e-14)[0]
    # quad resolves a piecewise linear force to rounding; U is of order 1e-3
    assert adhesion(np.array([h]), ContactLaw(1.0, f0=1.5, d0=1e-3))[0] == pytest.approx(work, abs=1e-13)


def test_without_cohesion_or_range_nothing_is_divided_by_zero():
    assert adhesion(np.array([-1e-3, 0.0, 1.0]), ContactLaw(1.0)).tolist() == [0, 0, 0]
    assert adhesion(np.array([-1e-3, 0.0, 1.0]), ContactLaw(1.0, f0=2.0)).tolist() == [-2e-3, 0, 0]


@pytest.fixture
def frame():
    rng = np.random.default_rng(4)
    n, m = 30, 50
    d, gap = rng.uniform(0.5, 1, n), rng.uniform(-1e-3, 1.5e-3, m)
    columns = rng.normal(size=(4, m)) * 1e-2
    table = Interactions(rng.integers(0, n, m), rng.integers(0, n, m), rng.normal(size=(m, 2)), gap,
                     np.maximum(-1e4 * gap, 0), columns[0], columns[1], columns[2], columns[3], columns[2], columns[3],
                     *np.zeros((2, m), bool))  # fmt: skip
    return Frame(0, 0.0, "", np.zeros(2), np.ones(2), np.arange(n), d, d**2, rng.random((n, 2)),
                 rng.normal(size=(n, 2)), rng.normal(size=n), np.zeros((n, 2)), np.zeros(n), table)  # fmt: skip


def test_a_uniform_disc_spins_with_half_its_mass_at_the_rim(frame):
    """Rim speed v = w R gives a uniform disc m v^2/4, half of what the same speed gives in translation."""
    rim = frame.velocity[:, 0]
    spinning = replace(frame, omega=2 * rim / frame.diameter, velocity=np.column_stack((rim, 0 * rim)))
    result = energies(spinning, LAW)
    assert result.rotation == pytest.approx(result.translation / 2, rel=1e-12)


def test_each_spring_stores_the_work_done_on_it(frame):
    result, c = energies(frame, LAW), frame.interactions
    for value, k, x in ((result.normal, LAW.kn, np.maximum(-c.gap, 0)), (result.tangential, LAW.kt, c.xi_t),
                        (result.rolling, LAW.kr, c.xi_r)):  # fmt: skip
        # midpoint rule: exact for a linear force
        steps = (np.arange(100) + 0.5) / 100
        assert value == pytest.approx((k * np.abs(x)[:, None] * steps * np.abs(x)[:, None] / 100).sum(), rel=1e-12)
    parts = result.as_dict()
    assert parts["total"] == pytest.approx(sum(parts[p] for p in ("kinetic", "elastic", "adhesion")))

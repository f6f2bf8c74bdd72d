"""Fitted orders, recommended steps and the cases of few bodies."""

from __future__ import annotations

import numpy as np
import pytest

from workflow.reference.integrate import integrate
from workflow.reference.law import CohesiveLaw
from workflow.study.accuracy import Few, orders, recommend
from workflow.study.groups import CONTACT, TAIL, cases, pair, pull_off_work, relative, restitution


def rows(error: float, order: float, steps: tuple[float, ...] = (14, 28, 56, 112)) -> list[Few]:
    """An error that falls as step^order from ``error`` at the coarsest step."""
    return [Few("case", "law", n, 1.0 / n, error * (steps[0] / n) ** order, None, 1.0, 2) for n in steps]


@pytest.mark.parametrize("order", [1.0, 2.0])
def test_order_and_step_of_a_power_law(order: float) -> None:
    """error = 1e-2 (14/n)^p reaches 1e-3 at n = 14 10^(1/p)."""
    table = rows(1e-2, order)
    assert orders(table)[("case", "law")] == pytest.approx(order, rel=1e-9)
    (answer,) = recommend(table, 1e-3)
    expected = 14.0 * 10.0 ** (1.0 / order)
    if expected < 112:
        assert answer["steps_per_period"] == pytest.approx(expected, rel=1e-9)
        assert answer["step"] == pytest.approx(1.0 / expected, rel=1e-9)
    else:
        assert answer["steps_per_period"] is None
        assert answer["least_error"] == pytest.approx(1e-2 / 8.0, rel=1e-9)


def test_a_step_that_fails_by_chance_counts() -> None:
    """A coarse step that happens to be exact recommends nothing while finer ones fail."""
    table = rows(1e-2, 1.0)
    table[0] = Few("case", "law", 14, 1.0 / 14, 1e-9, None, 1.0, 2)
    (answer,) = recommend(table, 2e-3)
    assert answer["steps_per_period"] == pytest.approx(70.0, rel=1e-9)  # 1e-2 (14/70) = 2e-3
    assert recommend(rows(1e-4, 1.0), 1e-3)[0]["steps_per_period"] == 14


def test_restitution_of_the_reference_is_the_closed_form() -> None:
    """Undamped to overdamped: the damped spring leaves at h = 0 after half a period, e = exp(-pi z/sqrt(1 - z^2))."""
    zeta, group = 0.3, pair(0.5, 1e-3)
    end = integrate(CohesiveLaw(**CONTACT, zeta=zeta), group, 0.06).discs()
    expected = np.exp(-np.pi * zeta / np.sqrt(1.0 - zeta**2))
    assert restitution([group], [end])[0, 0] == pytest.approx(expected, rel=1e-9)  # type: ignore[list-item]


def test_pull_off_work_is_the_closed_form() -> None:
    """F0 D0/2 of the tail and F0^2/(2 K_N) of the contact (undamped, from equilibrium)."""
    case = next(case for case in cases(2) if case.name == "pull-off work")
    work = pull_off_work(case.groups, case.reference())
    expected = 0.5 * TAIL["f0"] * TAIL["d0"] + 0.5 * TAIL["f0"] ** 2 / CONTACT["kn"]
    assert relative(work, np.full_like(work, expected)) < 1e-9

"""Fitted orders, recommended steps and the cases of few bodies."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

from workflow.reference.cohesive import CohesiveLaw
from workflow.reference.integrate import integrate
from workflow.verification.accuracy import FewBodyError, PackingStatistics, Plan, few_bodies, many_bodies, orders, recommend
from workflow.verification.few_discs import CONTACT, TAIL, cases, pair, pull_off_work, relative, restitution
from workflow.verification.one_run import VARIANTS
from workflow.verification.pages import write_accuracy


def rows(error: float, order: float, steps: tuple[float, ...] = (14, 28, 56, 112)) -> list[FewBodyError]:
    """An error that falls as step^order from ``error`` at the coarsest step."""
    return [FewBodyError("case", "law", n, 1.0 / n, error * (steps[0] / n) ** order, None, 1.0, 2) for n in steps]


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
    table[0] = FewBodyError("case", "law", 14, 1.0 / 14, 1e-9, None, 1.0, 2)
    (answer,) = recommend(table, 2e-3)
    assert answer["steps_per_period"] == pytest.approx(70.0, rel=1e-9)  # 1e-2 (14/70) = 2e-3
    assert recommend(rows(1e-4, 1.0), 1e-3)[0]["steps_per_period"] == 14


def test_restitution_of_the_reference_is_the_closed_form() -> None:
    """Undamped to overdamped: the damped spring leaves at h = 0 after half a period, e = exp(-pi z/sqrt(1 - z^2))."""
    zeta, group = 0.3, pair(0.5, 1e-3)
    end = integrate(CohesiveLaw(**CONTACT, zeta=zeta), group, 0.06).discs()
    expected = np.exp(-np.pi * zeta / np.sqrt(1.0 - zeta**2))
    assert restitution([group], [end])[0, 0] == pytest.approx(expected, rel=1e-9)  # type: ignore[list-item]


def test_pull_off_work_is_the_closed_form(monkeypatch: pytest.MonkeyPatch) -> None:
    """F0 D0/2 of the tail and F0^2/(2 K_N) of the contact (undamped, from equilibrium)."""
    monkeypatch.setattr("workflow.verification.few_discs.capture_reference", lambda law: 1.0)  # of another case, seconds
    case = next(case for case in cases(1) if case.name == "pull-off work")
    work = pull_off_work(case.groups, case.reference())
    expected = 0.5 * TAIL["f0"] * TAIL["d0"] + 0.5 * TAIL["f0"] ** 2 / CONTACT["kn"]
    assert relative(work, np.full_like(work, expected)) < 1e-9


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> list[FewBodyError]:
    """One case of the study, two steps, every law that can do it."""
    monkeypatch.setattr("workflow.verification.accuracy.cases", lambda count: cases(count)[1:2])
    plan = Plan(groups=2, few=(28, 112), many=(), seeds=1, grains=0, duration=0.0)
    return few_bodies(plan, VARIANTS, io.StringIO())


@pytest.mark.engine
def test_few_bodies_approach_the_reference(few: list[FewBodyError]) -> None:
    """With friction alone every law converges; four times finer steps leave less than half of the error."""
    errors = {(row.variant, row.steps_per_period): row.error for row in few}
    assert set(errors) == {(variant.name, n) for variant in VARIANTS for n in (28, 112)}
    for variant in VARIANTS:
        if variant.law == "disc":
            assert errors[variant.name, 112] < 0.5 * errors[variant.name, 28] < 0.05
    for row in few:
        assert row.seconds > 0.0, row
        assert (row.residual is not None) == row.variant.startswith("exact"), row


@pytest.mark.engine
def test_packings_are_measured() -> None:
    """An exact and a stock packing of 30 grains after 2.5 T0 under P = 1: both are compressed well beyond the start at 0.36."""
    plan = Plan(groups=0, few=(), many=(14,), seeds=1, grains=30, duration=2.5)
    chosen = [variant for variant in VARIANTS if variant.name in ("exact", "stock")]
    found = many_bodies(plan, chosen, io.StringIO())
    assert len(found) == 4
    for row in found:
        assert (row.residual is None) == (row.variant == "stock")
        if row.case == "packing":
            assert 0.6 < row.solid_fraction < 0.95
            assert 0.5 < row.coordination < 5.0


def test_tables_and_figures_are_written(tmp_path: Path) -> None:
    """Tables, figures and a page that needs no other file."""
    table = rows(1e-2, 1.0)
    many = [PackingStatistics("packing", "law", 28, 1e-4, 2, 60, 0.8, 0.01, 2.5, 0.1, 1e-3, 1e-4, 0.02, 1.0)]
    write_accuracy(tmp_path, table, many, 1e-3, "wf accuracy")
    page = (tmp_path / "accuracy.html").read_text()
    assert page.count("data:image/png;base64,") == 3 and "http" not in page.split("<body>")[1]
    assert (tmp_path / "accuracy.csv").read_text().count("\n") == 1 + len(table)

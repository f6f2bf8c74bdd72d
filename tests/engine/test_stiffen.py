"""Fix disc/stiffen: contacts become stiffer without a jump of forces, its work closes the energy account, it resumes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from workflow.data.frame import Frame

LAW = {"kn": 1e2, "kt": 80.0, "zeta": 0.8, "mu": 0.5, "f0": 1.0, "d0": 1e-2, "kr": 1.0, "mur": 0.02}
RAMP = "fix ramp all disc/stiffen 10 100 20\n"


@pytest.fixture
def lump(gas: Callable[..., Any]) -> dict[str, Any]:
    """A gas that is dense enough to become a few hyperstatic lumps with friction and rolling soon."""
    return {**gas(60, 0.5, seed=8, speed=0.5), "law": LAW, "step": 5e-4, "skin": 0.1}


def test_forces_stay_and_overlaps_shrink(discs: Callable[..., Any], lump: dict[str, Any]) -> None:
    sample = discs(**lump, move="drag 0.3", first="run 60000")
    before = sample.frame().interactions
    sample.command(RAMP + "run 1")  # one update, factor 100^(5e-4/20) = 1 + 1.2e-4
    step = sample.frame().interactions
    held = np.abs(before.tangential) > 1e-3
    assert held.sum() > 20 and np.array_equal(before.i, step.i)
    # what is left of the vibrations moves forces by less than 1e-3 F0 in a step; K_T times the old du would be 1.2e-4 T off
    np.testing.assert_allclose(step.tangential, before.tangential, atol=1e-3)
    np.testing.assert_allclose(step.moment, before.moment, atol=1e-4)
    sample.run(60000)
    assert sample.vector("ramp", 2)[0] == 100.0 == sample.value("f_ramp") * 100.0
    after = sample.frame().interactions
    # the elastic part of a force is K_N times the overlap: forces near F0 mean overlaps near F0/K_N, then and now
    assert after.elastic.mean() == pytest.approx(1.0, rel=0.1)
    assert -after.gap[after.in_contact].mean() == pytest.approx(1.0 / 1e4, rel=0.1)
    assert -before.gap[before.in_contact].mean() == pytest.approx(1.0 / 1e2, rel=0.1)


def test_work_closes_the_energy_account(discs: Callable[..., Any], lump: dict[str, Any]) -> None:
    """Kinetic and potential energy plus what was lost change by the work of the stiffness and nothing else."""

    def total(sample: Any) -> float:
        return float(sample.energy().sum() + kinetic(sample))

    def kinetic(sample: Any) -> float:
        frame = sample.frame()
        return float(
            (frame.mass * (frame.velocity**2).sum(axis=1) / 2 + frame.mass * frame.diameter**2 * frame.omega**2 / 16).sum()
        )

    sample = discs(**lump, first="run 40000")
    before = total(sample)
    sample.command(RAMP + "run 45000")
    work = sample.vector("ramp", 2)[1]
    assert abs(work) > 0.05  # 60 grains, some F0^2/(2 K_N) = 5e-3 per contact
    # the half-step velocity of the damping is first order in the step: some percent of what is dissipated
    assert total(sample) - before == pytest.approx(work, abs=0.1 * abs(work))


def test_a_ramp_resumed_in_the_middle_goes_on(discs: Callable[..., Any], lump: dict[str, Any], tmp_path: Path) -> None:
    sample = discs(**lump, first="run 20000").command(RAMP + f"run 20005\nwrite_restart {tmp_path / 'c'}")
    factor, work = sample.vector("ramp", 2)
    assert 3.0 < factor < 100.0 / 3.0
    text = type(sample).text(lump, tmp_path / "again.data")
    start, rest = text.index("read_data"), text.index("pair_style")
    again = type(sample)(text[:start] + f"read_restart {tmp_path / 'c'}\n" + text[rest:] + RAMP + "run 0", tmp_path)
    assert again.vector("ramp", 2).tolist() == [factor, work]
    one, two = sample.run(0).frame().interactions, again.frame().interactions
    np.testing.assert_allclose(two.elastic, one.elastic, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(two.tangential, one.tangential, rtol=0.0, atol=1e-9)
    for engine in (sample, again):
        engine.run(25000)
    assert again.vector("ramp", 2)[0] == 100.0
    again.engine.close()


def test_two_ranks_work_the_same(ranks: Callable[..., Frame], lump: dict[str, Any], tmp_path: Path) -> None:
    works = []
    for number in (1, 2):
        file = tmp_path / f"work{number}"
        ranks(number, f'{RAMP}run 3000\nprint "$(f_ramp[1]:%.17g) $(f_ramp[2]:%.17g)" file {file}', **lump)
        works.append([float(word) for word in file.read_text().split()])
    np.testing.assert_allclose(works[1], works[0], rtol=1e-6)  # rounding, amplified by 3000 steps of collisions


@pytest.mark.parametrize(
    ("words", "message"), [("10 100", "three values"), ("0 100 1", "at least 1"), ("10 -1 1", "must be positive")]
)
def test_misuse_of_stiffen_is_named(discs: Callable[..., Any], lump: dict[str, Any], words: str, message: str) -> None:
    with pytest.raises(Exception, match=message):
        discs(**lump, first=f"fix ramp all disc/stiffen {words}")

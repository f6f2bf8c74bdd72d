"""Fix disc/equilibrium: its figures recomputed from a frame, its verdict, its clocks, and how it stops a run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from workflow.data.frame import Frame

COHESIVE = {"kn": 1e3, "kt": 800.0, "zeta": 0.5, "mu": 0.3, "f0": 0.5, "d0": 2e-2, "kr": 1.0, "mur": 1e-2}
DRY = {"kn": 1e3, "kt": 800.0, "zeta": 0.5, "mu": 0.3}
FORCE = 1e-2  # tolerance on forces, in units of F1 = 2
FIX = "fix eq all disc/equilibrium 50 unit 2 force 0.01 energy 1e-3"


def figures(frame: Frame, cohesive: bool) -> list[float]:
    """Elements 1 to 9, 11 and 12 of the vector, from the definition."""
    table, mass = frame.interactions, frame.mass
    energy = mass * (frame.velocity**2).sum(axis=1) / 2.0 + mass * frame.diameter**2 * frame.omega**2 / 16.0
    carries = np.ones(len(table), bool) if cohesive else table.elastic > FORCE * 2.0
    links = np.bincount(np.concatenate((table.i[carries], table.j[carries])), minlength=frame.grains)
    held = links >= (1 if cohesive else 2)
    watched = held | cohesive  # all grains where the law attracts
    momentum = mass[watched] @ frame.velocity[watched]
    # the elastic and attractive parts depend on the frame alone; N_v is what acted
    stress = ((table.force * table.branch).sum(axis=0) + mass @ frame.velocity**2) / frame.area
    approach = -np.einsum("ka,ka->k", table.normal, frame.velocity[table.j] - frame.velocity[table.i])
    return [
        np.hypot(*frame.force.T).max(), np.abs(frame.torque).max(), *stress,
        (energy[watched].sum() - momentum @ momentum / (2.0 * mass[watched].sum())) / watched.sum(), energy.mean(),
        frame.grains - held.sum(), np.sum(table.in_contact), np.sum(~table.in_contact), -table.gap.min(), approach.max(),
    ]  # fmt: skip


@pytest.mark.parametrize("newton", ["on", "off"])
@pytest.mark.parametrize("law", [COHESIVE, DRY], ids=["cohesive", "dry"])
def test_figures_are_those_of_the_frame(
    discs: Callable[..., Any], gas: Callable[..., Any], law: dict[str, float], newton: str
) -> None:
    """A moving sample half way to its packing, drifting as a whole."""
    scene = gas(60, 0.55, seed=3, speed=0.3)
    scene["velocity"] += [0.4, -0.2]
    move = "stress 2 2 rate 0.1 drag 0.5"
    sample = discs(**scene, law=law, step=1e-3, newton=newton, move=move, first=f"{FIX} stress 2 2\nrun 4000")
    vector = sample.vector("eq", 14)
    expected = figures(sample.frame(), law is COHESIVE)
    # sums of 60 terms rounded at 1e-16, and gaps at 1e-15 of overlaps near 1e-3
    np.testing.assert_allclose(vector[[*range(9), 10, 11]], expected, rtol=1e-9, atol=1e-12)
    assert (
        (law is COHESIVE or expected[6] > 0) and expected[7] > 60 and vector[13] == 0.0 == sample.engine.extract_fix("eq", 0, 0)
    )


def borne(frame: Frame) -> np.ndarray:
    """Stress that contacts and attraction bear, without the kinetic part."""
    return np.asarray((frame.interactions.force * frame.interactions.branch).sum(axis=0) / frame.area)


LAW = {"kn": 1e3, "f0": 1.0, "d0": 1e-3, "zeta": 0.8}
APART = {"position": np.stack(np.meshgrid([1.0, 4.0, 7.0], [1.0, 4.0, 7.0]), -1).reshape(-1, 2), "diameter": np.ones(9)}
PRESSURES = [float(p) for p in 10.0 ** np.arange(-8, 2.5, 0.5)]


def judged(sample: Any, pressure: float) -> tuple[bool, np.ndarray]:
    """Verdict of the fix at one look under a stress, after a step in which nothing moves, with the criterion of the kinetic
    energy wide open; its figures."""
    words = f"unit {max(1.0, pressure):.17g} stress {pressure:.17g} {pressure:.17g} energy 1e30"
    sample.command(f"timestep 1e-12\nfix eq all disc/equilibrium 1 {words}\nrun 1")
    return sample.engine.extract_fix("eq", 0, 0) == 1.0, sample.vector("eq", 20)


def test_an_empty_cell_bears_nothing(discs: Callable[..., Any]) -> None:
    """Discs at rest that touch nothing: every net force is zero, and 1e-4 F0/a may be more than the stress they should bear."""
    sample = discs(**APART, law=LAW)
    for pressure in PRESSURES:
        verdict, figures = judged(sample, pressure)
        assert not verdict
        assert figures[16] >= 100.0 * (1.0 - 1e-12)  # of a tolerance that is P/100 at most


def test_a_gas_under_its_own_pressure_bears_nothing(discs: Callable[..., Any]) -> None:
    """Its kinetic stress is exactly what is imposed, with no net force on any disc."""
    sample = discs(**APART, law=LAW)
    for pressure in PRESSURES:
        speed = np.sqrt(pressure * 100.0 / 9.0)
        sample.command(f"velocity all set {speed:.17g} {speed:.17g} 0")
        verdict, figures = judged(sample, pressure)
        np.testing.assert_allclose(figures[2:4], pressure, rtol=1e-12)
        assert figures[7] == figures[8] == 0.0 and not verdict


@pytest.mark.parametrize("factor", [1.0, 1.005, 1.02, 0.98, 0.0])
def test_only_contacts_that_bear_the_stress_are_in_equilibrium(discs: Callable[..., Any], factor: float) -> None:
    """Sixteen unit discs on a square lattice in whose contacts N = factor P d, so that they bear the stress factor P: every
    net force is zero, whatever it is."""
    row = 0.999 * (np.arange(4) + 0.5)
    sample = discs(position=np.stack(np.meshgrid(row, row), -1).reshape(-1, 2), diameter=np.ones(16), cell=np.full(2, 3.996),
                   law=LAW)  # fmt: skip
    for pressure in PRESSURES:
        length = 4.0 * (1.0 - (1.0 + factor * pressure) / (LAW["kn"] + factor * pressure))
        sample.command(f"change_box all x final 0 {length:.17g} y final 0 {length:.17g} remap units box")
        verdict, figures = judged(sample, pressure)
        stress = borne(sample.frame())
        # K_N times the rounding of places near 4, 1e-15, over the contacts of an axis
        np.testing.assert_allclose(stress, factor * pressure, rtol=1e-9, atol=1e-12)
        tolerance = min(1e-4 * max(1.0, pressure), 0.01 * pressure)
        error = np.abs(stress - pressure).max() / tolerance
        assert figures[16] == pytest.approx(error, rel=1e-6, abs=1e-3)
        assert verdict is (factor == 1.0 or (factor == 1.005 and pressure < 0.015))


def test_two_ranks_measure_the_same(ranks: Callable[..., Frame], gas: Callable[..., Any], tmp_path: Path) -> None:
    scene = {**gas(60, 0.55, seed=3, speed=0.3), "law": DRY, "step": 1e-3, "skin": 0.05, "move": "stress 2 2 rate 0.1"}
    texts = []
    for number, newton in ((1, "on"), (2, "on"), (2, "off")):
        file = tmp_path / "figures"
        values = " ".join(f"$(f_eq[{k}]:%.17g)" for k in range(1, 15))
        ranks(number, f'{FIX}\nrun 2000\nprint "{values}" file {file}', newton=newton, **scene)
        texts.append(np.array(file.read_text().split(), float))
    # rounding amplified by 2000 steps of collisions
    np.testing.assert_allclose(texts[1], texts[0], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(texts[2], texts[0], rtol=1e-6, atol=1e-9)


def test_halt_when_the_criteria_have_held(discs: Callable[..., Any], gas: Callable[..., Any]) -> None:
    """The run ends at the first check at which everything has held for the time asked for; the packing is at rest then."""
    hold, tolerance = 0.5, 1e-4
    first = f"""fix eq all disc/equilibrium 50 unit 1 stress 1 1 hold {hold} force {tolerance} energy 5e-8
variable rest equal f_eq
fix enough all halt 50 v_rest > 0.5 error continue message no
run 200000"""
    sample = discs(**gas(40, 0.5, seed=9, speed=0.0), law=DRY, step=1e-3, move="stress 1 1 drag 0.5", first=first)
    frame, vector = sample.frame(), sample.vector("eq", 14)
    assert frame.step < 200000 and sample.engine.extract_fix("eq", 0, 0) == 1.0
    assert hold <= vector[9] < hold + 0.05 + 1e-9
    assert vector[12] >= vector[9]  # no contact opened or closed while at rest
    assert np.hypot(*frame.force.T).max() < tolerance and np.abs(frame.torque).max() < tolerance
    stress = (frame.interactions.force * frame.interactions.branch).sum(axis=0) / frame.area
    np.testing.assert_allclose(stress, 1.0, rtol=0.0, atol=tolerance)


def test_quiet_time_starts_when_a_contact_opens(discs: Callable[..., Any]) -> None:
    """Two cohesive discs at rest, hit by a third after 0.5 time units: the network changes then and not before."""
    position = np.array([[3.0, 5.0], [3.999, 5.0], [6.0, 5.0]])
    law = {"kn": 1e3, "f0": 1.0, "d0": 1e-2, "zeta": 0.9}
    first = "fix eq all disc/equilibrium 10 unit 1\nrun 0"
    velocity = np.array([[0.0, 0.0], [0.0, 0.0], [-2.0, 0.0]])
    sample = discs(position=position, diameter=np.ones(3), velocity=velocity, law=law, step=1e-3, first=first).run(490)
    assert sample.vector("eq", 14)[12] == pytest.approx(0.49)
    sample.command("variable quiet equal f_eq[13]\nfix stay all halt 10 v_quiet < 0.005 error continue message no\nrun 100")
    # they touch at 0.5, from 1.001 apart at 2 per time
    assert sample.value("step") == 510


@pytest.mark.parametrize("present", [True, False])
def test_stop_file_halts_the_run_at_the_next_check(discs: Callable[..., Any], tmp_path: Path, present: bool) -> None:
    stop = tmp_path / "stop"
    first = f"""fix eq all disc/equilibrium 10 unit 1 stop {stop}
variable asked equal f_eq[14]
fix now all halt 10 v_asked > 0.5 error continue message no
run 0"""
    sample = discs(position=np.array([[3.0, 5.0], [7.0, 5.0]]), diameter=np.ones(2), law=DRY, first=first).run(100)
    if present:
        stop.touch()
    sample.run(100)
    assert sample.value("step") == (110 if present else 200)


def test_one_grain_without_contact_has_finite_figures(discs: Callable[..., Any]) -> None:
    """Nothing is carried by anything: figures are finite, every grain is a rattler."""
    sample = discs(position=np.array([[3.0, 5.0]]), diameter=np.ones(1), velocity=[[1.0, 0.0]], law=DRY,
                   first="fix eq all disc/equilibrium 10 unit 1\nrun 100")  # fmt: skip
    vector = sample.vector("eq", 14)
    assert np.isfinite(vector).all() and vector[6] == 1.0 and vector[4] == vector[5] == 0.5


def test_a_new_stress_starts_the_clocks_again(discs: Callable[..., Any]) -> None:
    """A network that has not changed says nothing about a load that was just put on."""
    first = "fix eq all disc/equilibrium 10 unit 1 stress 0 0 force 1e9 energy 1e9\nrun 0"
    sample = discs(position=np.array([[3.0, 5.0], [3.999, 5.0]]), diameter=np.ones(2), move="stress 0 0",
                   law={"kn": 1e3, "f0": 1.0, "d0": 1e-2, "zeta": 0.9}, step=1e-3, first=first).run(500)  # fmt: skip
    assert sample.vector("eq", 14)[12] == pytest.approx(0.5)
    sample.command("fix_modify eq stress 1 1").run(200)
    vector = sample.vector("eq", 14)
    assert vector[12] == pytest.approx(0.2)
    assert vector[9] <= 0.2

"""Fix disc/equilibrium: its figures recomputed from a frame, its verdict, its clocks, and how it stops a run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from workflow.analysis.frame import Frame

COHESIVE = {"kn": 1e3, "kt": 800.0, "zeta": 0.5, "mu": 0.3, "f0": 0.5, "d0": 2e-2, "kr": 1.0, "mur": 1e-2}
DRY = {"kn": 1e3, "kt": 800.0, "zeta": 0.5, "mu": 0.3}
FORCE = 1e-2  # tolerance on forces, in units of F1 = 2
FIX = "fix eq all disc/equilibrium 50 unit 2 force 0.01 energy 1e-3"


def figures(frame: Frame, cohesive: bool) -> list[float]:
    """Elements 1 to 9, 11 and 12 of the vector, from the definition."""
    table, mass = frame.contacts, frame.mass
    energy = mass * (frame.velocity**2).sum(axis=1) / 2.0 + mass * frame.diameter**2 * frame.spin**2 / 16.0
    carries = np.ones(len(table), bool) if cohesive else table.elastic > FORCE * 2.0
    links = np.bincount(np.concatenate((table.i[carries], table.j[carries])), minlength=frame.grains)
    held = links >= (1 if cohesive else 2)
    momentum = mass[held] @ frame.velocity[held]
    # the elastic and attractive parts depend on the frame alone; N_v is what acted
    stress = ((table.force * table.branch).sum(axis=0) + mass @ frame.velocity**2) / frame.area
    approach = -np.einsum("ka,ka->k", table.normal, frame.velocity[table.j] - frame.velocity[table.i])
    return [
        np.hypot(*frame.force.T).max(), np.abs(frame.torque).max(), *stress,
        (energy[held].sum() - momentum @ momentum / (2.0 * mass[held].sum())) / held.sum(), energy.mean(),
        frame.grains - held.sum(), np.sum(table.touching), np.sum(~table.touching), -table.gap.min(), approach.max(),
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
    stress = (frame.contacts.force * frame.contacts.branch).sum(axis=0) / frame.area
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
def test_stop_file(discs: Callable[..., Any], tmp_path: Path, present: bool) -> None:
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


def test_one_grain_and_no_contact(discs: Callable[..., Any]) -> None:
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

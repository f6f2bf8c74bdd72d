"""The interaction table of the engine against every pair of discs, in Python."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from workflow.data.frame import Frame

KN, F0, D0, STEP = 1e3, 0.5, 2e-2, 5e-4
LAW = {"kn": KN, "kt": KN, "zeta": 0.2, "mu": 0.3, "f0": F0, "d0": D0, "kr": 1.0, "mur": 1e-2}


def twin(frame: Frame, reach: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All pairs (M, 2) with a gap below ``reach``, their gaps and branch vectors, over the periodic images."""
    i, j = np.triu_indices(frame.grains, 1)
    branch = frame.position[j] - frame.position[i]
    branch -= frame.cell * np.round(branch / frame.cell)
    gap = np.hypot(*branch.T) - (frame.diameter[i] + frame.diameter[j]) / 2.0
    near = gap < reach
    return np.column_stack((i, j))[near], gap[near], branch[near]


def compare(frame: Frame, law: dict[str, float]) -> int:
    """Assert that table and twin agree; number of interactions."""
    check_sums(frame)
    pairs, gap, branch = twin(frame, law.get("d0", 0.0))
    table = frame.interactions
    due = ~table.in_contact & (
        table.viscous != 0.0
    )  # contacts that opened in this step, with what their dampers were still due
    i, j, n = table.i[due], table.j[due], table.normal[due]
    vn = np.einsum("kx,kx->k", frame.velocity[j] - frame.velocity[i], n)
    # a step ago they were closed; F0 and dampers change the velocity of a contact that ends by less than a half in a step,
    # and no cell here grows faster than 0.5
    step = frame.time / max(frame.step, 1)
    assert (table.gap[due] < 1.5 * step * (vn + 0.5 * table.distance[due])).all()
    table = table.select(~due | (table.gap < law.get("d0", 0.0)))
    assert np.array_equal(np.column_stack((table.i, table.j)), pairs)
    # positions up to 10 are rounded at 2e-15
    np.testing.assert_allclose(table.gap, gap, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(table.branch, branch, rtol=0.0, atol=1e-13)
    kn, f0, d0 = law["kn"], law.get("f0", 0.0), law.get("d0", 1.0)
    np.testing.assert_allclose(table.elastic, np.where(gap < 0.0, -kn * gap, 0.0), rtol=0.0, atol=kn * 1e-13)
    np.testing.assert_allclose(table.attraction, -f0 * np.clip(1.0 - gap / d0, 0.0, 1.0), rtol=0.0, atol=1e-11)
    assert not np.abs(np.concatenate((table.tangential, table.moment))[np.tile(gap >= 0.0, 2)]).any()
    assert (np.abs(table.tangential) <= law.get("mu", 0.0) * table.elastic * (1.0 + 1e-12)).all()
    return len(pairs)


def check_sums(frame: Frame) -> None:
    """Forces and torques of the grains are the sums over the table."""
    table, force, torque = frame.interactions, np.zeros((frame.grains, 2)), np.zeros(frame.grains)
    np.add.at(force, table.j, table.force)
    np.add.at(force, table.i, -table.force)
    np.add.at(torque, table.j, table.moment - frame.diameter[table.j] / 2.0 * table.tangential)
    np.add.at(torque, table.i, -table.moment - frame.diameter[table.i] / 2.0 * table.tangential)
    # rounding of forces up to some 30 and of gaps (1e-15) times K_N (1e4), summed over up to five contacts
    np.testing.assert_allclose(frame.force, force, rtol=0.0, atol=3e-11)
    np.testing.assert_allclose(frame.torque, torque, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("newton", ["on", "off"])
@pytest.mark.parametrize("skin", [0.021, 0.05, 0.3])
@pytest.mark.parametrize("move", ["", "stress 1e9 1e9 rate 0.5", "stress 1e9 NULL rate 1", "stress -1e9 -1e9 rate 0.5"])
def test_no_pair_is_missed(discs: Callable[..., Any], gas: Callable[..., Any], move: str, skin: float, newton: str) -> None:
    """A dense cohesive gas in a fixed, shrinking or growing cell; the skin barely exceeds D0, or is large."""
    scene = gas(60, 0.45, seed=5, speed=2.0)
    sample = discs(**scene, law=LAW, step=5e-4, skin=skin, move=move, newton=newton)
    counts = [compare(frame, LAW) for frame in sample.record(700, 7)]
    assert sum(counts) > 8 * len(counts) and sample.value("nbuild") > 2


@pytest.mark.parametrize("velocity", [(50.0, 0.0), (0.0, -50.0), (-35.0, 35.0)])
def test_a_fast_grain_is_not_missed(discs: Callable[..., Any], gas: Callable[..., Any], velocity: tuple[float, float]) -> None:
    """One disc is five hundred times faster than the others, and alone decides about rebuilds."""
    scene = gas(40, 0.4, seed=6, speed=0.1)
    scene["velocity"][7] = velocity
    for frame in discs(**scene, law={"kn": 1e5}, step=2e-5, skin=0.03).record(1500, 11):
        compare(frame, {"kn": 1e5})


def memory(frame: Frame) -> dict[tuple[int, int], tuple[float, float]]:
    """du and the slip velocity of every contact whose spring is below its limit."""
    table, radius = frame.interactions.select(frame.interactions.in_contact & ~frame.interactions.sliding), frame.diameter / 2.0
    i, j, n = table.i, table.j, table.normal
    relative = frame.velocity[j] - frame.velocity[i]
    slip = n[:, 0] * relative[:, 1] - n[:, 1] * relative[:, 0] - radius[i] * frame.omega[i] - radius[j] * frame.omega[j]
    return dict(zip(zip(i.tolist(), j.tolist(), strict=True), zip(table.xi_t, slip, strict=True), strict=True))


def test_contact_memory_follows_its_pair(discs: Callable[..., Any], gas: Callable[..., Any]) -> None:
    """du grows from zero at the opening of a contact, whatever the neighbour list does: it never jumps by more than the
    slip of the steps in between, and it never resets while the contact lasts."""
    sample = discs(**gas(60, 0.5, seed=7, speed=2.0), law={"kn": KN, "kt": KN, "mu": 10.0}, step=STEP, skin=0.02)
    before: dict[tuple[int, int], tuple[float, float]] = {}
    kept = 0
    for frame in sample.record(600, 1):
        now = memory(frame)
        for pair in now.keys() & before.keys():
            mean = STEP * (now[pair][1] + before[pair][1]) / 2.0
            # mu = 10 holds the spring below its limit but for the first and last steps of a contact; slips are of order 1 and
            # change by K_T du/m of order 10 per time, so that the rule is exact to some STEP^2
            assert now[pair][0] - before[pair][0] == pytest.approx(mean, abs=100.0 * STEP**2)
            kept += 1
        before = now
    assert kept > 500 and sample.value("nbuild") > 5


def test_no_pair_is_missed_at_a_size_ratio_of_a_hundred(discs: Callable[..., Any]) -> None:
    """One large disc ploughs through small ones in a shrinking cell."""
    rng, law = np.random.default_rng(0), {"kn": 1e3, "kt": 1e3, "mu": 0.3, "f0": 1e-3, "d0": 1e-3}
    diameter = np.concatenate(([2.0], rng.uniform(0.02, 0.04, 150)))
    grid = np.stack(np.meshgrid(np.arange(20), np.arange(20)), -1).reshape(-1, 2) * 0.3 + 0.15
    free = grid[np.hypot(*(grid - 3.0).T) > 1.05]
    position = np.vstack(([3.0, 3.0], free[rng.permutation(len(free))[:150]]))
    velocity = np.vstack(([2.0, 1.0], rng.normal(size=(150, 2))))
    sample = discs(position=position, diameter=diameter, cell=(6, 6), velocity=velocity, law=law, step=2e-5, skin=0.05,
                   move="stress 1e9 1e9 rate 0.5")  # fmt: skip
    assert sum(compare(frame, law) for frame in sample.record(20000, 400)) > 20

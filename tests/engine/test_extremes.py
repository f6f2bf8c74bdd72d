"""Largest overlap, fastest approach and longest way of it in one step, over every step: against a record of every step."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from workflow.data.frame import Frame
from workflow.deck.template import templates

TABLE = (templates() / "common" / "contact_table.in").read_text(encoding="ascii")
LAW = {"kn": 1e3, "kt": 800.0, "zeta": 0.3, "mu": 0.3, "f0": 0.5, "d0": 2e-2}
DRY = {"kn": 1e3, "kt": 800.0, "zeta": 0.3, "mu": 0.3}
STEP, STEPS, SKIN = 5e-4, 800, 0.05
FIX = "fix eq all disc/equilibrium 100 unit 1\n"  # looks at every hundredth step alone
EXTREMES = slice(17, 20)


def gaps(frame: Frame) -> np.ndarray:
    """Of every pair, by the nearest image."""
    i, j = np.triu_indices(frame.grains, 1)
    away = (frame.position[j] - frame.position[i] + frame.cell / 2.0) % frame.cell - frame.cell / 2.0
    return np.asarray(np.hypot(*away.T) - (frame.diameter[i] + frame.diameter[j]) / 2.0)


def recorded(frames: list[Frame], reach: float, step: float) -> np.ndarray:
    """The three figures from frames of every step: a pair approaches by what its gap lost in the step at whose end it
    interacts."""
    gap = np.array([gaps(frame) for frame in frames])
    lost = np.where(gap[1:] < reach, gap[:-1] - gap[1:], 0.0).max()
    return np.array([-gap.min(), lost / step, lost])


@pytest.mark.parametrize("move", ["", "stress 30 20 mass 0.1"])
@pytest.mark.parametrize("law", [LAW, DRY], ids=["cohesive", "dry"])
def test_extremes_are_those_of_every_step(
    discs: Callable[..., Any], gas: Callable[..., Any], law: dict[str, float], move: str
) -> None:
    sample = discs(**gas(40, 0.5, seed=6), law=law, step=STEP, skin=SKIN, move=move, first=f"{FIX}run 0")
    frames = sample.record(STEPS, 1)
    assert len(frames) == STEPS + 1
    # the gap changes by the mean velocity of the step; the engine takes that in its middle, along n in its middle: (v dt/r)^2
    np.testing.assert_allclose(sample.vector("eq", 20)[EXTREMES], recorded(frames, law.get("d0", 0.0), STEP), rtol=1e-4)
    looked_at = recorded(frames[::100], 1.0, STEP)[0]
    assert sample.vector("eq", 20)[17] > 1.02 * looked_at, "the largest overlap lies between the looks"
    assert sample.vector("eq", 20)[10] <= sample.vector("eq", 20)[17]


@pytest.mark.parametrize("newton", ["on", "off"])
def test_two_ranks_know_the_same(ranks: Callable[..., Frame], gas: Callable[..., Any], tmp_path: Path, newton: str) -> None:
    texts = []
    for number in (1, 2):
        file = tmp_path / "figures"
        values = " ".join(f"$(f_eq[{k}]:%.17g)" for k in (18, 19, 20))
        ranks(number, f'{FIX}run {STEPS}\nprint "{values}" file {file}', newton=newton, law=LAW, step=STEP, skin=SKIN,
              **gas(40, 0.5, seed=6))  # fmt: skip
        texts.append(np.array(file.read_text().split(), float))
    # rounding amplified by a few collisions
    np.testing.assert_allclose(texts[1], texts[0], rtol=1e-8)


def test_extremes_outlive_a_resume(ranks: Callable[..., Frame], gas: Callable[..., Any], tmp_path: Path) -> None:
    """The hardest impacts come first: a run resumed after them has them from its checkpoint, to the last bit, and one that
    goes on from a finished one as well."""
    scene = {**gas(40, 0.5, seed=6), "law": LAW, "step": STEP, "skin": SKIN}
    file = tmp_path / "figures"
    show = 'print "{}" file {}'.format(" ".join(f"$(f_eq[{k}]:%.17g)" for k in (18, 19, 20)), file)
    ranks(1, f"{FIX}restart {STEPS} {tmp_path}/c.*\nrun {2 * STEPS}\n{show}", **scene)
    whole = file.read_text()
    read = f"""units lj
atom_modify map array sort 0 0.0
comm_modify mode single vel yes
neighbor {SKIN} bin
read_restart {tmp_path}/c.{STEPS}
neigh_modify once yes
timestep {STEP}
fix move all disc/integrate
{TABLE}
{FIX}"""
    for number in (1, 2):
        ranks(number, f"run {STEPS}\n{show}", text=read)
        if number == 1:
            assert file.read_text() == whole
        np.testing.assert_allclose(np.array(file.read_text().split(), float), np.array(whole.split(), float), rtol=1e-8)
    ranks(1, f"run 0\n{show}", text=read)
    first = np.array(file.read_text().split(), float)
    np.testing.assert_array_equal(first, np.array(whole.split(), float))

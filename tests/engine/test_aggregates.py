"""Number and size of aggregates during a run against a search through the network of the frame."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from workflow.data.frame import Frame
from workflow.measures.clusters import aggregates

LAW = {"kn": 1e3, "kt": 1e3, "zeta": 0.8, "mu": 0.5, "f0": 1.0, "d0": 2e-2}
FIX = "fix eq all disc/equilibrium 50 unit 1 aggregates yes\n"


@pytest.fixture
def sticky(gas: Callable[..., Any]) -> dict[str, Any]:
    return {**gas(150, 0.4, seed=4, speed=0.5, gap=0.03), "law": LAW, "step": 1e-3, "skin": 0.1}


def test_figures_are_those_of_the_network(discs: Callable[..., Any], sticky: dict[str, Any]) -> None:
    """From single grains to a few aggregates, some of which reach around the cell."""
    sample = discs(**sticky, first=FIX + "run 0")
    counts = []
    for _ in range(6):
        number, largest = sample.vector("eq", 16)[14:]
        found = aggregates(sample.frame()).clusters
        assert (number, largest) == (len(found.grains), found.grains[0])
        counts.append(number)
        sample.run(4000)
    assert counts[0] == 150
    assert counts == sorted(counts, reverse=True)
    assert counts[-1] < 15
    assert found.wraps.any()


@pytest.mark.parametrize(("number", "newton"), [(2, "on"), (2, "off")])
def test_ranks_join_what_crosses_their_borders(
    ranks: Callable[..., Frame], sticky: dict[str, Any], tmp_path: Path, number: int, newton: str
) -> None:
    write = f'print "$(f_eq[15]) $(f_eq[16])" file {tmp_path / "figures"}'
    frame = ranks(number, f"{FIX}run 6000\n{write}", newton=newton, **sticky)
    found = aggregates(frame).clusters
    assert [float(word) for word in (tmp_path / "figures").read_text().split()] == [len(found.grains), found.grains[0]]
    assert 1 < len(found.grains) < 60


def test_a_snake_through_all_ranks_is_one_aggregate(ranks: Callable[..., Frame], tmp_path: Path) -> None:
    """One chain of touching grains that crosses the borders of four ranks again and again, and a grain apart."""
    rows, columns = 9, 18
    path = [(x if row % 4 == 0 else columns - 1 - x, row) for row in range(0, rows, 2) for x in range(columns)]
    for k in range(0, rows - 2, 2):  # links between the rows, at alternating ends
        path.append((columns - 1 if k % 4 == 0 else 0, k + 1))
    position = 0.9999 * np.array(path, float) + 1.0
    position = np.vstack((position, [[1.0 + columns / 2, rows + 3.0]]))
    scene = {"position": position, "diameter": np.ones(len(position)), "cell": (columns + 3.0, rows + 6.0),
             "law": LAW, "step": 1e-9, "skin": 0.1}  # fmt: skip
    ids = np.random.default_rng(0).permutation(len(position)) + 1
    write = f'print "$(f_eq[15]) $(f_eq[16])" file {tmp_path / "figures"}'
    ranks(4, f"{FIX}run 0\n{write}", ids=ids, **scene)
    assert (tmp_path / "figures").read_text().split() == ["2", str(len(path))]


def test_not_asked_for_is_not_computed(discs: Callable[..., Any], sticky: dict[str, Any]) -> None:
    sample = discs(**sticky, first=FIX.replace(" aggregates yes", "") + "run 0")
    assert sample.vector("eq", 16)[14:].tolist() == [0.0, 0.0]


def test_joining_by_attraction_alone_counts_as_a_change(discs: Callable[..., Any], tmp_path: Path) -> None:
    """Two grains come within the range of attraction at t = 0.1: no contact yet, but one aggregate less."""
    position = np.array([[2.0, 2.0], [3.021, 2.0]])
    sample = discs(
        position=position, diameter=np.ones(2), velocity=[[0.01, 0.0], [0.0, 0.0]], law={**LAW, "f0": 1e-9}, step=1e-3,
        first=FIX.replace("50", "1") + "run 0",
    )  # fmt: skip
    sample.run(300)
    vector = sample.vector("eq", 16)
    assert (vector[7], vector[8], vector[14]) == (0.0, 1.0, 1.0)
    assert vector[12] == pytest.approx(0.2, abs=2.1e-3)  # a step or two of the arrival

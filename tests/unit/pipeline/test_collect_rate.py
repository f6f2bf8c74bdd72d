"""How fast the cell was strained, and what the energy residual is compared with, from a time series."""

from __future__ import annotations

import numpy as np
import pytest

from workflow.pipeline.packing import _energy_scale, _fastest

HELD = ("kinetic", "elastic", "tangential", "rolling", "adhesive")
PASSED = ("work", "lost_viscous", "lost_sliding", "lost_rolling", "lost_drag")


def test_largest_rate_of_a_cell_that_shrinks_on_one_axis() -> None:
    """L_y = 2 exp(-t^2/2) shrinks at the rate t; a row that is written twice at a stage's end gives no rate."""
    time = np.array([0.0, 0.1, 0.2, 0.2, 0.3])
    series = {"time": time, "length_x": np.exp(0.01 * time), "length_y": 2.0 * np.exp(-(time**2) / 2)}
    assert _fastest(series, np.log) == pytest.approx(0.25)
    # the speed of the wall is t L_y, its mean between the last two rows that of the lengths
    assert _fastest(series, np.asarray) == pytest.approx(20.0 * (np.exp(-0.02) - np.exp(-0.045)))


@pytest.mark.parametrize("of", [np.log, np.asarray])
def test_fixed_cell(of: object) -> None:
    ones = np.ones(3)
    assert _fastest({"time": np.arange(3.0), "length_x": ones, "length_y": ones}, of) == 0.0  # type: ignore[arg-type]


def series(**columns: list[float]) -> dict[str, np.ndarray]:
    rows = len(next(iter(columns.values())))
    return {name: np.array(columns.get(name, [0.0] * rows)) for name in (*HELD, *PASSED)}


def test_residual_of_a_conservative_run_is_stated_against_the_energy_it_holds() -> None:
    """Nothing is lost and no cell works: the largest energy of grains and contacts in any row until then is the scale."""
    rows = series(kinetic=[2.0, 0.5, 1.0, 9.0], elastic=[0.0, 1.0, 0.5, 0.0], adhesive=[0.0, -0.7, -0.1, 0.0])
    assert _energy_scale(rows, 0) == 2.0
    assert _energy_scale(rows, 2) == pytest.approx(2.2)  # 0.5 + 1.0 + 0.7: bonds hold energy as well
    assert _energy_scale(rows, 3) == 9.0


@pytest.mark.parametrize("name", PASSED)
def test_residual_of_a_driven_run_is_stated_against_what_went_through(name: str) -> None:
    rows = series(**{"kinetic": [0.1, 0.1], name: [0.0, -3.0]})
    assert _energy_scale(rows, 1) == 3.0
    assert _energy_scale(rows, 0) == 0.1

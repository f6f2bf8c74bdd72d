"""The strain rate of a run from its time series."""

from __future__ import annotations

import numpy as np
import pytest

from workflow.engine.collect import _strain_rate


def test_largest_rate_of_a_cell_that_shrinks_on_one_axis() -> None:
    """L_y = exp(-t^2/2) shrinks at the rate t; a row that is written twice at a stage's end gives no rate."""
    time = np.array([0.0, 0.1, 0.2, 0.2, 0.3])
    series = {"time": time, "length_x": np.exp(0.01 * time), "length_y": np.exp(-(time**2) / 2)}
    assert _strain_rate(series) == pytest.approx(0.25)


def test_fixed_cell() -> None:
    ones = np.ones(3)
    assert _strain_rate({"time": np.arange(3.0), "length_x": ones, "length_y": ones}) == 0.0

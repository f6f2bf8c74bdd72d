"""The scene of a heap: derived numbers, feed, refusals."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from workflow.errors import InputError
from workflow.scene.heap import FLOOR, Heap
from workflow.scene.registry import scene_from


def feed(scene: Heap) -> np.ndarray:
    return np.array([line.split() for line in scene.files()["feed.txt"].splitlines()], dtype=float)


def test_feed_is_that_of_the_paper() -> None:
    """31 grains in 50 time units, x uniform in +-3, ids behind those of the base."""
    scene = Heap(grains=1000)
    table = feed(scene)
    assert np.sum(table[:, 1] < 50.0) == 31
    away = table[:, 2] - scene.middle
    assert np.abs(away).max() <= 3.0 and np.abs(away.mean()) < 4.0 * 3.0 / math.sqrt(3.0 * 1000.0)
    assert table[:, 0].tolist() == list(range(len(scene.base_discs()) + 1, len(scene.base_discs()) + 1001))


@pytest.mark.parametrize("delta", [0.0, 0.05, 0.1])
def test_sizes_are_uniform_below_the_largest(delta: float) -> None:
    size = feed(Heap(grains=2000, polydispersity=delta))[:, 3]
    assert size.max() <= 1.0 and size.min() >= 1.0 - delta
    # the mean of 2000 uniform numbers: four standard errors
    assert size.mean() == pytest.approx(1.0 - 0.5 * delta, abs=4.0 * delta / math.sqrt(12.0 * 2000.0) + 1e-12)


def test_same_seed_same_heap() -> None:
    assert Heap(seed=4).files() == Heap(seed=4).files() != Heap(seed=5).files()
    assert Heap(seed=4, mu=0.2).files() == Heap(seed=4).files()


def test_base_is_a_row_of_equal_spacing_about_the_middle() -> None:
    scene = Heap(spacing=1.3)
    x, y = scene.base_discs().T
    assert np.diff(x) == pytest.approx(1.3) and 0.5 * (x[0] + x[-1]) == pytest.approx(scene.middle)
    assert set(y) == {FLOOR} and x[-1] - scene.middle <= scene.half_width


@pytest.mark.parametrize("spacing", [1.0, 1.1])
def test_pyramid_rests_in_the_hollows(spacing: float) -> None:
    scene = Heap(start="pyramid", grains=120, spacing=spacing)
    discs = scene.discs()
    assert len(scene.pyramid()) == 120 and not scene.files()["feed.txt"]
    assert pdist(discs.position).min() == pytest.approx(1.0, abs=1e-9)
    rise = np.ptp(scene.pyramid()[:, 1]) / 14.0
    assert rise == pytest.approx(math.sqrt(1.0 - 0.25 * spacing**2))
    if spacing == 1.0:
        assert math.degrees(math.atan2(rise, 0.5 * spacing)) == pytest.approx(60.0)


def test_step_follows_index_and_impact() -> None:
    """A stiffer law and a higher drop need a smaller step; fewer than four steps per stiffest period are refused."""
    steps = [Heap(index=n, cutoff=c).step_choice.step for n, c in ((36, 1.2), (144, 1.047), (300, 1.02))]
    assert steps[0] > 2.0 * steps[1] > 3.0 * steps[2]
    assert Heap(drop_height=20.0).step_choice.step > 1.5 * Heap().step_choice.step
    with pytest.raises(InputError, match=r"step = 0\.002 is not allowed"):
        Heap(index=144, cutoff=1.047, step=2e-3)


def test_hardest_impact_without_damping_is_that_of_energy() -> None:
    """m v^2/2 = (sigma^n/r^n - 1/r0^n)/n."""
    scene = Heap(damping=0.0)
    expected = (36.0 * 100.0 + 1.2**-36) ** (-1.0 / 36.0)
    assert scene.closest == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"feed_rate": 0.8}, "when the next starts"),
        ({"feed_half_width": 50.0, "base_half_width": 20.0}, "the base ends at 20"),
        ({"skin": 0.1}, "skin = 0.1 is not allowed"),
        ({"base": "soft"}, "one of rough, flat"),
        ({"grains": 0}, "grains = 0"),
        ({"m": 20}, "unknown parameter 'm'"),
        ({"n": 20, "grains": 20}, "'n' and 'grains' are one parameter; keep one"),
    ],
)
def test_impossible_heaps_are_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        scene_from({"scene": "heap", **wrong})

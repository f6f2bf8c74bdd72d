"""`atom_modify sort 1 0.0` of the decks: grains lie in memory as they lie in space, and what they do does not depend on it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from workflow.deck.template import render
from workflow.scene.heap import Heap
from workflow.scene.method1 import Method1
from workflow.scene.method2 import Method2

LAW = {"kn": 1e3, "kt": 800.0, "zeta": 0.05, "mu": 0.3, "f0": 0.1, "d0": 1e-2, "zetat": 0.2}


def step_in_memory(sample: Any) -> float:
    """Mean distance of a grain and the next one in memory, by the nearest image."""
    position = sample.engine.numpy.extract_atom("x")[:, :2].copy()
    cell = np.array([sample.value("lx"), sample.value("ly")])
    away = (np.diff(position, axis=0) + cell / 2.0) % cell - cell / 2.0
    return float(np.hypot(*away.T).mean())


@pytest.mark.parametrize("scene", [Method1(n=50), Method2(n=50), Heap(grains=10)], ids=lambda scene: scene.name)
def test_decks_sort_whenever_lists_are_rebuilt(scene: Any) -> None:
    assert "atom_modify map array sort 1 0.0" in render(scene)


def test_a_mixed_gas_lies_in_memory_as_in_space(
    discs: Callable[..., Any], gas: Callable[..., Any], rewrite: Callable[[str, str], None]
) -> None:
    """Drawn at random places in random order, and mixed: the next in memory is a neighbour when sorted."""
    scene = {**gas(300, 0.4, seed=12, speed=2.0), "law": LAW, "step": 5e-4, "skin": 0.1}
    plain = discs(**scene).run(2000)
    rewrite("sort 0 0.0", "sort 1 0.0")
    sorted_ = discs(**scene).run(2000)
    half = np.mean(scene["cell"]) / 2.0
    assert step_in_memory(plain) > 0.7 * half  # of two random places: 0.765 of half a length
    # rows of bins half a cutoff wide: a step across one, and now and then to the next row
    assert step_in_memory(sorted_) < 0.25 * half


def test_sorting_changes_rounding_alone(
    discs: Callable[..., Any], gas: Callable[..., Any], rewrite: Callable[[str, str], None]
) -> None:
    """Contacts, their memory and the losses follow their grains: the same motion up to the order of sums."""
    scene = {**gas(60, 0.5, seed=4, speed=1.0), "law": LAW, "step": 5e-4, "skin": 0.05}
    plain = discs(**scene).run(800)
    rewrite("sort 0 0.0", "sort 1 0.0")
    sorted_ = discs(**scene).run(800)
    one, two = plain.frame(), sorted_.frame()
    assert not np.array_equal(plain.engine.numpy.extract_atom("id")[:60], sorted_.engine.numpy.extract_atom("id")[:60])
    # rounding at 1e-16, amplified by a few impacts per grain
    np.testing.assert_allclose(two.velocity, one.velocity, rtol=0.0, atol=1e-8)
    assert np.array_equal(two.interactions.i, one.interactions.i) and np.array_equal(two.interactions.j, one.interactions.j)
    np.testing.assert_allclose(two.interactions.xi_t, one.interactions.xi_t, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(sorted_.energy(), plain.energy(), rtol=1e-8, atol=1e-10)
    assert np.count_nonzero(one.interactions.xi_t) > 5

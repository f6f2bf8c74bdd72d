"""Scene consolidation: its stresses, its stages, one material at every stress."""

from __future__ import annotations

from typing import Any

import pytest

from workflow.errors import InputError
from workflow.scene.consolidation import Consolidation
from workflow.scene.method2 import Method2
from workflow.scene.registry import scene_from


def test_stresses_rise_at_equal_ratios_from_the_lowest_to_the_highest_and_fall_through_the_same() -> None:
    scene = Consolidation(pstar_first=1e-3, pstar=10.0, per_decade=2, unload=True)
    assert len(scene.stresses) == 9 + 8
    assert scene.stresses[::2][:5] == pytest.approx([1e-3, 1e-2, 1e-1, 1.0, 10.0])
    assert scene.stresses[8:] == pytest.approx(scene.stresses[8::-1])
    assert Consolidation(pstar_first=0.2, pstar=0.2).stresses == (0.2,)
    # a range that is no whole number of steps ends at the highest all the same
    assert Consolidation(pstar_first=0.01, pstar=0.05, per_decade=1).stresses == pytest.approx([0.01, 0.05])


def test_every_stage_has_its_stress_and_a_name_of_its_own() -> None:
    scene = Consolidation(pstar=1.0, pstar_first=0.01, per_decade=1, unload=True)
    names = list(scene.stages.values())
    assert len(set(names)) == len(names)
    assert [scene.pressure_of(name) for name in names[:4]] == [None, None, 0.0, 0.0]
    assert [scene.pressure_of(name) for name in names[4::2]] == list(scene.stresses)
    assert [scene.pressure_of(name) for name in names[5::2]] == list(scene.stresses)
    assert set(scene.settling) <= set(names)
    assert {name for pair in scene.relaxations for name in pair} <= set(names)


def test_the_material_is_that_of_method_2_at_every_stress() -> None:
    """kappa = K_N a/F0 also above P* = 1, where the other scenes mean K_N/P."""
    low, high, other = Consolidation(pstar=0.1), Consolidation(pstar=10.0), Method2(pstar=0.1)
    assert low.law_in_units == high.law_in_units == other.law_in_units
    assert low.force_unit == high.force_unit == 1.0


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"pstar": 0.01, "pstar_first": 0.1}, "pstar_first"),
        ({"pstar": 0.0}, "pstar = 0"),
        ({"per_decade": 80.0}, "per_decade"),
        ({"per_decade": 0.0}, "per_decade"),
    ],
)
def test_value_that_is_not_allowed_is_named(given: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        scene_from({"scene": "consolidation", **given})

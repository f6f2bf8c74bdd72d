"""Which law and which barostat go together, and what the decks are told of them."""

from __future__ import annotations

import math
import re
from typing import Any

import pytest

from workflow.deck.template import render
from workflow.errors import InputError
from workflow.scene.consolidation import Consolidation
from workflow.scene.method1 import Method1
from workflow.scene.method2 import Method2
from workflow.scene.registry import scene_from
from workflow.scene.routes import mean_pair_mass

FREE = {"cohesion": False}
OF_LAMMPS = ["granular", "hooke/history"]

# scene, parameters that do not go together, what is said: the value, and what to do
REFUSED: list[tuple[str, dict[str, Any], str]] = [
    ("method1", {"law": "hooke/history"}, "hooke/history has no attraction.*cohesion = false, or use granular"),
    ("method1", {"law": "hooke/history", **FREE, "rolling": True}, "no rolling resistance.*use granular"),
    ("method1", {"law": "hooke/history", **FREE, "mu": math.inf}, "up to mu = 10000, not inf.*use granular"),
    ("method1", {"law": "granular", "zeta": 1.0}, "below zeta = 1.*smaller zeta, or the exact law"),
    ("method1", {"law": "granular", "zeta": 0.0}, "zeta = 0 is none.*dashpots = 0, or the exact law"),
    ("method1", {"scheme": "synchronized"}, "synchronized is one of law = granular, not of exact.*second or paper"),
    ("method1", {"law": "hooke/history", **FREE, "scheme": "synchronized"}, "synchronized.*not of hooke/history"),
    ("method1", {"law": "granular", "scheme": "synchronized", "mu": 0.0}, "mu = 0 has none: leave scheme out"),
    ("method1", {"law": "granular", "barostat": "nph", "drag": 1.0}, "no background drag.*dashpots, or barostat = inertial"),
    ("method1", {"barostat": "nph", "wall_cap": 0.05}, "barostat = nph has no cap.*use inertial"),
    ("method1", {"barostat": "berendsen", "rate_cap": 0.05}, "barostat = berendsen has no cap.*use inertial"),
    ("method1", {"barostat": "nph", "convention": 1}, "own momentum convention, -1, not 1.*use inertial"),
    ("method1", {"barostat": "berendsen", "convention": -1}, "no momentum convention, here -1.*use inertial"),
    ("method2", {"law": "hooke/history"}, "hooke/history has no attraction"),
    ("method2", {"law": "granular", "barostat": "nph"}, "barostat = 'nph' is not allowed in method2.*use inertial"),
    ("method2", {"law": "granular", "series": "B"}, "cannot stiffen while they run; use soft_kappa = 10000"),
    ("heap", {"law": "hooke/history"}, "is Hooke's law: give hooke"),
    ("heap", {"law": "hooke/history", "hooke": 500.0, "base": "flat"}, "no smooth floor: use base = rough"),
    ("heap", {"law": "hooke/history", "hooke": 500.0, "printed_rotation": True}, "no printed forms"),
    ("consolidation", {"law": "granular", "barostat": "berendsen"}, "barostat = 'berendsen'.*use inertial"),
]


@pytest.mark.parametrize(("scene", "values", "words"), REFUSED)
def test_what_does_not_go_together_is_refused_with_the_reason(scene: str, values: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        scene_from({"scene": scene, **values})


def test_the_exact_law_is_the_default_and_changes_no_name_of_a_run() -> None:
    assert Method1(law="exact").digest == Method1().digest
    assert "law" not in Method1().as_mapping()


@pytest.mark.parametrize("law", OF_LAMMPS)
def test_a_law_of_lammps_has_the_scheme_of_lammps_and_its_limit_of_stability(law: str) -> None:
    scene, paper = Method1(law=law, **FREE), Method1(scheme="paper", **FREE)
    assert scene.scheme == "paper"
    assert scene.step_choice == paper.step_choice


@pytest.mark.parametrize("barostat", ["nph", "berendsen"])
@pytest.mark.parametrize("law", OF_LAMMPS)
def test_a_deck_that_needs_no_plugin_executes_none_of_its_styles(law: str, barostat: str) -> None:
    """Its commands name a style of the plugin only behind a condition that the law or the barostat does not meet."""
    scene = Method1(law=law, barostat=barostat, **FREE)
    assert not scene.needs_plugin
    commands = [
        line for line in render(scene).splitlines() if re.match(r"\s*(pair_style|pair_coeff|fix|compute|run_style)\b", line)
    ]
    assert commands and not [line for line in commands if "disc/" in line]


@pytest.mark.parametrize("scene", [Method1(law="granular"), Method2(law="granular"), Consolidation(law="granular")])
def test_the_attraction_comes_from_the_plugin(scene: Method1) -> None:
    assert scene.needs_plugin
    assert "hybrid/overlay" in render(scene)


def test_inertia_of_nph_is_that_of_the_equation_of_the_cell() -> None:
    """(N + 1) p^2 = W A, with A half way between the start and a solid fraction of 0.8."""
    scene = Method1(n=400, barostat="nph")
    area = 0.5 * 400 * scene.mean_area * (1 / scene.phi0 + 1 / 0.8)
    assert (scene.n + 1) * scene.nph_period**2 == pytest.approx(scene.cell_inertia * area)


def test_mean_pair_mass_of_equal_discs_is_half_their_mass() -> None:
    assert mean_pair_mass(1.0) == pytest.approx(0.5)
    assert 0.125 < mean_pair_mass(0.5) < 0.5


def test_a_large_size_ratio_is_warned_of_where_small_grains_may_stick() -> None:
    assert any("size ratio" in words for words in Method1(law="granular", smallest=0.2).warnings())
    assert not any("size ratio" in words for words in Method1(law="granular", smallest=0.2, scheme="synchronized").warnings())

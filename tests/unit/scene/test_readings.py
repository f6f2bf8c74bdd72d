"""Readings of the papers' procedures: what each parameter stands for when it is not given, as printed, and in files of 0.2."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workflow.cli.parser import Parser
from workflow.cli.scenes import add_scene, scene_of
from workflow.errors import InputError
from workflow.scene.consolidation import Consolidation
from workflow.scene.heap import Heap
from workflow.scene.method1 import Method1
from workflow.scene.method2 import Method2
from workflow.scene.registry import SCENES, scene_from, to_toml

PACKED = (Method1, Method2, Consolidation)
PRINTED = {
    "method1": {"cell": "strain", "cell_mass": 0.3, "rate_cap": 0.0, "wall_cap": 0.0},
    "method2": {"cell": "strain", "cell_mass": 0.3, "rate_cap": 0.05, "wall_cap": 0.0, "velocities": "temperature"},
    "heap": {"spacing": 1.1},
}
READ = {
    "method1": {"cell": "lengths", "cell_mass": 0.6, "rate_cap": 0.0, "wall_cap": 0.0},
    "method2": {"cell": "lengths", "cell_mass": 0.6, "rate_cap": 0.0, "wall_cap": 0.05, "velocities": "unit_disc"},
    "heap": {"spacing": 1.0},
}


def values(scene: Any, names: Any) -> dict[str, Any]:
    return {name: getattr(scene, name) for name in names}


@pytest.mark.parametrize("name", PRINTED)
def test_one_switch_turns_to_the_printed_forms_and_back(name: str) -> None:
    for printed, expected in ((False, READ[name]), (True, PRINTED[name])):
        assert values(scene_from({"scene": name, "as_printed": printed}), expected) == expected


@given(st.sampled_from(sorted(PRINTED)), st.booleans(), st.data())
def test_what_is_given_stands_and_the_rest_is_as_the_switch_says(name: str, printed: bool, data: st.DataObject) -> None:
    """Any choice of the parameters that have readings, each at either value."""
    other = {"velocities": "same"}
    known = PRINTED[name]
    chosen = data.draw(st.lists(st.sampled_from(sorted(known)), unique=True))
    told = {key: data.draw(st.sampled_from([known[key], READ[name][key], other.get(key, known[key])])) for key in chosen}
    scene = scene_from({"scene": name, "as_printed": printed, **told})
    default = (PRINTED if printed else READ)[name]
    mass = {"cell_mass": {"strain": 0.3, "lengths": 0.6}[told.get("cell", default["cell"])]} if "cell_mass" in known else {}
    assert values(scene, known) == {**default, **mass, **told}
    assert scene_from({"scene": name, **scene.as_mapping()}) == scene  # a file repeats it, whatever defaults become


def test_inertia_follows_the_equation() -> None:
    """W = 0.6 sum(m) of the lengths, M = 0.3 sum(m)/L of the strain: 4/pi times the area of the discs is their mass."""
    for scene in (Method1(n=100, phi0=0.5), Method2(n=100, phi0=0.5)):
        mass = 4.0 / math.pi * 100 * scene.mean_area
        assert scene.cell_inertia == pytest.approx(0.6 * mass)
    scene = Method1(n=100, phi0=0.5, as_printed=True)
    assert scene.cell_inertia == pytest.approx(
        0.3 * 4.0 / math.pi * 100 * scene.mean_area / math.sqrt(100 * scene.mean_area / 0.5)
    )


def test_record_of_what_helps_the_settling_stages() -> None:
    assert Method1(dashpots=0.0).relaxation == "none"
    assert Method1(dashpots=0.0, drag=1.0).relaxation == "drag 1 in settle"
    assert "dashpots and quench of the cell 0.5" in Method2().relaxation


def test_a_slow_wall_takes_its_time() -> None:
    """What the compression takes counts the cap on the walls: a length closes at 0.05 a/T0."""
    slow = Method1(n=200, phi0=0.36, wall_cap=0.05)
    way = math.sqrt(200 * slow.mean_area / 0.36) * (1.0 - math.sqrt(0.36 / 0.8))
    assert slow.compression_time == pytest.approx(way / 0.05)
    assert slow.max_time == pytest.approx(max(500.0, 5.0 * way / 0.05))


# ---- files of version 0.2 -------------------------------------------------------------------------------------------------

OF_GRAINS = {"n": 60, "phi0": 0.3, "smallest": 0.5, "seed": 4}
OF_MATERIAL = {
    "mu": 0.5,
    "rolling": False,
    "cohesion": True,
    "kappa": 1e5,
    "zeta": 0.8,
    "d0": 1e-3,
    "kt_ratio": 1.0,
    "kr_ratio": 1e-4,
}
OF_CELL = {"pstar": 0.01, "barostat": "inertial", "cell_mass": 0.3, "rate_cap": 0.0, "convention": 0, "berendsen_rate": 1.0}
OF_REST = {"force_tolerance": 1e-4, "energy_tolerance": 5e-8, "max_time": 500.0}
OF_NUMERICS = {
    "steps_per_period": 28.0, "scheme": "second", "account": True, "frame_interval": 0.0, "series_interval": 0.2,
    "checkpoint_interval": 5.0,
}  # fmt: skip
METHOD1 = {"scene": "method1", **OF_GRAINS, **OF_MATERIAL, **OF_CELL, **OF_REST, "drag": 1.0, **OF_NUMERICS}
METHOD2 = {
    "scene": "method2", **OF_GRAINS, **OF_MATERIAL, **OF_CELL, **OF_REST, **OF_NUMERICS, "rate_cap": 0.05, "max_time": 5000.0,
    "series": "A", "v0": 9.48, "soft_kappa": 1e5, "stiffening": 100.0, "quiet": 20.0,
}  # fmt: skip
HEAP = {
    "scene": "heap", "grains": 30, "index": 36.0, "cutoff": 1.2, "hooke": 0.0, "mu": 0.5, "alpha": 1.214, "damping": 0.5,
    "printed_rotation": False, "printed_damping": False, "polydispersity": 0.0, "base": "rough", "spacing": 1.1, "start": "pour",
    "feed_rate": 0.62, "feed_half_width": 3.0, "drop_height": 100.0, "seed": 1, "force_tolerance": 1e-4,
    "energy_tolerance": 5e-8, "hold": 2.0, "steps_per_period": 14.0, "scheme": "second", "account": True,
    "frame_interval": 50.0, "track_interval": 2.0, "series_interval": 1.0, "checkpoint_interval": 100.0,
}  # fmt: skip


@pytest.mark.parametrize("file", [METHOD1, METHOD2, HEAP], ids=lambda file: str(file["scene"]))
def test_a_file_of_version_2_keeps_its_meaning(file: dict[str, Any]) -> None:
    """Those files state every parameter that 0.2 knew, automatic ones left out; what came later stands for what it did."""
    scene = scene_from(file)
    assert values(scene, [name for name in file if name != "scene"]) == {k: v for k, v in file.items() if k != "scene"}
    assert scene.as_printed
    printed = {"method1": PRINTED["method1"], "method2": PRINTED["method2"], "heap": PRINTED["heap"]}[file["scene"]]
    assert values(scene, printed) == printed
    if file["scene"] != "heap":
        assert (scene.dashpots, scene.drag) == (0.0, 1.0)  # type: ignore[union-attr]


@pytest.mark.parametrize(("kappa", "drag"), [(1e5, 1.0), (1e4, 0.1**0.5)])
def test_drag_of_method2_was_that_of_its_stiffness(kappa: float, drag: float) -> None:
    """0.2 left an automatic drag out of the file and took sqrt(kappa/1e5)."""
    scene = scene_from({**METHOD2, "kappa": kappa})
    assert isinstance(scene, Method2) and scene.drag == pytest.approx(drag)
    given = scene_from({**METHOD2, "kappa": kappa, "drag": 0.25})
    assert isinstance(given, Method2) and given.drag == 0.25


@pytest.mark.parametrize("scene", [Method1(n=60), Method2(n=60), Consolidation(n=60), Heap(grains=30)], ids=lambda s: s.name)
def test_a_file_of_this_version_is_no_file_of_version_2(scene: Any) -> None:
    import tomllib

    assert scene_from(tomllib.loads(to_toml(scene))) == scene


def test_a_few_parameters_make_no_file_of_version_2() -> None:
    """Somebody's own file that names a scheme and an interval means the readings of today."""
    scene = scene_from({"scene": "method1", "scheme": "paper", "checkpoint_interval": 2.0, "mu": 0.3, "seed": 2})
    assert not scene.as_printed and scene.cell == "lengths"  # type: ignore[union-attr]


@pytest.mark.parametrize("name", sorted(SCENES))
def test_unknown_readings_are_named(name: str) -> None:
    with pytest.raises(InputError, match="as_printed"):
        scene_from({"scene": name, "as_printed": "no"})


def test_as_printed_on_top_of_a_file_replaces_the_readings_that_it_states(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(to_toml(Method2(n=100, mu=0.3, seed=7)))
    parser = Parser()
    add_scene(parser)
    assert scene_of(parser.parse_args([str(file), "--as-printed"])) == Method2(n=100, mu=0.3, seed=7, as_printed=True)
    other = scene_of(parser.parse_args([str(file), "--as-printed", "--cell", "lengths"]))
    assert other == Method2(n=100, mu=0.3, seed=7, as_printed=True, cell="lengths")
    assert scene_of(parser.parse_args([str(file)])) == Method2(n=100, mu=0.3, seed=7)

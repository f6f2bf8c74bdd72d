"""Readings of a paper's procedure: what is declared, the scenes they make, chi^2 and the scan."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workflow.errors import InputError
from workflow.reproduce.papers import points_of
from workflow.reproduce.readings import Line, Reading, chi_squares, read_readings, scans, write_readings
from workflow.scene.registry import scene_from


def line(reading: str, difference: float | None, table: str = "3", quantity: str = "z") -> Line:
    return Line(reading, table, "row", "column", quantity, 3.0, 0.01, 4, 4, 4, "3.1 ± 0.1", difference, "1 2", "a b", "3.0 3.0")


@pytest.mark.parametrize("paper", ["gilabert2007", "baxter1997"])
def test_every_declared_reading_makes_scenes_and_the_first_is_the_default(paper: str) -> None:
    of = read_readings(paper)
    for reading in of.readings:
        for point in points_of(of.of(reading), []):
            scene_from(dict(point.values))
    default = {scene_from(dict(point.values)) for point in points_of(of.of(of.readings[0]), [])}
    assert {scene_from(dict(point.values)) for point in points_of(list(of.numbers), [])} == default


def test_readings_differ_only_where_they_say() -> None:
    of = read_readings("gilabert2007", samples=1)
    points = {one.name: {p.digest for p in points_of(of.of(one), [])} for one in of.readings}
    for one in of.readings:
        if one.name not in ("joint", "W0.6"):  # 0.6 is the default
            shared = points[one.name] & points["joint"]
            assert len(shared) < len(points[one.name]), one.name
    assert points["W0.6"] < points["joint"]


def test_a_number_under_suspicion_of_a_misprint_does_not_decide() -> None:
    assert not [n for n in read_readings("gilabert2007").numbers if n.misprint]


def test_parameters_that_a_scene_has_not_are_left_out() -> None:
    of = read_readings("gilabert2007", chosen=["same-gaussian"])
    case = next(n.case for n in of.numbers if n.case.options["scene"] == "method1")
    assert of.readings[0].of(case).options == case.options


def test_unknown_names_are_refused() -> None:
    with pytest.raises(InputError, match=r"--readings X is not known in G07; there are: joint, W0\.3"):
        read_readings("gilabert2007", chosen=["X"])
    with pytest.raises(InputError, match="unknown paper"):
        read_readings("gilbert")


def test_chi_squares_add_up_over_the_numbers_that_are_there() -> None:
    sums = chi_squares([line("a", 1.0), line("a", -2.0, "4"), line("a", None), line("b", 3.0)])
    assert sums == {"a": {"3": (1.0, 1), "4": (4.0, 1), "all": (5.0, 2)}, "b": {"3": (9.0, 1), "all": (9.0, 1)}}


def scanned(values: list[float], chi2: list[float], numbers: int = 1) -> list[Reading]:
    return [Reading(f"W{v:g}", {"cell_mass": v}, "cell_mass", "", None) for v in values]


def test_scan_finds_the_minimum_of_a_parabola_and_its_interval() -> None:
    values, best, width = [0.3, 0.4, 0.5, 0.6, 0.8, 1.2], 0.55, 0.2
    chi2 = [5.0 + (np.log(v / best) / width) ** 2 for v in values]
    sums = {f"W{v:g}": {"all": (c, 11)} for v, c in zip(values, chi2, strict=True)}
    (fit,) = scans(scanned(values, chi2), sums)
    assert fit.best == pytest.approx(best) and fit.low == pytest.approx(best * np.exp(-width))  # chi^2/dof is below 1
    (wide,) = scans(scanned(values, chi2), {name: {"all": (c["all"][0] + 35.0, 11)} for name, c in sums.items()})
    assert wide.high == pytest.approx(best * np.exp(2.0 * width))  # chi^2/dof is 4


def test_scan_without_a_minimum_inside_or_with_numbers_missing_says_none() -> None:
    values = [0.3, 0.6, 1.2]
    falling = {f"W{v:g}": {"all": (10.0 / v, 11)} for v in values}
    (fit,) = scans(scanned(values, []), falling)
    assert fit.best is None and fit.values == values
    (fit,) = scans(scanned(values, []), falling | {"W0.6": {"all": (1.0, 10)}})
    assert fit.best is None and fit.values == [0.3, 1.2]


def test_files_hold_every_line(tmp_path: Path) -> None:
    of = read_readings("gilabert2007", chosen=["W0.3", "W0.6"])
    found = [line("W0.3", 1.0), replace(line("W0.6", -2.0), at_rest=3)]
    write_readings(tmp_path, of, found, {"command": "wf reproduce gilabert2007 --readings"})
    table = json.loads((tmp_path / "readings.json").read_text())
    assert table["chi2"]["W0.6"]["all"] == {"chi2": 4.0, "numbers": 1} and len(table["numbers"]) == 2
    text = (tmp_path / "readings.md").read_text()
    assert "| W0.3 | 1.0 (1) | 1.0 (1) |" in text and "3 ± 0.01 (4, 1 not at rest)" in text
    assert (tmp_path / "readings.csv").read_text().count("\n") == 3

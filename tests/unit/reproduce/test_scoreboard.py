"""Printed numbers against ours: the data of the papers, the statistics on hand-made cases, the tables that are written."""

from __future__ import annotations

import csv
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from workflow.campaign.measured import found_at, group_of, jackknife, of_samples
from workflow.data.contact_law import ContactLaw
from workflow.errors import InputError
from workflow.measures.density import Scattering
from workflow.measures.registry import Settings
from workflow.reproduce.papers import Case, Paper, Printed, papers, points_of, read_paper
from workflow.reproduce.scoreboard import (
    AGREES,
    DIFFERS,
    MISPRINT,
    NOT_RUN,
    UNJUDGED,
    VERDICTS,
    Ours,
    counts,
    judge,
    markdown,
    write,
)
from workflow.scene.registry import scene_from

CASE = Case(("2", "row", "column"), {"scene": "method1"}, ((60, 4),), {}, "n", None)


def printed(**known: Any) -> Printed:
    return Printed(CASE, "z", "coordination", **known)


# ---- the data ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", papers())
@pytest.mark.parametrize("quick", [False, True])
def test_every_entry_of_a_paper_makes_sense(name: str, quick: bool) -> None:
    """Every scene can be resolved, every stage exists in it, every matrix fits its table, every figure has a kind."""
    from workflow.reports.registry import FIGURES, figures_of
    from workflow.reproduce.figures import SKETCH

    paper = read_paper(name, quick=quick)
    for number in paper.numbers:
        known = [number.value, number.low, number.high]
        assert set(known) != {None}, known
        assert number.error is None or number.error > 0
        assert number.measure or number.reason, f"{number} can neither be measured nor says why"
        if number.case.options:
            assert quick or number.case.sizes
            scene = scene_from({**number.case.options, "seed": 1})
            assert number.case.stage is None or number.case.stage in scene.stages.values()
    places = [(number.case.where, number.quantity) for number in paper.numbers]
    assert len(places) == len(set(places))
    for drawing in paper.drawings:
        sketch = drawing.plot in FIGURES[SKETCH]
        assert bool(drawing.cases) != sketch
        for case in drawing.cases:
            assert drawing.plot in figures_of(scene_from({**case.options, "seed": 1}).figures)
        assert drawing.shows
    last = {"gilabert2007": 23, "baxter1997": 8}[name]
    assert {int(re.match(r"\d+", drawing.number)[0]) for drawing in paper.drawings} == set(range(1, last + 1))


def test_printed_values_of_g07() -> None:
    """Some entries by hand, from the page: a transposed matrix would move them."""
    found = {(n.case.where, n.quantity): (n.value, n.error) for n in read_paper("gilabert2007").numbers}
    assert found[("2", "Phi_I 0.130", "RR, mu 0.5"), "z"] == (2.526, 0.021)
    assert found[("3", "Phi_I 0.3631", "no RR, mu 0.15"), "Phi"] == (0.727, 0.001)
    assert found[("3", "Phi_I 0.5244", "RR, mu 0.5"), "z"] == (2.851, 0.001)
    assert found[("4", "B", "RR"), "z"] == (2.963, 0.006)
    assert found[("5", "A", "no RR"), "Phi"] == (0.472, 0.008)
    assert found[("6", "V0/V* 95", ""), "N+(2)"] == (0.16, None)
    assert found[("7", "P* 0.01", "RR"), "xi"] == (5.06, 0.21)
    assert sum(where[0] == "3" for where, _ in found) == 24
    assert sum(where[0] == "2" for where, quantity in found if quantity != "rattlers") == 24


def test_samples_and_sizes_of_a_case() -> None:
    paper = read_paper("gilabert2007")
    (a,) = [n.case for n in paper.numbers if n.case.where == ("4", "A", "RR") and n.quantity == "z"]
    values = list(a.values())
    assert [(one["n"], one["seed"]) for one in values] == [(1400, k) for k in (1, 2, 3, 4)] + [(5600, k) for k in (1, 2, 3)]
    assert [one.get("frame_interval") for one in values] == [10] + [None] * 6
    (fewer,) = [n.case for n in read_paper("gilabert2007", samples=1).numbers if n.case.where == a.where and n.quantity == "z"]
    assert [one["n"] for one in fewer.values()] == [1400, 5600]
    (quick,) = [n.case for n in read_paper("gilabert2007", quick=True).numbers if n.case.where == a.where and n.quantity == "z"]
    assert {one["n"] for one in quick.values()} == {100}


def test_tables_that_share_runs_compute_them_once() -> None:
    """Tables IV, V and VII of series A are measured on the same samples."""
    paper = read_paper("gilabert2007")
    fifth = {point.digest for point in points_of(*paper.chosen(["5"], None))}
    both = {point.digest for point in points_of(*paper.chosen(["5", "7"], None))}
    assert len(fifth) == 22
    assert fifth < both
    assert len(both) == 22 + 3  # and the tree-like aggregates


def test_tables_and_figures_are_chosen_by_name() -> None:
    paper = read_paper("gilabert2007")
    numbers, drawings = paper.chosen(["6"], None)
    assert {n.case.where[0] for n in numbers} == {"6"}
    assert not drawings
    numbers, drawings = paper.chosen(None, ["9"])
    assert not numbers
    assert [d.number for d in drawings] == ["9a", "9b", "9c-P0", "9c-P0.01"]
    assert [d.number for d in paper.chosen(None, ["9c"])[1]] == ["9c-P0", "9c-P0.01"]
    with pytest.raises(InputError, match="--table 9 is not known in G07; there are: 2, 3, 4, 5, 6, 7, text"):
        paper.chosen(["9"], None)
    with pytest.raises(InputError, match="--figure 99 is not known"):
        paper.chosen(None, ["99"])
    with pytest.raises(InputError, match="unknown paper 'gilbert'; did you mean gilabert2007"):
        read_paper("gilbert")


# ---- the statistics ---------------------------------------------------------------------------------------------------


def test_mean_and_standard_error() -> None:
    """Of 1, 2, 3, 6: mean 3, scatter sqrt(14/3), standard error half of it; the jackknife of a mean is just that."""
    samples = [{"a": {"b": value}} for value in (1.0, 2.0, 3.0, 6.0)]
    assert of_samples("a.b", samples, None) == 3.0
    assert jackknife("a.b", samples, None) == pytest.approx(math.sqrt(14.0 / 3.0) / 2.0, rel=1e-14)
    assert jackknife("a.b", samples[:1], None) is None
    assert of_samples("a.c", samples, None) is None
    assert jackknife("a.c", samples, None) is None
    assert found_at({"a": True}, "a") is None
    assert group_of("forces.populations.strong") == "forces"
    assert group_of("solid_fraction") is None


def test_fit_is_made_to_the_mean_over_samples() -> None:
    """I(k) of eq. 28 with d_F = 1.6, xi = 5 and opposite deviations of two samples: only the mean has these parameters."""
    from workflow.measures.fractal import fractal_intensity
    from workflow.measures.registry import density_of, plain

    edges = np.geomspace(0.05, 4.0, 25)
    k = np.sqrt(edges[1:] * edges[:-1])
    exact = fractal_intensity(k, 0.4, 1.6, 5.0, 0.5, 0.05)
    tilt = 0.05 * np.log(k)
    samples = []
    for sign in (1.0, -1.0):
        one = Scattering(edges, k, exact * (1.0 + sign * tilt), np.full(24, np.nan), np.full(24, 100.0), 0.4)
        samples.append({"density": plain(density_of([one], SETTINGS))})
    assert of_samples("density.fit.dimension", samples, SETTINGS) == pytest.approx(1.6, abs=1e-3)
    assert of_samples("density.fit.xi", samples, SETTINGS) == pytest.approx(5.0, rel=1e-2)
    assert of_samples("density.fit.dimension", samples[:1], SETTINGS) != pytest.approx(1.6, abs=1e-2)
    assert (jackknife("density.fit.dimension", samples, SETTINGS) or 0.0) > 0.01


def test_fit_to_samples_of_two_sizes() -> None:
    """One of six cells is larger and alone on the two lowest shells, which have no scatter: the fit does without."""
    from workflow.measures.fractal import fractal_intensity
    from workflow.measures.registry import density_of, plain

    edges = np.geomspace(0.05, 4.0, 25)
    k = np.sqrt(edges[1:] * edges[:-1])
    exact = fractal_intensity(k, 0.4, 1.6, 5.0, 0.5, 0.05)
    samples = []
    for number, first in enumerate([0, 2, 2, 2, 2, 2]):
        intensity = exact * (1.0 + 1e-4 * np.cos(number + np.arange(24)))
        one = Scattering(
            edges[first:], k[first:], intensity[first:], np.full(24 - first, np.nan), np.full(24 - first, 100.0), 0.4
        )
        samples.append({"density": plain(density_of([one], SETTINGS))})
    assert of_samples("density.fit.dimension", samples, SETTINGS) == pytest.approx(1.6, abs=1e-2)


SETTINGS = Settings(ContactLaw(kn=1e5, kt=1e5, mu=0.5, f0=1.0, d0=1e-3), window=(0.05, 4.0))


def test_base_profile_and_avalanches_of_several_heaps() -> None:
    """Heaps of half width 20 whose mean has 8 in the middle and 10 at its maxima: 25 % above; sizes choose the avalanches."""
    x = np.arange(-20.0, 21.0)

    def heap(left: float, right: float, depths: list[float]) -> dict[str, Any]:
        force = np.where(
            np.abs(x) < 3.0, 8.0, np.where(np.abs(x + 6.6) < 2.0, left, np.where(np.abs(x - 6.6) < 2.0, right, 5.0))
        )
        events = [{"size": 100 + k, "depth": depth} for k, depth in enumerate(depths)]
        small = [{"size": 10, "depth": 1.0}] * 20
        profile = {"x": x.tolist(), "force": force.tolist()}
        return {"base_force_profile": profile, "half_width": 20.0, "avalanches": small + events}

    heaps = [heap(9.0, 11.0, [3.0] * 10), heap(11.0, 9.0, [4.0] * 10)]
    found = of_samples("base_profile.maxima_above_centre", heaps, None)
    each = [of_samples("base_profile.maxima_above_centre", [one], None) for one in heaps]
    assert found == pytest.approx(np.mean([value for value in each if value is not None]), rel=1e-12)
    assert 0.15 < (found or 0.0) <= 0.25
    assert of_samples("avalanches.depth_of_largest", heaps, None) == 3.5


def test_difference_in_standard_errors() -> None:
    """(2.60 - 2.65)/sqrt(0.03^2 + 0.04^2) = -1."""
    row = judge(printed(value=2.65, error=0.04), Ours(2.60, 0.03, 4, 4, 4))
    assert row.difference == pytest.approx(-1.0)
    assert row.verdict == AGREES
    far = judge(printed(value=2.65, error=0.0, reason="known"), Ours(2.50, 0.03, 4, 4, 4))
    assert far.difference == pytest.approx(-5.0)
    assert (far.verdict, far.reason) == (DIFFERS, "known")
    doubted = judge(printed(value=2.65, error=0.0, misprint="twice in a row"), Ours(2.50, 0.03, 4, 4, 4))
    assert (doubted.verdict, doubted.reason) == (MISPRINT, "twice in a row")
    assert judge(printed(value=2.65, error=0.04, misprint="not needed"), Ours(2.60, 0.03, 4, 4, 4)).reason == ""


def test_a_missing_uncertainty_is_that_of_the_other_side() -> None:
    alone = judge(printed(value=2.65, error=0.06), Ours(2.50, None, 1, 4, 1))
    assert alone.difference == pytest.approx(-0.15 / (0.06 * math.sqrt(2.0)))
    assert alone.verdict == AGREES
    far = judge(printed(value=2.65, error=0.01, misprint="doubted"), Ours(2.50, None, 1, 4, 1))
    assert (far.verdict, far.reason) == (UNJUDGED, "one sample: our scatter is not known")
    assert far.difference == pytest.approx(-0.15 / (0.01 * math.sqrt(2.0)))
    bare = judge(printed(value=2.65), Ours(2.60, 0.02, 4, 4, 4))  # scatter 0.04, error 0.02
    assert bare.difference == pytest.approx(-0.05 / math.hypot(0.02, 0.04))
    assert judge(printed(value=2.65), Ours(2.60, None, 1, 1, 1)).verdict == UNJUDGED
    nothing = judge(printed(value=2.65), Ours(wanted=4, trouble="no sample is finished"))
    assert (nothing.verdict, nothing.reason, nothing.ours) == (NOT_RUN, "no sample is finished", None)


@pytest.mark.parametrize(
    ("low", "high", "ours", "error", "difference", "verdict"),
    [
        (None, 0.18, 0.17, 0.01, 0.0, AGREES),
        (None, 0.18, 0.20, 0.01, 2.0, AGREES),
        (None, 0.18, 0.22, 0.01, 4.0, DIFFERS),
        (1e-3, 8e-3, 4e-3, None, 0.0, AGREES),
        (1e-3, 8e-3, 5e-4, 1e-4, -5.0, DIFFERS),
        (1e-3, 8e-3, 5e-4, None, None, UNJUDGED),
        (0.5, None, 0.4, 0.1, -1.0, AGREES),
    ],
)
def test_bounds_are_judged_by_their_side(low: Any, high: Any, ours: float, error: Any, difference: Any, verdict: str) -> None:
    row = judge(printed(low=low, high=high), Ours(ours, error, 2, 2, 2))
    assert row.verdict == verdict
    assert row.difference == (None if difference is None else pytest.approx(difference))


# ---- the files --------------------------------------------------------------------------------------------------------


def test_no_number_is_hidden(tmp_path: Path) -> None:
    """Every printed number is a line of every file, measured or not."""
    paper = read_paper("gilabert2007")
    rows = [judge(number, Ours(wanted=1, trouble="no sample is finished")) for number in paper.numbers]
    rows[0] = judge(paper.numbers[0], Ours(0.8262, 0.001, 4, 4, 3, "1 2 3 4", "a b c d"))
    figures = [{"number": "9a", "plot": "distribution", "file": "figures/fig9a.png", "shows": "decay", "trouble": ""}]
    write(tmp_path, paper, rows, figures, {"command": "wf reproduce"})
    with open(tmp_path / "scoreboard.csv", newline="") as file:
        table = list(csv.DictReader(file))
    assert len(table) == len(paper.numbers)
    assert table[0]["ours"] == "0.8262"
    assert table[0]["seeds"] == "1 2 3 4"
    assert table[1]["ours"] == ""
    data = json.loads((tmp_path / "scoreboard.json").read_text())
    assert len(data["numbers"]) == len(paper.numbers)
    assert data["counts"] == {AGREES: 1, DIFFERS: 0, MISPRINT: 0, UNJUDGED: 0, NOT_RUN: len(paper.numbers) - 1}
    assert sum(counts(rows)[verdict] for verdict in VERDICTS) == len(rows)
    text = (tmp_path / "scoreboard.md").read_text()
    lines = [line for line in text.splitlines() if len(re.findall(r"(?<!\\)\|", line)) == 9]
    assert len([line for line in lines if not line.startswith(("| row", "|---"))]) == len(paper.numbers)
    assert "| 0.8262 ± 0.001 | 4/4, 1 not at rest | 0.8262 ± 0.0007 | +0.0 | agrees |" in text
    assert "below 0.18" in text
    assert "[figures/fig9a.png](figures/fig9a.png)" in text
    assert "Not the paper's size" not in text


def test_quick_says_what_it_is() -> None:
    paper: Paper = read_paper("baxter1997", quick=True)
    text = markdown(paper, [judge(number, Ours()) for number in paper.numbers], [], {})
    assert "Not the paper's size" in text

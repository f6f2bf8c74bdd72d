"""What `wf measure` says of the network of a real packing, and `wf bench`."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Wf = Callable[..., subprocess.CompletedProcess[str]]


def test_rigidity_counts_of_a_real_packing_close(packing: Path, wf: Wf) -> None:
    """N_f + H = M + k (G07 appendix A): 3 N + 2 cell degrees, two rows per contact with friction, none distant here."""
    measures = json.loads(wf("measure", packing, "--json").stdout)
    rigidity, interactions = measures["rigidity"], measures["interactions"]
    freedom = 3 * measures["grains"] + rigidity["cell_degrees"]
    rows = 2 * interactions["contacts"] + interactions["distant"]
    assert freedom + rigidity["hyperstaticity"] == rows + rigidity["floppy_modes"]
    rattlers = round(measures["rattler_fraction"] * measures["grains"])
    assert rigidity["floppy_modes"] >= 3 * rattlers + 2  # a loose grain has three mechanisms, and the whole drifts
    assert rigidity["unstable_modes"] == 0
    # the strongest forces of a compressed packing wind around the cell, near the mean force of order a P
    assert 0.1 < measures["forces"]["percolation"]["threshold"] < 10.0
    # stiff against compression: the order of K_N = kappa P, and never above it by more than the coordination
    assert 0.01 * 1e3 < measures["elastic_moduli"]["c11"] < 10.0 * 1e3


def test_groups_can_be_left_out_and_misspelt(packing: Path, wf: Wf) -> None:
    assert "rigidity" not in json.loads(wf("measure", packing, "--json", "--only", "none").stdout)
    done = wf("measure", packing, "--only", "forces,hols")
    assert done.returncode == 2 and "'hols' is no group" in done.stderr and "holes" in done.stderr


KEYS = {"engine", "state", "n", "ranks", "ns_per_grain_step", "least", "most", "ratio", "grain_steps_per_second", "pair"}


def test_bench_times_what_is_asked(wf: Wf) -> None:
    """One row per engine, state, size and number of ranks and nothing else; nothing is said of how fast."""
    words = ["--n", "100,150", "--state", "gas", "--engines", "exact,hooke/history", "--steps", "50", "--rounds", "1"]
    rows = json.loads(wf("bench", *words, "--csv", "table.csv", "--json").stdout)
    assert [(row["n"], row["engine"]) for row in rows] == [
        (n, engine) for n in (100, 150) for engine in ("exact", "hooke/history")
    ]
    for row in rows:
        assert row.keys() >= KEYS
        assert (row["state"], row["ranks"]) == ("gas", 1), row
        assert row["ns_per_grain_step"] > 0.0, row


def test_bench_on_a_run(packing: Path, wf: Wf) -> None:
    done = wf("bench", packing, "--engines", "exact,granular", "--steps", "50", "--rounds", "1")
    assert done.returncode == 0, done.stderr
    assert "run, 60 grains, 1 rank" in done.stdout and "granular" in done.stdout


def test_bench_says_what_is_not_installed(wf: Wf, tmp_path: Path) -> None:
    words = ["--n", "100", "--state", "gas", "--engines", "exact,liggghts", "--steps", "20", "--rounds", "1", "--json"]
    done = wf("bench", *words, PATH=str(tmp_path))
    assert done.returncode == 0 and "liggghts not installed: apt-get install liggghts" in done.stderr
    assert [row["engine"] for row in json.loads(done.stdout)] == ["exact"]


@pytest.mark.parametrize(
    "words",
    [
        ["--n", "100", "120", "--engines", "exact", "granular"],
        ["--n", "100,", "120", "--engines", "exact, granular"],
        ["--n", "100", "--engines", "exact", "--n", "1.2e2", "--engines", "granular"],
    ],
)
def test_bench_takes_lists_as_they_are_typed(words: list[str], wf: Wf) -> None:
    done = wf("bench", *words, "--state", "gas", "--steps", "20", "--rounds", "1", "--json")
    assert done.returncode == 0, done.stderr
    rows = [(row["n"], row["engine"]) for row in json.loads(done.stdout)]
    assert rows == [(n, engine) for n in (100, 120) for engine in ("exact", "granular")]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--engines", "exakt"], "--engines 'exakt' is not known; did you mean exact? known are: exact, stock"),
        (["--state", "glass"], "known are: gas, dense"),
        (["--n", "1400,-3"], "--n '-3' is not allowed"),
        (["--n", "99999999999"], "n = 99999999999 is not allowed"),
        (["--n", ","], "--n is empty"),
        (["--ranks", "2", "--engines", "liggghts,yade"], "liggghts and yade are timed on one rank only; give --ranks 1 too"),
        (["--csv", "nowhere/table.csv"], "there is no directory 'nowhere'"),
        (["--ranks", "0"], "--ranks '0' is not allowed"),
        (["--rounds", "0"], "--rounds '0' is not allowed"),
        (["nowhere", "--n", "100"], "leave out DIR"),
        (["--against", "nowhere/python"], "--against 'nowhere/python' is no program"),
        (["nowhere", "--against", "python3"], "leave out DIR"),
    ],
)
def test_bench_refuses(words: list[str], message: str, wf: Wf) -> None:
    done = wf("bench", *words)
    assert done.returncode == 2 and message in done.stderr


def test_bench_wants_a_packing_that_stays_together(wf: Wf) -> None:
    assert wf("deck", "method1", "--n", "60", "--out", "cohesive").returncode == 0
    done = wf("bench", "cohesive")
    assert done.returncode == 2 and "--no-cohesion" in done.stderr


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--n", "10"], "--n '10' is not allowed: give whole numbers of at least 2000"),
        (["--n", "many"], "--n 'many' is not allowed"),
        (["--state", "heap"], "--state 'heap' is not known; known are: gas, dense"),
        (["--ranks", "2"], "give 1 too"),
        (["--steps", "0"], "must be above 0"),
        (["--out", "."], "is not empty"),
    ],
)
def test_scale_refuses(words: list[str], message: str, wf: Wf, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    done = wf("scale", *words)
    assert done.returncode == 2 and message in done.stderr

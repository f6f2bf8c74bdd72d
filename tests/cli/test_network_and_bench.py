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


@pytest.mark.parametrize("words", [["--steps", "200", "--rounds", "1"]])
def test_bench_times_every_case(words: list[str], packing: Path, wf: Wf) -> None:
    """Positive times, ratios to the reference of the same round; nothing is said of how fast."""
    timings = json.loads(wf("bench", packing, *words, "--json").stdout)
    assert len({timing["case"] for timing in timings}) == len(timings) >= 6
    assert all(0.0 < timing["least"] <= timing["median"] <= timing["most"] for timing in timings)
    reference = next(timing for timing in timings if timing["case"].startswith("gran/hooke/history, fixed"))
    assert reference["ratio"] == 1.0


def test_bench_wants_a_packing_that_stays_together(wf: Wf) -> None:
    assert wf("deck", "method1", "--n", "60", "--out", "cohesive").returncode == 0
    done = wf("bench", "cohesive")
    assert done.returncode == 2 and "--no-cohesion" in done.stderr

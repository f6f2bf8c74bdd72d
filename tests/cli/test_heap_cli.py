"""`wf` with the scene heap: run, measure, plot, stop and resume."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from wf_process import Wf, call, kill, record

from workflow.archive.read import Archive

SMALL = ["heap", "--grains", "40", "--drop-height", "15", "--frame-interval", "20"]


@pytest.fixture(scope="module")
def heap(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("heap")
    done = call("run", *SMALL, "--out", "run", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert "angle of repose" in done.stdout and "40 poured" in done.stdout
    for words in ("energy residual", "14 per stiffest period, ", " in the run"):
        assert words in done.stdout
    return folder / "run"


def test_measures_have_the_promised_keys(heap: Path, wf: Wf) -> None:
    measures = json.loads(wf("measure", heap, "--json").stdout)
    assert set(measures["angle_of_repose_deg"]) == {"left", "right", "mean", "uncertainty"}
    assert measures["base_force_profile"]["sum_over_weight"] == pytest.approx(1.0, abs=1e-3)
    assert isinstance(measures["avalanches"], list) and measures["equilibrated"]
    # second order at 14 steps per stiffest period
    assert abs(measures["energy_residual"]["relative"]) < 0.004
    # measured at every step: the first grains meet the base at nearly the speed of the fall, later ones fall less far, and
    # what hits aside has a part of it along the normal
    numerics = measures["numerics"]
    assert 0.8 * np.sqrt(2.0 * 15.0) < numerics["fastest_approach"] <= np.sqrt(2.0 * 15.0)
    assert numerics["steps_in_tail"] == pytest.approx(0.2 / (numerics["fastest_approach"] * numerics["step"]), rel=1e-9)
    assert measures["poured"] == 40 and measures["equivalent_hooke"]["stiffness"] > 37.0


def test_archive_knows_that_nothing_is_periodic(heap: Path) -> None:
    with Archive(heap / "run.h5") as archive:
        frame, tracks = archive.frame(-1), archive.tracks
        assert frame.periodic == (False, False) and len(archive) > 3
        assert tracks is not None and set(frame.ids) <= set(tracks.ids)
    with h5py.File(heap / "run.h5") as file:
        assert [face.decode() for face in file["particles/grains/box"].attrs["boundary"]] == ["none"] * 3


def test_figures_of_a_heap_are_drawn(heap: Path, wf: Wf, tmp_path: Path) -> None:
    done = wf("plot", heap, "--out", tmp_path, "--format", "png")
    assert done.returncode == 0, done.stderr
    for name in ("heap", "vectors", "forces", "maps"):
        assert (tmp_path / f"{name}.png").stat().st_size > 5000, name


def test_status_says_how_far(heap: Path, wf: Wf) -> None:
    assert "grains 40 of 40" in wf("status", heap).stdout


def test_killed_heap_is_resumed(running: Callable[..., Any], wf: Wf) -> None:
    run = running("heap", "--grains", "150", "--drop-height", "15", "--checkpoint-interval", "5")
    run.wait_for_rows(40)
    for pid in (*run.engine(), run.process.pid):
        kill(pid)
    run.process.communicate()
    done = wf("resume", "slow", "--json")
    assert done.returncode == 0, done.stderr
    measures = json.loads(done.stdout)
    assert measures["poured"] == 150 and measures["base_force_profile"]["sum_over_weight"] == pytest.approx(1.0, abs=1e-3)
    assert record(run.directory)["status"] == "finished"


def test_floor_that_holds_no_heap(wf: Wf) -> None:
    words = ["--grains", "10", "--base", "flat", "--base-half-width", "5", "--drop-height", "10", "--max-time", "120"]
    done = wf("run", "heap", *words, "--out", "flat")
    assert done.returncode == 0 and "0 in the heap" in done.stdout, done.stderr
    drawn = wf("plot", "flat")
    assert drawn.returncode == 2 and "holds no heap" in drawn.stderr

"""A scene that is no packing comes from outside the package: its deck, measure, figure, page and progress line are its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from workflow.archive.read import Archive

SCENE = Path(__file__).resolve().parents[2] / "examples" / "10_silo" / "scene" / "silo.py"
GRAINS = 120


def wf(*words: str, cwd: Path, status: int = 0) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "WORKFLOW_SCENES": str(SCENE), "MPLBACKEND": "Agg"}
    command = [sys.executable, "-m", "workflow.cli.main", *words]
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == status, done.stdout + done.stderr
    return done


@pytest.fixture(scope="module")
def silos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Runs with openings of 1, 4 and 8 grains."""
    folder = tmp_path_factory.mktemp("silos")
    for opening in (1, 4, 8):
        wf("run", "silo", "--n", str(GRAINS), "--opening", str(opening), "--out", f"o{opening}", cwd=folder)
    return folder


def measures(folder: Path, opening: int) -> dict[str, float]:
    return json.loads(wf("measure", f"o{opening}", "--json", cwd=folder).stdout)


def test_wider_opening_lets_grains_out_faster(silos: Path) -> None:
    """Beverloo: the rate in two dimensions grows as (D - k d)^(3/2); an opening of one grain passes next to none."""
    narrow, middle, wide = (measures(silos, opening) for opening in (1, 4, 8))
    assert wide["rate"] > 1.5 * middle["rate"]
    assert narrow["passed"] < 0.1 * GRAINS < middle["passed"]


@pytest.mark.parametrize("opening", [1, 4, 8])
def test_no_grain_is_lost_and_no_wall_moves(silos: Path, opening: int) -> None:
    found = measures(silos, opening)
    assert found["passed"] + found["left"] == GRAINS
    with Archive(silos / f"o{opening}" / "run.h5") as archive:
        first, last = archive.frame(0), archive.frame(-1)
        assert archive.series["passed"][-1] == pytest.approx(found["passed"], abs=2)  # a row of a little earlier
    assert len(last.ids) == len(first.ids)
    walls = len(first.ids) - GRAINS
    assert (first.position[:walls] == last.position[:walls]).all()


def test_its_figure_is_listed_and_drawn_alone_and_of_several(silos: Path) -> None:
    assert "discharge" in wf("plot", "--help", cwd=silos).stdout
    assert wf("plot", "o4", "--format", "png", cwd=silos).stdout.split() == ["o4/discharge.png"]
    wf("plot", "o4", "o8", "--out", "both", "--format", "png", cwd=silos)
    assert (silos / "both" / "discharge.png").stat().st_size > 5000


def test_figures_and_groups_of_packings_are_refused_by_name(silos: Path) -> None:
    assert "choose from discharge" in wf("plot", "o4", "--figure", "forces", cwd=silos, status=2).stderr
    for words in (["--only", "forces"], ["--stages"]):
        assert "'o4' is a silo" in wf("measure", "o4", *words, cwd=silos, status=2).stderr


def test_page_and_status_show_what_the_scene_has(silos: Path) -> None:
    wf("report", "o4", cwd=silos)
    page = (silos / "o4" / "report.html").read_text(encoding="utf-8")
    assert "discs that run out of a silo" in page and "passed" in page
    assert f"of {GRAINS}" in wf("status", "o4", cwd=silos).stdout


def test_run_repeats_to_the_byte(silos: Path) -> None:
    assert "every byte" in wf("verify", "o8", cwd=silos).stdout


def test_kind_without_measures_is_named(silos: Path, tmp_path: Path) -> None:
    text = SCENE.read_text(encoding="utf-8").replace('KINDS["silo"]', 'KINDS["other"]')
    (tmp_path / "silo.py").write_text(text, encoding="utf-8")
    (tmp_path / "silo.in").write_text(SCENE.with_suffix(".in").read_text(encoding="utf-8"), encoding="utf-8")
    environment = {**os.environ, "WORKFLOW_SCENES": str(tmp_path / "silo.py")}
    for words in (["measure", "o4"], ["run", "silo", "--n", "20", "--out", "other"]):
        command = [sys.executable, "-m", "workflow.cli.main", *words]
        done = subprocess.run(command, cwd=silos, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 2 and "kind 'silo', which has no measures" in done.stderr
    assert not (silos / "other" / "series.txt").exists()

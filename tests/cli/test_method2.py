"""`wf run method2`: what each stage leaves behind, and what is recorded of it."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from wf_process import Wf, record

from workflow.archive.read import Archive
from workflow.data.frame import Frame
from workflow.data.series import read_series
from workflow.deck.template import templates
from workflow.measures.clusters import aggregates
from workflow.runs.directory import RunDirectory
from workflow.runs.installation import engine
from workflow.scene.packing import Packing

Whole = tuple[Path, float]
STAGES = ["aggregate", "relax", "free", "stiffen", "load", "settle"]


@pytest.fixture(scope="module")
def archive(whole: Whole) -> Archive:
    return Archive(whole[0] / "run.h5")


def read_scene(whole: Whole) -> Packing:
    scene = RunDirectory.open(whole[0]).scene
    assert isinstance(scene, Packing)
    return scene


@pytest.fixture(scope="module")
def ends(archive: Archive) -> dict[str, Frame]:
    return {stage: archive.frame(k) for k, stage in enumerate(archive.stages)}


def test_all_stages_are_there_in_order(archive: Archive) -> None:
    assert list(dict.fromkeys(archive.stages)) == STAGES


def test_aggregates_are_watched(archive: Archive, ends: dict[str, Frame]) -> None:
    series = archive.series
    assert series["aggregates"][0] == 60 and series["largest_aggregate"][0] == 1
    for stage in STAGES[:3]:
        found = aggregates(ends[stage]).clusters
        assert len(found.grains) == 1
        row = int(np.searchsorted(series["step"], ends[stage].step))
        assert series["aggregates"][row] == 1 and series["largest_aggregate"][row] == 60


def test_cell_is_fixed_then_free_then_loaded(archive: Archive, ends: dict[str, Frame]) -> None:
    series = archive.series
    fixed = series["stage"] < 3
    assert len(set(series["length_x"][fixed])) == len(set(series["length_y"][fixed])) == 1
    for stage, stress in (("free", 0.0), ("stiffen", 0.0), ("settle", 0.05)):
        row = int(np.searchsorted(series["step"], ends[stage].step)) - 1
        # the last row lies within an interval of the series before the end, at which the criterion 1e-4 F0/a holds
        assert series["stress_x"][row] == pytest.approx(stress, abs=3e-4)
        assert series["stress_y"][row] == pytest.approx(stress, abs=3e-4)
    assert ends["settle"].area < 0.8 * ends["relax"].area


def test_dashpots_wait_until_the_cell_has_stopped(archive: Archive, ends: dict[str, Frame]) -> None:
    """The load compacts the packing by the law alone: what dashpots do later changes nothing to speak of."""
    series = archive.series
    loading = series["stage"] == 5
    assert np.ptp(series["time"][loading]) > 2.0  # --quiet 2: not before the network has been the same for so long
    table = ends["load"].interactions
    np.testing.assert_array_equal(table.tangential[table.in_contact], -1e4 * table.xi_t[table.in_contact])  # the spring alone
    assert ends["load"].area < 0.8 * ends["relax"].area
    assert abs(ends["settle"].area / ends["load"].area - 1.0) < 2e-3


def test_a_stage_of_longer_steps_keeps_its_intervals(whole: Whole, archive: Archive) -> None:
    """Rows and frames count in time, whatever the step of the stage."""
    series = archive.series
    steps = np.diff(series["time"]) / np.diff(series["step"])
    inside = np.diff(series["stage"]) == 0
    for stage in (1, 2, 5):
        of = inside & (series["stage"][1:] == stage)
        expected = read_scene(whole).step_of(STAGES[stage - 1]).step
        np.testing.assert_allclose(steps[of], expected, rtol=1e-9)
        # 0.2 T0, rounded up to a number of checks of 0.02 T0 each at the shortest step
        assert np.all((np.diff(series["time"])[of] > 0.19) & (np.diff(series["time"])[of] < 0.3))


def test_contacts_become_stiffer_in_their_stage(ends: dict[str, Frame]) -> None:
    for stage, stiffness in zip(STAGES, [1e3, 1e3, 1e3, 1e4, 1e4, 1e4], strict=True):
        table = ends[stage].interactions
        np.testing.assert_allclose(table.elastic[table.in_contact] / -table.gap[table.in_contact], stiffness, rtol=1e-9)


def test_energy_account_goes_through_all_stages(archive: Archive) -> None:
    """Where a stage begins nothing appears and nothing is lost; over all the residual is small."""
    series = archive.series
    jumps = np.abs(np.diff(series["residual"]))
    border = np.diff(series["stage"]) > 0
    through = series["lost_viscous"][-1]
    assert border.sum() == 5
    assert jumps[border].max() < 1e-3 * through
    assert np.abs(series["residual"]).max() < 0.01 * through
    assert not series["lost_drag"].any()


def test_result_is_recorded(whole: Whole, wf: Wf) -> None:
    measures = json.loads((whole[0] / "measures.json").read_text())
    assert measures["equilibrated"] is True
    assert set(measures["relaxation"]) == {"relax", "settle"}
    with Archive(whole[0] / "run.h5") as archive:
        done = archive.provenance["relaxation"]
    assert done == "dashpots and quench of the cell 0.5 in relax, free, stiffen, settle"
    assert "during relax" in wf("measure", str(whole[0])).stdout


def test_figures_of_assembling_are_drawn(whole: Whole, packing: Path, wf: Wf, tmp_path: Path) -> None:
    done = wf("plot", str(packing), str(whole[0]), "--figure", "density", "--out", "figures")
    assert done.returncode == 0, done.stderr
    done = wf("plot", str(whole[0]), "--figure", "pores", "--out", "figures", "--format", "png")
    assert done.returncode == 0, done.stderr
    done = wf("plot", str(whole[0]), "--figure", "agitation", "--out", "figures", "--format", "png")
    assert done.returncode == 0, done.stderr
    names = {"density.png", "density.svg", "pores.png", "agitation.png"}
    assert {file.name for file in (tmp_path / "figures").iterdir()} == names
    done = wf("plot", str(packing), "--figure", "agitation")
    assert done.returncode == 2 and "figure 'agitation' shows nothing of" in done.stderr
    done = wf("plot", str(whole[0]), str(packing), "--figure", "agitation", "--out", "mixed")
    assert done.returncode == 2 and "is method1, whose grains start at rest" in done.stderr
    assert wf("plot", str(packing), str(whole[0])).returncode == 2


def test_a_run_without_load_and_dashpots_ends_unpressed(wf: Wf, tmp_path: Path) -> None:
    """The undamped way ends where it is told to, and says that it is not in equilibrium."""
    words = ["--n", "60", "--kappa", "1e3", "--pstar", "0", "--dashpots", "0", "--max-time", "60", "--quiet", "2"]
    done = wf("run", "method2", *words, "--out", "bare", "--json")
    assert done.returncode == 3, done.stderr
    assert json.loads(done.stdout)["equilibrated"] is False
    assert record(tmp_path / "bare")["status"] == "finished"
    with Archive(tmp_path / "bare" / "run.h5") as archive:
        assert set(archive.stages) == {"aggregate"}
        assert archive.provenance["relaxation"] == "none"
        assert not archive.series["lost_drag"].any()


def test_template_runs_with_plain_lmp(tmp_path: Path) -> None:
    shutil.copytree(templates(), tmp_path / "inputs")
    found = engine()
    done = subprocess.run(
        [found.lmp, "-in", "method2.in", "-var", "max_steps", "400", "-screen", "none"],
        cwd=tmp_path / "inputs", env=found.variables(), capture_output=True, text=True, check=False,
    )  # fmt: skip
    log = (tmp_path / "inputs" / "log.lammps").read_text()
    assert done.returncode == 0, log[-500:]
    assert "RESULT stage 1 step 400 equilibrated 0 stopped 0" in log
    residual = read_series(tmp_path / "inputs" / "series.txt")["residual"]
    assert np.abs(residual).max() < 1e-2 * 4.33  # the energy of the gas is the zero of the account


def test_a_run_that_ends_in_the_fixed_cell_says_so(wf: Wf) -> None:
    done = wf("run", "method2", "--n", "60", "--kappa", "1e3", "--d0", "0.01", "--max-time", "0.5", "--out", "short")
    assert done.returncode == 3, done.stderr
    assert "(imposed none, fixed cell)" in done.stdout and "NOT in equilibrium" in done.stdout

"""The public names on a tiny run: what they give is what the commands give, and wrong input is one sentence."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import workflow
from workflow.errors import EnvironmentFault, InputError, WorkflowError

pytestmark = pytest.mark.engine

TINY: dict[str, Any] = {"n": 60, "cohesion": False, "phi0": 0.6, "kappa": 1e3}  # half a second


@pytest.fixture(scope="module")
def packing(tmp_path_factory: pytest.TempPathFactory) -> workflow.Run:
    return workflow.run(workflow.Method1(**TINY), out=tmp_path_factory.mktemp("api") / "run")


def test_public_names_are_those_that_the_package_lists() -> None:
    from workflow import api

    assert workflow.__all__ == api.__all__
    assert set(workflow.__all__) <= set(dir(workflow))
    for name in workflow.__all__:
        assert getattr(workflow, name).__doc__, f"{name} has no docstring"
    with pytest.raises(AttributeError, match="no attribute 'runn'"):
        workflow.runn  # noqa: B018


def test_import_loads_neither_numpy_nor_any_room() -> None:
    """`wf --version` and the help of a command must not wait for what they do not use."""
    asked = "import sys, workflow; print([name for name in sys.modules if name == 'numpy' or name.startswith('workflow.')])"
    assert subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True).stdout.strip() == "[]"


def test_package_says_that_it_is_typed() -> None:
    assert (Path(workflow.__file__).parent / "py.typed").is_file()


def test_run_gives_scene_frames_series_and_the_measures_of_the_command(packing: workflow.Run) -> None:
    assert packing.status == "finished" and packing.scene.mu == 0.5
    assert packing.archive.is_file()
    frames, series = packing.frames, packing.series
    assert frames[-1].position.shape == (60, 2)
    assert frames[-1].time == pytest.approx(series["time"][-1], abs=packing.scene.series_interval)
    stored = json.loads((packing.directory / "measures.json").read_text())
    stored.pop("checksum")
    assert json.loads(json.dumps(packing.measures)) == stored


def test_open_finds_the_same_run(packing: workflow.Run) -> None:
    assert workflow.open(str(packing.directory)) == packing


def test_measures_of_a_path_and_of_a_frame_under_its_law_are_those_of_the_run(packing: workflow.Run) -> None:
    found = packing.measures
    assert workflow.measure(packing.directory, -1) == found
    assert "rigidity" not in workflow.measure(packing, groups=["none"])
    frame, scene = packing.frames[-1], packing.scene
    assert isinstance(scene, workflow.Method1)
    law = scene.law_of(frame.stage)
    bare = workflow.measure(frame, law=law, force_unit=scene.force_unit)
    assert all(bare[name] == found[name] for name in ("coordination", "rigidity", "elastic_moduli", "forces"))


def test_a_frame_without_a_law_has_no_number_that_needs_friction(packing: workflow.Run) -> None:
    from dataclasses import replace

    frame = packing.frames[-1]
    smooth = replace(frame, interactions=replace(frame.interactions, tangential=np.zeros(len(frame.interactions))))
    found = workflow.measure(smooth, groups=["rigidity", "holes"])
    assert "friction" in found["rigidity"]["error"] and found["holes"]["number"] > 0


def test_plot_and_report_write_the_files_that_they_name(packing: workflow.Run, tmp_path: Path) -> None:
    assert workflow.plot(packing, "distribution", tmp_path / "n.svg").read_bytes().startswith(b"<?xml")
    packing.archive.unlink()  # it is made again, also for what is drawn of the run and not of a frame
    assert workflow.plot(packing, "history", tmp_path / "history.png").stat().st_size > 1000
    page = workflow.report(packing, tmp_path / "page.html")
    assert page.read_text(encoding="utf-8").lower().startswith("<!doctype html>")


def test_sweep_computes_each_combination_once(tmp_path: Path) -> None:
    grid = {"mu": np.array([0.2, 0.4])}
    runs = workflow.sweep("method1", grid, seeds=[3], out=tmp_path / "study", **TINY)
    assert [(run.scene.mu, run.scene.seed, run.status) for run in runs] == [(0.2, 3, "finished"), (0.4, 3, "finished")]
    finished = [run.archive.stat().st_mtime_ns for run in runs]
    again = workflow.sweep("method1", grid, seeds=[3], out=tmp_path / "study", **TINY)
    assert again == runs and [run.archive.stat().st_mtime_ns for run in again] == finished


def test_reprs_are_short_and_have_units(packing: workflow.Run) -> None:
    frame = packing.frames[-1]
    assert repr(packing.scene) == "Method1(n=60, phi0=0.6, cohesion=False, kappa=1000.0)"
    assert eval(repr(packing.scene), {"Method1": workflow.Method1}) == packing.scene
    assert re.fullmatch(rf"<Run '{packing.directory}': method1, seed 1, N = 60, finished at t = [\d.]+ T0>", repr(packing))
    assert re.fullmatch(r"<Frame '\w+': t = [\d.]+ T0, step \d+, 60 grains, \d+ interactions, cell [\d.]+ x [\d.]+ a>",
                        repr(frame))  # fmt: skip
    assert repr(frame.interactions).startswith(f"<Interactions: {len(frame.interactions)} pairs, ")
    assert repr(packing.frames).startswith(f"<Frames: {len(packing.frames)} in ")


@pytest.mark.parametrize(
    "given", [{"mu": 0.3}, {"phi0": 0.13, "n": 400}, {"as_printed": True}, {"rolling": True, "cell": "strain"}], ids=str
)
@pytest.mark.parametrize("kind", [workflow.Method1, workflow.Method2, workflow.Consolidation])
def test_repr_of_a_scene_is_the_call_that_makes_it(kind: type, given: dict[str, Any]) -> None:
    scene = kind(**given)
    assert set(given) <= set(scene.chosen()) and eval(repr(scene), {kind.__name__: kind}) == scene
    assert "friction coefficient" in scene._repr_html_()


def test_interactions_and_grains_are_pandas_tables_on_request(packing: workflow.Run) -> None:
    frame = packing.frames[-1]
    pairs, grains = frame.interactions.to_pandas(), frame.to_pandas()
    np.testing.assert_array_equal(pairs["normal_force"], frame.interactions.normal_force)
    np.testing.assert_array_equal(pairs["branch_y"], frame.interactions.branch[:, 1])
    np.testing.assert_array_equal(grains["position_x"], frame.position[:, 0])
    assert len(grains) == 60 and pairs["i"].max() < 60 and pairs["in_contact"].dtype == bool


def test_without_pandas_a_sentence_says_how_to_get_it(packing: workflow.Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(EnvironmentFault, match="pip install pandas"):
        packing.frames[-1].interactions.to_pandas()


def test_a_notebook_shows_picture_and_measures_of_a_run_and_nothing_is_written(packing: workflow.Run) -> None:
    before = sorted(packing.directory.iterdir())
    html = packing._repr_html_()
    assert 'src="data:image/png;base64,iVBOR' in html and f"{packing.measures['solid_fraction']:.4f}" in html
    assert sorted(packing.directory.iterdir()) == before


def test_a_figure_is_a_path_that_a_notebook_shows(packing: workflow.Run, tmp_path: Path) -> None:
    for name, kind in {"a.svg": "image/svg+xml", "a.png": "image/png"}.items():
        picture = packing.plot("distribution", tmp_path / name)
        assert picture == tmp_path / name and set(picture._repr_mimebundle_()[0]) == {"text/plain", kind}
    assert set(packing.plot("distribution", tmp_path / "a.pdf")._repr_mimebundle_()[0]) == {"text/plain"}


def test_every_dataset_of_a_run_has_a_known_unit(packing: workflow.Run) -> None:
    found: dict[str, str] = {}
    with h5py.File(packing.archive) as file:
        file.visititems(lambda name, item: found.update({name: item.attrs["units"].decode()} if hasattr(item, "dtype") else {}))
    assert len(found) > 50 and "unknown" not in found.values()
    assert found["observables/stress_x/value"] == "P" and found["contacts/tangential"] == "a P"


WRONG: dict[str, tuple[Callable[[workflow.Run], object], str]] = {
    "scene": (lambda run: workflow.run("metod1"), "'metod1' is neither a scene nor a file"),
    "parameter": (lambda run: workflow.run("method1", nn=3), "unknown parameter 'nn'; did you mean n"),
    "value": (lambda run: workflow.run("method1", mu=-1), "mu"),
    "parameter beside a scene": (lambda run: workflow.run(run.scene, mu=0.3), r"write Method1\(mu=...\)"),
    "directory in use": (lambda run: workflow.run("method1", out=run.directory), "is not empty"),
    "no run": (lambda run: workflow.open("nowhere"), "'nowhere' does not exist"),
    "no source": (lambda run: workflow.measure(3), "3 is no run"),  # type: ignore[arg-type]
    "frame": (lambda run: workflow.measure(run, 99), "frame 99 does not exist"),
    "group": (lambda run: workflow.measure(run, groups=["hoels"]), "'hoels' is no group"),
    "law of a run": (lambda run: workflow.measure(run, law=workflow.ContactLaw(1.0)), "a run has its own"),
    "figure": (lambda run: workflow.plot(run, "forcs"), "figure 'forcs' is not known"),
    "several figures": (lambda run: workflow.plot(run, "forces,history"), "figure 'forces,history' is not known"),
    "figure of a heap": (lambda run: workflow.plot(run, "avalanche"), "'avalanche' shows nothing of"),
    "format": (lambda run: workflow.plot(run, out="a.xyz"), "'a.xyz' has no format"),
    "page": (lambda run: workflow.report(run, "a.txt"), "a.txt'? is not allowed"),
    "grid": (lambda run: workflow.sweep("method1", {"mu": 0.3}), "must be a list"),  # type: ignore[dict-item]
    "jobs": (lambda run: workflow.sweep("method1", {"mu": [0.3]}, jobs=0), "at least 1"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input_is_one_sentence_and_nothing_is_written(
    name: str, packing: workflow.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    before = sorted(packing.directory.iterdir())
    with pytest.raises(InputError, match=WRONG[name][1]) as fault:
        WRONG[name][0](packing)
    assert issubclass(fault.type, WorkflowError | ValueError) and "\n" not in str(fault.value)
    assert not list(tmp_path.iterdir()) and sorted(packing.directory.iterdir()) == before


def test_program_of_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    page = Path(__file__).resolve().parents[3] / "docs" / "python.md"
    program = page.read_text(encoding="utf-8").split("```python\n")[1].split("```")[0]
    monkeypatch.chdir(tmp_path)
    exec(compile(program.replace("n=400", "n=60, phi0=0.6, kappa=1e3"), page.name, "exec"), {})
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith("finished 0.") and len(printed) == 7
    assert {"dense", "dense.html", "forces.svg", "friction"} <= {path.name for path in tmp_path.iterdir()}

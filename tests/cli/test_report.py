"""`wf report`: what it takes, where it writes, what it says."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from wf_process import SLOW, Wf, call

from workflow.archive.read import Archive
from workflow.cli.main import main
from workflow.reports.page_data import unpacked


def data(page: Path) -> Any:
    text = page.read_text(encoding="utf-8")
    start = text.index('id="data">') + len('id="data">')
    return json.loads(text[start : text.index("</script>", start)])


def test_page_of_a_run_lies_in_its_directory(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = {path.name: path.read_bytes() for path in copy.iterdir()}
    assert main(["report", str(copy)]) == 0
    page = copy / "report.html"
    assert capsys.readouterr().out == f"{page}\n"
    assert {path.name: path.read_bytes() for path in copy.iterdir() if path != page} == before
    run = data(page)["runs"][0]
    with Archive(copy / "run.h5") as archive:
        frame, series = archive.frame(-1), archive.series
    np.testing.assert_array_equal(unpacked(run["network"]["arrays"]["gap"]), np.float32(frame.interactions.gap))
    np.testing.assert_array_equal(unpacked(run["arrays"]["net_force"]), np.float32(series["net_force"]))
    text, record = unescape(page.read_text(encoding="utf-8")), json.loads((copy / "run.json").read_text())
    for word in (record["command"], record["digest"], record["hashes"]["deck.in"], (copy / "scene.toml").read_text()):
        assert word in text


def test_the_chosen_frame_is_shown(packing: Path, tmp_path: Path) -> None:
    page = tmp_path / "first.html"
    assert main(["report", str(packing), "--frame", "0", "--out", str(page)]) == 0
    with Archive(packing / "run.h5") as archive:
        first = archive.frame(0)
    np.testing.assert_array_equal(unpacked(data(page)["runs"][0]["network"]["arrays"]["id"]), first.ids)
    assert f"Frame 1 of 3, stage {first.stage}, t = 0" in page.read_text(encoding="utf-8")


def test_a_run_without_results_stands_on_the_page_of_its_folder(packing: Path, cohesive: Path, tmp_path: Path, wf: Wf) -> None:
    for name, run in (("a/1", packing), ("a/2", cohesive)):
        shutil.copytree(run, tmp_path / name)
    assert wf("deck", "method1", "--n", "60", "--out", "a/3").returncode == 0
    done = wf("report", "a")
    assert (done.returncode, done.stdout) == (0, "a/report.html\n"), done.stderr
    page = tmp_path / "a" / "report.html"
    assert [run["name"] for run in data(page)["runs"]] == ["1", "2"]
    assert "has no results yet" in page.read_text(encoding="utf-8")
    alone = wf("report", "a/3")
    assert alone.returncode == 1 and "has no results yet" in alone.stderr
    assert not (tmp_path / "a" / "3" / "report.html").exists()


def test_names_tell_the_runs_apart(packing: Path, tmp_path: Path, wf: Wf) -> None:
    for name in ("soft/1", "hard/1"):
        shutil.copytree(packing, tmp_path / name)
    assert wf("report", "soft/1", "hard/1").stdout == "report.html\n"
    assert [run["name"] for run in data(tmp_path / "report.html")["runs"]] == ["soft/1", "hard/1"]


def test_interrupted_run_shows_how_far_it_came(running: Callable[..., Any], wf: Wf, tmp_path: Path) -> None:
    run = running(*SLOW)
    run.wait_for_rows(3)
    run.process.send_signal(2)
    run.process.communicate(timeout=60)
    assert wf("report", "slow").returncode == 0
    text = (tmp_path / "slow" / "report.html").read_text(encoding="utf-8")
    assert "The run is interrupted: this is how far it came. Frame " in text and "not in equilibrium" in text


def test_page_of_a_heap_holds_its_figures(tmp_path: Path) -> None:
    done = call("run", "heap", "--grains", "40", "--drop-height", "15", "--out", "run", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert main(["report", str(tmp_path / "run")]) == 0
    run = data(tmp_path / "run" / "report.html")["runs"][0]
    net = {name: unpacked(array) for name, array in run["network"]["arrays"].items()}
    measures = json.loads((tmp_path / "run" / "measures.json").read_text())
    assert (net["mark"] == 0).sum() == measures["grains_in_heap"]
    assert (net["mark"] == 2).sum() == len(measures["base_force_profile"]["x"])
    assert set(net["kind"][net["normal"] > 1e-3]) == {0}  # a pair within reach presses, however far apart
    base = next(chart for chart in run["charts"] if chart["title"] == "force on the base")
    np.testing.assert_array_equal(
        unpacked(run["arrays"][base["lines"][0]["y"]]), np.float32(measures["base_force_profile"]["force"])
    )


def test_dump_of_another_program_has_a_page(packing: Path, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    words = ["--contacts", packing / "contacts.dump", "--kn", "1000", "--force-unit", "1", "--out", page]
    assert main(["report", *map(str, (packing / "grains.dump", *words))]) == 0
    with Archive(packing / "run.h5") as archive:
        table = archive.frame(-1).interactions
    normal = unpacked(data(page)["runs"][0]["network"]["arrays"]["normal"])
    np.testing.assert_array_equal(np.sort(normal), np.sort(np.float32(table.normal_force)))


MISUSE = {
    "not there": (["absent"], ["'absent'", "does not exist"]),
    "no run": (["empty"], ["'empty'", "no run directory"]),
    "no page": (["copy", "--out", "page.pdf"], ["--out page.pdf", ".html"]),
    "a directory": (["copy", "--out", "empty"], ["--out empty", ".html"]),
    "below a file": (["copy", "--out", "note.txt/page.html"], ["'note.txt'", "--out"]),
    "frame": (["copy", "--frame", "77"], ["frame 77 does not exist"]),
}


@pytest.mark.parametrize("case", MISUSE)
def test_misuse_is_named_and_writes_nothing(
    case: str, copy: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(copy.parent)
    (copy.parent / "empty").mkdir()
    (copy.parent / "note.txt").write_text("mine")
    before = sorted(copy.parent.rglob("*"))
    words, expected = MISUSE[case]
    assert main(["report", *words]) == 2
    text = capsys.readouterr()
    assert text.out == "" and not [word for word in expected if word not in text.err], text.err
    assert sorted(copy.parent.rglob("*")) == before


def test_damaged_measures_are_measured_anew(copy: Path) -> None:
    assert main(["report", str(copy)]) == 0
    page, stored = (copy / "report.html").read_text(), (copy / "measures.json").read_text()
    for damage in ("{", stored.replace('"coordination": ', '"coordination": 1', 1)):
        (copy / "measures.json").write_text(damage)
        assert main(["report", str(copy)]) == 0
        assert (copy / "report.html").read_text() == page

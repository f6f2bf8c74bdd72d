"""`wf sweep` as a user meets it: to its end, interrupted, killed, failing, twice at once."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from wf_process import WF, kill, record

from workflow.campaign.study import Study
from workflow.campaign.sweep import read_sweep
from workflow.cli.main import main

Start = Callable[..., "subprocess.Popen[str]"]
FIXED = 'scene = "method1"\n[fixed]\ncohesion = false\nhold = 1\n'
SMALL = FIXED + "n = 60\nkappa = 1e3\n"
LONG = FIXED + "n = 300\nkappa = 1e5\ncheckpoint_interval = 1\n"  # some two seconds


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Starts `wf WORDS` in the background."""
    begun: list[subprocess.Popen[str]] = []

    def go(*words: object) -> subprocess.Popen[str]:
        command = [*WF, *map(str, words)]
        begun.append(subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                      start_new_session=True))  # fmt: skip
        return begun[-1]

    yield go
    for process in begun:
        kill(process.pid)
        process.communicate()


def standing(folder: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    """The study in `wf status --json`."""
    capsys.readouterr()
    assert main(["status", str(folder), "--json"]) == 0
    return dict(json.loads(capsys.readouterr().out)[0])


def wait_for_rows(folder: Path, rows: int = 10) -> Path:
    """The first run of a study with so many rows of its time series."""
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline:
        for series in folder.glob("points/*/series.txt"):
            if len(series.read_text().splitlines()) > rows:
                return series.parent
        time.sleep(0.02)
    raise AssertionError("no run of the study gets going")


def test_study_is_computed_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("study.toml").write_text(SMALL + "[grid]\nmu = [0.15, 0.5]\n")
    assert main(["sweep", "study.toml", "--dry-run", "--out", "study"]) == 0
    assert "2 points, 0 done" in capsys.readouterr().out
    assert not Path("study").exists()
    assert main(["sweep", "study.toml", "--out", "study", "--jobs", "2"]) == 0
    said = capsys.readouterr()
    assert "2 of 2 points done" in said.out
    assert "done mu=0.15" in said.err
    row = standing(Path("study"), capsys)
    assert row["counts"]["done"] == 2
    assert row["core_hours_left"] == 0.0
    runs = sorted(Path("study/points").iterdir())
    for path in runs:
        assert record(path)["digest"].startswith(path.name)
    assert {json.loads((path / "measures.json").read_text())["equilibrated"] for path in runs} == {True}
    with open("study/results.csv", newline="") as file:
        table = list(csv.DictReader(file))
    assert [row["mu"] for row in table] == ["0.15", "0.5"]
    for row in table:
        measures = json.loads(Path("study/points", row["name"], "measures.json").read_text())
        assert float(row["solid_fraction"]) == measures["solid_fraction"]
        assert float(row["unbalanced_force.force"]) == measures["unbalanced_force"]["force"]
    before = [(path / "run.json").stat().st_mtime_ns for path in runs]
    Path("study.toml").write_text(SMALL + "[grid]\nmu = [0.5, 0.15, 0.3]\n")  # one more point
    assert main(["sweep", "study.toml", "--out", "study"]) == 0
    said = capsys.readouterr()
    assert "3 of 3 points done" in said.out
    assert said.err.count("done mu=") == 1
    assert [(path / "run.json").stat().st_mtime_ns for path in runs] == before
    assert main(["sweep", "study.toml", "--out", "elsewhere", "--adopt", "study"]) == 0
    assert "adopted 3 finished runs" in capsys.readouterr().err
    assert [path.is_symlink() for path in Path("elsewhere/points").iterdir()] == [True] * 3


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["in the foreground", "in the background"])
def test_a_study_goes_on_after_interrupt_and_kill(
    number: signal.Signals, tmp_path: Path, start: Start, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "study.toml").write_text(LONG)
    before = signal.getsignal(signal.SIGINT)
    if number == signal.SIGTERM:  # a shell starts its jobs in the background so, and theirs inherit it
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        first = start("sweep", "study.toml", "--out", "study")
    finally:
        signal.signal(signal.SIGINT, before)
    run = wait_for_rows(tmp_path / "study")
    assert standing(tmp_path / "study", capsys)["counts"]["running"] == 1
    first.send_signal(number)
    _, text = first.communicate(timeout=60)
    assert first.returncode == 130
    assert "Traceback" not in text
    assert "the same command continues" in text
    assert record(run)["status"] == "interrupted"
    seconds = record(run)["seconds"]
    second = start("sweep", "study.toml", "--out", "study")
    wait_for_rows(tmp_path / "study", len((run / "series.txt").read_text().splitlines()) + 5)
    os.killpg(second.pid, signal.SIGKILL)  # the power cut: nothing can be recorded
    second.wait()
    deadline = time.monotonic() + 10.0
    while standing(tmp_path / "study", capsys)["counts"]["interrupted"] == 0:
        assert time.monotonic() < deadline, "the run goes on without its wf"
        time.sleep(0.05)
    assert main(["sweep", str(tmp_path / "study.toml"), "--out", str(tmp_path / "study")]) == 0
    assert record(run)["status"] == "finished"
    assert record(run)["seconds"] > seconds  # of all its parts
    assert "Reading restart file" in (run / "log.lammps").read_text()


def test_failure_is_recorded_and_retried_only_when_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Equal discs cannot be added at random at Phi = 0.6; the other point is none the worse for it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("workflow.scene.placement._ROUNDS_WITHOUT_SUCCESS", 3)
    Path("study.toml").write_text(SMALL + "smallest = 1\ninitial = 'random_addition'\n[grid]\nphi0 = [0.6, 0.36]\n")
    assert main(["sweep", "study.toml", "--out", "study"]) == 1
    assert "1 points failed" in capsys.readouterr().err
    row = standing(Path("study"), capsys)
    assert row["counts"]["done"] == 1
    (failed,) = [one for one in row["points"] if one["status"] == "failed"]
    assert "initial solid fraction 0.6 is too high" in failed["reason"]
    path = Path("study/points") / failed["name"] / "run.json"
    before = path.stat().st_mtime_ns
    assert main(["sweep", "study.toml", "--out", "study"]) == 1
    assert path.stat().st_mtime_ns == before
    assert main(["sweep", "study.toml", "--out", "study", "--retry"]) == 1
    assert path.stat().st_mtime_ns > before


def test_a_job_that_is_killed_is_a_failure(tmp_path: Path, start: Start) -> None:
    (tmp_path / "study.toml").write_text(LONG)
    sweep = start("sweep", "study.toml", "--out", "study")
    run = wait_for_rows(tmp_path / "study")
    kill(record(run)["pid"])  # out of memory takes the `wf` of the point
    _, text = sweep.communicate(timeout=60)
    assert sweep.returncode == 1
    assert "wf was killed by signal 9" in text
    assert record(run)["status"] == "failed"
    assert main(["sweep", str(tmp_path / "study.toml"), "--out", str(tmp_path / "study"), "--retry"]) == 0
    assert record(run)["status"] == "finished"


def test_two_processes_share_a_study(tmp_path: Path, start: Start) -> None:
    (tmp_path / "study.toml").write_text("seeds = 3\n" + SMALL)
    both = [start("sweep", "study.toml", "--out", "study") for _ in range(2)]
    texts = [process.communicate(timeout=110)[1] for process in both]
    assert [process.returncode for process in both] == [0, 0], texts
    assert sum(text.count("done seed=") for text in texts) == 3
    for path in (tmp_path / "study" / "points").iterdir():
        assert record(path)["status"] == "finished"
        assert (path / "log.lammps").read_text().count("\nRESULT ") == 1


def test_a_run_that_a_lost_machine_left_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its record says running, elsewhere; but nobody holds its lock."""
    monkeypatch.chdir(tmp_path)
    Path("study.toml").write_text(SMALL)
    study = Study(Path("study"), read_sweep(Path("study.toml")))
    study.save()
    run = study.prepare(study.points[0])
    run.record(status="running", host="node7", pid=1, started="2026-01-01T00:00:00Z", ranks=1)
    assert study.standing(study.points[0]).reason == "on node7"
    with run.lock():
        assert main(["sweep", "study.toml", "--out", "study"]) == 0  # somebody works on it
        assert record(run.path)["status"] == "running"
    assert main(["sweep", "study.toml", "--out", "study"]) == 0
    assert record(run.path)["status"] == "finished"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["sweep", "none.toml"], "'none.toml' cannot be read"),
        (["sweep", "study.toml", "--jobs", "0"], "--jobs 0 is not allowed"),
        (["sweep", "study.toml", "--adopt", "none", "--out", "study"], "'none' is no directory"),
    ],
)
def test_misuse_of_sweep_is_named(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("study.toml").write_text(SMALL)
    assert main(words) == 2
    assert said in capsys.readouterr().err

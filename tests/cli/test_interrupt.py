"""Runs that are stopped: by the interrupt key, by kill, by a second `wf`; and that go on afterwards."""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from wf_process import ENDLESS, SLOW, Running, Wf, alive, kill, record, steps

from workflow.archive.read import Archive
from workflow.cli.main import main
from workflow.data.series import read_series

Start = Callable[..., Running]


def is_whole(directory: Path) -> None:
    """The run is finished and its archive has one history without gap or repetition."""
    assert record(directory)["status"] == "finished"
    with Archive(directory / "run.h5") as archive:
        series, frames = archive.series, list(archive.frames)
    assert np.all(np.diff(series["step"]) > 0)
    assert len(set(np.diff(series["step"]))) <= 2  # equal spacing but for the row of a stop
    assert np.all(np.diff(series["time"]) > 0)
    assert frames[0].step == 0
    assert np.all(np.diff([frame.step for frame in frames]) >= 0)
    assert frames[-1].stage in ("compress", "settle")
    assert json.loads((directory / "measures.json").read_text())["equilibrated"] is True


def continued(directory: Path) -> bool:
    """The engine started from a checkpoint, not from the beginning."""
    return "Reading restart file" in (directory / "log.lammps").read_text()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=lambda number: number.name)
def test_an_interrupted_run_resumes_to_its_end(number: signal.Signals, running: Start, wf: Wf) -> None:
    run = running(*SLOW)
    run.wait_for_rows(10)  # two time units: behind the first checkpoint
    begun = time.monotonic()
    run.process.send_signal(number)
    _, text = run.process.communicate(timeout=30)
    assert time.monotonic() - begun < 10.0  # the engine stops at the next check, the archive follows
    assert run.process.returncode == 130
    assert "wf resume slow" in text
    assert "Traceback" not in text
    assert record(run.directory)["status"] == "interrupted"
    assert json.loads(wf("status", "slow", "--json").stdout)[0]["status"] == "interrupted"
    assert not json.loads(wf("measure", "slow", "--json").stdout)["equilibrated"]
    before = read_series(run.directory / "series.txt")
    done = wf("resume", "slow")
    assert done.returncode == 0, done.stderr
    is_whole(run.directory)
    after = read_series(run.directory / "series.txt")
    rows = len(before["step"])
    assert after["solid_fraction"][:rows].tolist() == before["solid_fraction"].tolist()
    assert continued(run.directory)


@pytest.mark.parametrize("ranks", ["1", "2"])
@pytest.mark.parametrize("whom", ["wf and engine", "wf twice"])
def test_engine_that_is_ended_at_once_is_interrupted(whom: str, ranks: str, running: Start, wf: Wf) -> None:
    """A scheduler or the system's shutdown tells every process to end, a second Control-C the engine: no failure of the run."""
    run = running(*SLOW, "--ranks", ranks)
    run.wait_for_rows(10)  # two time units: behind the first checkpoint
    for pid in (*run.engine(), run.process.pid) if whom == "wf and engine" else (run.process.pid,) * 2:
        os.kill(pid, signal.SIGTERM)
        time.sleep(0.005)  # two at the same moment are one
    _, text = run.process.communicate(timeout=30)
    assert run.process.returncode == 130, text
    assert "wf resume slow" in text
    assert "Traceback" not in text
    assert record(run.directory)["status"] == "interrupted"
    done = wf("resume", "slow")
    assert done.returncode == 0, done.stderr
    is_whole(run.directory)
    assert continued(run.directory)


def test_a_run_whose_processes_vanish_resumes_to_its_end(running: Start, wf: Wf) -> None:
    """Power cut: `wf` and engine vanish at once, in the middle of a write for all they know."""
    run = running(*SLOW)
    run.wait_for_rows(10)  # two time units: behind the first checkpoint
    stop_everything(run)
    with open(run.directory / "series.txt", "a") as series:
        series.write("12")  # half a row
    with open(run.directory / "grains.dump", "ab") as dump:
        dump.write(b"ITEM: TIME\n7.5\nITEM: TIMEST")  # half a head
    row = json.loads(wf("status", "slow", "--json").stdout)[0]
    assert row["status"] == "interrupted"
    assert "killed" in row["reason"]
    done = wf("resume", "slow")
    assert done.returncode == 0, done.stderr
    is_whole(run.directory)
    assert continued(run.directory)


def stop_everything(run: Running) -> None:
    engines = run.engine()
    assert engines
    for pid in (run.process.pid, *engines):
        kill(pid)
    run.process.wait(timeout=5)


def test_kill_before_the_first_checkpoint_starts_over(running: Start, wf: Wf) -> None:
    run = running(*SLOW, "--checkpoint-interval", "1e4")
    run.wait_for_rows(2)
    stop_everything(run)
    done = wf("resume", "slow")
    assert done.returncode == 0, done.stderr
    assert steps(run.directory)[0] == 0
    assert np.all(np.diff(steps(run.directory)) > 0)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM], ids=lambda number: number.name)
def test_engine_does_not_outlive_wf(number: signal.Signals, running: Start) -> None:
    """Otherwise `wf resume` would start a second engine that writes to the same files."""
    run = running(*ENDLESS)
    run.wait_for_rows(2)
    engines = run.engine()
    assert engines
    try:
        os.killpg(run.process.pid, number)
        run.process.wait(timeout=10)
        deadline = time.monotonic() + 3.0
        while any(map(alive, engines)) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert not any(map(alive, engines)), "the engine runs on without its wf"
    finally:
        for pid in engines:
            kill(pid)


def test_second_wf_is_turned_away(running: Start, wf: Wf) -> None:
    run = running(*ENDLESS)
    run.wait_for_rows(2)
    row = json.loads(wf("status", "slow", "--json").stdout)[0]
    assert row["status"] == "running"
    assert "Phi 0." in row["line"] and row["equilibrium"] is None
    assert (row["stage"], row["stage_number"], row["stages"]) == ("compress", 1, 2) and row["time"] > 0.0
    assert row["remaining"] is None or (row["remaining"] > 0.0 and 0.0 < row["progress"] < 1.0)
    second = wf("resume", "slow")
    assert second.returncode == 1
    assert "'slow' is in use" in second.stderr
    third = wf("run", *ENDLESS, "--out", "slow")
    assert third.returncode == 2
    assert "'slow' exists" in third.stderr
    assert run.process.poll() is None
    engines = run.engine()
    assert engines
    for pid in engines:
        assert alive(pid), pid
    assert record(run.directory)["status"] == "running"


def test_killed_engine_is_reported(running: Start, wf: Wf) -> None:
    """Out of memory kills the engine, not `wf`."""
    run = running(*ENDLESS)
    run.wait_for_rows(3)
    for pid in run.engine():
        kill(pid)
    _, text = run.process.communicate(timeout=10)
    assert run.process.returncode == 1
    assert "killed by signal 9" in text
    assert "wf resume" in text
    assert record(run.directory)["status"] == "failed"
    assert json.loads(wf("status", "slow", "--json").stdout)[0]["status"] == "failed"


def test_measuring_a_killed_run_leaves_it_to_be_resumed(copy: Path) -> None:
    """Its dumps can be looked at, but only a deck that came to its end is finished."""
    (copy / "run.h5").unlink()
    log = (copy / "log.lammps").read_text()
    (copy / "log.lammps").write_text(log[: log.rindex("RESULT ")])
    state = json.loads((copy / "run.json").read_text())
    (copy / "run.json").write_text(json.dumps({**state, "status": "interrupted"}))
    assert main(["measure", str(copy)]) == 0
    assert json.loads((copy / "run.json").read_text())["status"] == "interrupted"

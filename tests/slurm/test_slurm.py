"""A real Slurm computes real studies: arrays, the end of a job's time, a node that fails, a cancelled job, a refusal."""

from __future__ import annotations

import filecmp
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from controller import Slurm
from patience import until

from workflow.runs.checkpoint import step_of
from workflow.runs.installation import engine

pytestmark = pytest.mark.slurm
QUICK = 'scene = "method1"\n[fixed]\ncohesion = false\nhold = 1\nn = 60\nkappa = 1e3\n'
ENDLESS = 'scene = "method1"\n[fixed]\nn = 1000\nmax_time = 5000\nhold = 4000\ncheckpoint_interval = 0.5\n'
Wf = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture(scope="module")
def slurm() -> Iterator[Slurm]:
    """One for all tests; its sockets need a short path."""
    folder = Path(tempfile.mkdtemp(prefix="slurm"))
    started = Slurm(folder)
    yield started
    started.end()
    shutil.rmtree(folder)


@pytest.fixture(autouse=True)
def account(slurm: Slurm, tmp_path: Path) -> Iterator[None]:
    """What was said, for a test that fails; and no job of a test is left to the next."""
    yield
    print(slurm.jobs(), (slurm.folder / "slurmd.log").read_text()[-3000:])
    for path in sorted(tmp_path.rglob("*.out")):
        print(path.name, path.read_text())
    slurm.run("scancel", "--user", "root")


@pytest.fixture
def wf(slurm: Slurm, tmp_path: Path) -> Wf:
    """`wf WORDS` of a user of this Slurm."""

    def call(*words: object) -> subprocess.CompletedProcess[str]:
        done = subprocess.run([sys.executable, "-m", "workflow.cli.main", *map(str, words)], cwd=tmp_path, capture_output=True,
                              text=True, env=slurm.environment, check=False)  # fmt: skip
        assert "Traceback" not in done.stderr, done.stderr
        return done

    return call


def status(wf: Wf, study: str) -> dict[str, Any]:
    """The study in `wf status --json`."""
    done = wf("status", study, "--json")
    assert done.returncode == 0, done.stderr
    row = dict(json.loads(done.stdout)[0])
    assert row["scheduler"] is None
    return row


def one(wf: Wf, study: str) -> dict[str, Any]:
    """The only point of a study."""
    (point,) = status(wf, study)["points"]
    return dict(point)


def test_an_array_computes_every_point_once(slurm: Slurm, wf: Wf, tmp_path: Path) -> None:
    """Five points in three tasks; bit for bit what they are without Slurm."""
    (tmp_path / "study.toml").write_text(QUICK + "[grid]\nmu = [0.1, 0.2, 0.3, 0.4, 0.5]\n")
    (tmp_path / "profile.toml").write_text('most_tasks = 3\ntime = "00:10:00"\ndirectives = ["--nice=5"]\n')
    folder = 'it\'s a $(touch broken) "study"'
    words = ["sweep", "study.toml", "--out", folder, "--scheduler", "slurm", "--profile", "profile.toml"]
    done = wf(*words)
    assert done.returncode == 0, done.stderr
    assert "submitted 5 points as 3 tasks of job" in done.stderr
    again = wf(*words)
    assert "nothing to submit" in again.stderr
    until(lambda: status(wf, folder)["counts"]["done"] == 5, "five points are done")
    until(lambda: (tmp_path / folder / "results.csv").is_file(), "the last task writes the table")
    assert len((tmp_path / folder / "results.csv").read_text().splitlines()) == 6
    assert not any(tmp_path.rglob("broken"))
    said = "".join(path.read_text() for path in (tmp_path / folder).glob("jobs/0001/*.out"))
    assert said.count("done ") == 5
    assert "nothing to submit" in wf(*words).stderr
    assert wf("sweep", "study.toml", "--out", "here").returncode == 0
    for point in (tmp_path / "here" / "points").iterdir():
        for name in ("grains.dump", "contacts.dump", "series.txt"):
            assert filecmp.cmp(point / name, tmp_path / folder / "points" / point.name / name, shallow=False), (point, name)


def test_a_run_on_two_ranks_finishes_under_slurm(slurm: Slurm, wf: Wf, tmp_path: Path) -> None:
    """Few steps: two ranks that share a core wait for each other."""
    (tmp_path / "study.toml").write_text(QUICK + "max_time = 0.05\n")
    assert wf("sweep", "study.toml", "--out", "s", "--scheduler", "slurm", "--ranks", "2", "--time", "00:10:00").returncode == 0
    until(lambda: status(wf, "s")["counts"]["done"] == 1, "the point is done")
    (run,) = (tmp_path / "s" / "points").iterdir()
    assert json.loads((run / "run.json").read_text())["ranks"] == 2
    assert "1 by 2 by 1 MPI processor grid" in (text := (run / "log.lammps").read_text()) or "2 by 1 by 1" in text


def test_time_node_and_cancel(slurm: Slurm, wf: Wf, tmp_path: Path) -> None:
    """One run through all that can befall it; it never begins anew."""
    (tmp_path / "study.toml").write_text(ENDLESS)
    profile = tmp_path / "profile.toml"
    profile.write_text('time = "00:02:00"\nmargin = 75\n')  # Slurm counts minutes; it warns the job then, or earlier
    words = ["sweep", "study.toml", "--out", "s", "--profile", "profile.toml"]
    done = wf(*words)
    assert "submitted 1 points as 1 tasks of job" in done.stderr
    number = done.stderr.split("of job ")[1].split(";")[0]
    task, run = f"{number}_0", tmp_path / "s" / "points" / one(wf, "s")["name"]

    def step() -> int:
        """Of the last row of the time series."""
        series = run / "series.txt"
        rows = series.read_text().splitlines() if series.is_file() else []
        return next((int(row.split()[0]) for row in reversed(rows) if row[:1].isdigit()), 0)

    def goes_on(from_: int) -> bool:
        """It has come further; what Slurm queued once more meanwhile, because its time was over again, is let go."""
        if slurm.state(task) == "PENDING":
            slurm.release(task)
        point = one(wf, "s")
        return point["status"] == "running" and (point["line"] or "").startswith("compress") and step() > from_

    def restarts() -> int:
        return (run / "log.lammps").read_text().count("Reading restart file")

    until(lambda: goes_on(0), "the run gets going")
    # the end of its time: checkpoint, queued again, nothing more to submit
    until(lambda: slurm.state(task) == "PENDING", "the task is queued again before its time is over")
    point = one(wf, "s")
    assert (point["status"], point["reason"]) == ("waiting", "in the queue: BeginTime")
    assert point["seconds"] > 0
    assert json.loads((run / "run.json").read_text())["status"] == "interrupted"
    assert "nothing to submit" in wf(*words, "--retry").stderr
    assert f"queueing {task} again" in (tmp_path / "s" / "jobs" / "0001" / f"{task}.out").read_text()
    last = max(step_of(path) or 0 for path in run.glob("checkpoint.1.[ab]"))
    until(lambda: goes_on(last), "the run goes on")
    assert (started := restarts()) > 0
    # the node fails while it runs: Slurm queues the task again, and what the node left is no run at work
    until(lambda: (run / "checkpoint.1.a.json").is_file(), "a checkpoint is sealed")
    slurm.power_cut()
    until(lambda: slurm.state(task) == "PENDING", "the task is queued again")
    point = one(wf, "s")
    assert point["status"] == "waiting", point
    assert json.loads((run / "run.json").read_text())["status"] == "running"  # nobody could write it
    slurm.start_node()
    until(lambda: "idle" in slurm.run("sinfo", "-h", "-o", "%T"), "the node is back")
    last = max(step_of(path) or 0 for path in run.glob("checkpoint.1.[ab]"))
    until(lambda: goes_on(last), "the run goes on after the power cut")
    assert restarts() > started
    # cancelled: a failure with its reason, tried again only when asked
    slurm.run("scancel", number)
    until(lambda: slurm.state(task) == "CANCELLED", "the task is cancelled")
    point = one(wf, "s")
    assert (point["status"], point["reason"]) == ("failed", f"cancelled; job {task}")
    assert f"cancelled; job {task}" in wf("status", "s").stdout
    assert "nothing to submit" in wf(*words).stderr
    # a run that hangs when it is told to stop is killed when its minute is over
    profile.write_text('time = "00:01:00"\nmargin = 10\n')
    done = wf(*words, "--retry")
    assert "submitted 1 points" in done.stderr
    number = done.stderr.split("of job ")[1].split(";")[0]
    task, last = f"{number}_0", step()
    until(lambda: goes_on(last), "the retried run goes on")
    assert restarts() > started + 1
    for pid in slurm.on_node():
        if b"workflow.cli.main" in Path(f"/proc/{pid}/cmdline").read_bytes():
            os.kill(pid, signal.SIGSTOP)
    until(lambda: slurm.state(task) == "TIMEOUT", "Slurm kills the job")
    point = one(wf, "s")
    assert point["status"] == "failed"
    assert point["reason"] == f"out of time (its job did not get to stop it before); job {task}"


def test_a_refused_submission_leaves_no_job(slurm: Slurm, wf: Wf, tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(QUICK)
    done = wf("sweep", "study.toml", "--out", "s", "--scheduler", "slurm", "--partition", "none")
    assert done.returncode == 1
    assert "sbatch refused: sbatch: error: invalid partition specified: none" in done.stderr
    assert list((tmp_path / "s" / "jobs").iterdir()) == []
    assert status(wf, "s")["counts"]["waiting"] == 1


def test_a_directory_without_this_package(slurm: Slurm, wf: Wf, tmp_path: Path) -> None:
    """`sbatch job.sh` is all: started by srun, out of time every few seconds, a path that nobody should have."""
    found = engine()
    lmp = tmp_path / "lmp of tests"
    lmp.write_text(f'#!/bin/sh\nLD_LIBRARY_PATH={found.mpi.parent} exec {found.lmp} "$@"\n')
    lmp.chmod(0o755)
    (tmp_path / "profile.toml").write_text(
        f"time = '00:00:06'\nmargin = 3\nlauncher = 'srun -n {{ranks}}'\nlmp = '{lmp}'\n", encoding="utf-8"
    )
    scene = ["method1", "--no-cohesion", "--n", "300", "--kappa", "1e5", "--hold", "5", "--checkpoint-interval", "0.5"]
    run = tmp_path / 'it\'s a $(touch broken) "run"'
    done = wf("deck", *scene, "--out", run, "--profile", "profile.toml")
    assert done.returncode == 0, done.stderr
    shutil.copy(found.plugin, run / "plugin")
    submitted = subprocess.run(["sbatch", "job.sh"], cwd=run, env={**slurm.environment, "PYTHONPATH": ""}, capture_output=True,
                               text=True, check=False)  # fmt: skip
    assert submitted.returncode == 0, submitted.stderr
    until(lambda: "finished: stage" in said(run) or "fail" in said(run), "the run is finished, by several jobs")
    assert "finished: stage" in said(run), said(run)
    assert len(list(run.glob("job-*.out"))) > 1, said(run)
    assert "submitting again, to go on from checkpoint" in said(run)
    assert not any(tmp_path.rglob("broken"))
    done = wf("measure", run)
    assert done.returncode == 0, done.stderr


def said(run: Path) -> str:
    """What the jobs said so far."""
    return "".join(path.read_text() for path in sorted(run.glob("job-*.out")))

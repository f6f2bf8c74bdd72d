"""A real OpenPBS runs job.sh of `wf deck`: directives, several jobs for one run, a deleted job, a refusal."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from openpbs import OpenPBS
from patience import until

from workflow.runs.installation import engine

pytestmark = pytest.mark.pbs
SCENE = ["method1", "--no-cohesion", "--n", "300", "--kappa", "1e5", "--hold", "5", "--checkpoint-interval", "0.5"]


@pytest.fixture(scope="module")
def pbs() -> Iterator[OpenPBS]:
    """One for all tests."""
    started = OpenPBS()
    yield started
    started.end()


def deck(folder: Path, *words: str, **profile: object) -> Path:
    """A directory of `wf deck` in a path that nobody should have, with a LAMMPS that finds its MPI."""
    found = engine()
    lmp, run = folder / "lmp of tests", folder / 'it\'s a $(touch broken) "run"'
    lmp.write_text(f'#!/bin/sh\nLD_LIBRARY_PATH={found.mpi.parent} exec {found.lmp} "$@"\n')
    lmp.chmod(0o755)
    fields = {"scheduler": "pbs", "lmp": str(lmp), **profile}
    (folder / "profile.toml").write_text("".join(f"{name} = {value!r}\n" for name, value in fields.items()))
    wf(*SCENE, *words, "--out", str(run), "--profile", str(folder / "profile.toml"), command="deck")
    shutil.copy(found.plugin, run / "plugin")
    return run


def wf(*words: str, command: str) -> None:
    done = subprocess.run([sys.executable, "-m", "workflow.cli.main", command, *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def said(run: Path) -> str:
    """What the jobs said; PBS brings it when a job has ended."""
    return "".join(path.read_text() for path in sorted(run.glob("method1-*.o*"), key=lambda path: int(path.suffix[2:])))


def test_a_run_out_of_time_goes_on_in_further_jobs(pbs: OpenPBS, tmp_path: Path) -> None:
    """`qsub job.sh` is all: out of time every few seconds."""
    run = deck(tmp_path, time="00:00:06", margin=3)
    job = pbs.run("qsub", "job.sh", cwd=run).strip()
    until(lambda: "finished: stage" in said(run) or "fail" in said(run), "the run is finished, by several jobs")
    assert "finished: stage" in said(run), said(run)
    assert "submitting again, to go on from checkpoint" in said(run)
    assert len(list(run.glob("method1-*.o*"))) > 1
    record = pbs.run("qstat", "-x", "-f", job)
    for words in ("Join_Path = oe", "Rerunable = True", "Resource_List.walltime = 00:00:06", "Resource_List.ncpus = 1"):
        assert words in record
    assert not any(tmp_path.rglob("broken"))
    wf(str(run), command="measure")


def test_two_ranks_and_a_deleted_job(pbs: OpenPBS, tmp_path: Path) -> None:
    """`qdel` ends the deck at a checkpoint; the same command goes on from it."""
    mpiexec = engine().mpiexec
    run = deck(tmp_path, "--ranks", "2", time="01:00:00", cores_per_node=2, launcher=f"{mpiexec} -launcher fork -n {{ranks}}")
    job = pbs.run("qsub", "job.sh", cwd=run).strip()
    until(lambda: (run / "checkpoint.1.b").is_file() or pbs.state(job) == "F", "checkpoints are there")
    assert "Resource_List.select = 1:ncpus=2:mpiprocs=2" in pbs.run("qstat", "-x", "-f", job)
    pbs.run("qdel", job)
    until(lambda: pbs.state(job) == "F" and said(run), "the job has ended")
    assert "asked to end" in said(run), said(run)
    assert "MPI processor grid" in (log := (run / "log.lammps").read_text()) and "1 by 1 by 1" not in log
    job = pbs.run("qsub", "job.sh", cwd=run).strip()
    until(lambda: "Reading restart file" in (run / "log.lammps").read_text() or pbs.state(job) == "F", "it goes on")
    pbs.run("qdel", job, check=False)
    until(lambda: pbs.state(job) == "F" and "continuing from checkpoint" in said(run), "the job has ended")


def test_a_refused_submission_names_the_cause(pbs: OpenPBS, tmp_path: Path) -> None:
    run = deck(tmp_path, partition="none")
    assert "Unknown queue" in pbs.run("qsub", "job.sh", cwd=run, check=False)

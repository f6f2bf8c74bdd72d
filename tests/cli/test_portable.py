"""The directory of `wf deck --scheduler`, run as on a cluster: no Python of ours, LAMMPS and its compiler alone."""

from __future__ import annotations

import filecmp
import os
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from wf_process import ALL_STAGES, POURED, QUICK, call

from workflow.campaign.cluster import Profile
from workflow.campaign.portable import job_script
from workflow.cli.main import main
from workflow.data.series import read_series
from workflow.runs.checkpoint import step_of
from workflow.runs.installation import engine

AWKWARD = 'it\'s a "path" $(touch broken)'
FAKE_SUBMISSION = '#!/bin/sh\necho "$0 $*" >> "$SUBMITTED"\n'
SCENE = [*ALL_STAGES, "--n", "150", "--checkpoint-interval", "0.5"]  # checkpoints cost more than the run where the disk is busy
Job = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of programs: LAMMPS, its MPI's compiler, and an `sbatch` that only notes what it is asked."""
    folder, found = tmp_path_factory.mktemp("cluster"), engine()
    programs = {
        "lmp": f'#!/bin/sh\nLD_LIBRARY_PATH={found.mpi.parent} exec {found.lmp} "$@"\n',
        "mpicxx": f'#!/bin/sh\nexec {found.mpiexec.with_name("mpicxx")} "$@"\n',
        "sbatch": FAKE_SUBMISSION,
    }
    for name, text in programs.items():
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    return folder


@pytest.fixture
def environment(cluster: Path) -> dict[str, str]:
    """What a job finds: those programs, those of the system, where the headers are, nothing of ours."""
    headers = engine().lmp.parent / "include" / "lammps"
    return {"PATH": f"{cluster}:/usr/bin:/bin", "LAMMPS_INCLUDE": str(headers), "SUBMITTED": str(cluster / "submitted")}


def prepare(folder: Path, profile: str, *scene: str) -> Path:
    """`wf deck` with a profile; the plugin is there as it was built with this package, from the same source."""
    file = folder.parent / "profile.toml"
    file.write_text(profile)
    assert main(["deck", *scene, "--out", str(folder), "--profile", str(file)]) == 0
    shutil.copy(engine().plugin, folder / "plugin")
    return folder


@pytest.fixture
def job(environment: dict[str, str], tmp_path: Path) -> Job:
    """Starts job.sh as a scheduler does: a copy of it, from elsewhere, in a process group of its own."""

    def start(folder: Path) -> subprocess.Popen[str]:
        (tmp_path / "spool").mkdir(exist_ok=True)
        script = shutil.copy(folder / "job.sh", tmp_path / "spool" / "slurm_script")
        return subprocess.Popen(
            ["bash", script], cwd=tmp_path, env={**environment, "SLURM_SUBMIT_DIR": str(folder)}, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip

    return start


def assert_same(parts: Path, whole: Path) -> None:
    """The dumps bit for bit, and the time series but for repeated rows."""
    for name in filter(lambda name: (whole / name).is_file(), ("grains.dump", "contacts.dump", "tracks.dump")):
        assert filecmp.cmp(parts / name, whole / name, shallow=False), name
    one, other = read_series(whole / "series.txt"), read_series(parts / "series.txt")
    for name in one:
        np.testing.assert_array_equal(one[name], other[name], err_msg=name)


def wait_for(file: Path, process: subprocess.Popen[str]) -> None:
    deadline = time.monotonic() + 60
    while not file.is_file():
        assert process.poll() is None, "the job ended before it could be killed"
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_a_heap_is_killed_while_it_is_poured(tmp_path: Path, job: Job) -> None:
    whole, parts = (prepare(tmp_path / name, "", *POURED) for name in ("whole", "parts"))
    assert "finished: stage" in job(whole).communicate(timeout=100)[0]
    killed = job(parts)
    wait_for(parts / "checkpoint.1.b", killed)
    os.killpg(killed.pid, signal.SIGKILL)
    killed.communicate()
    text = job(parts).communicate(timeout=100)[0]
    assert "continuing from checkpoint.1." in text
    assert "finished: stage" in text
    assert_same(parts, whole)


def test_killed_and_out_of_time_it_gives_what_an_uninterrupted_job_gives(
    cluster: Path, environment: dict[str, str], tmp_path: Path, job: Job
) -> None:
    whole = prepare(tmp_path / "whole", "", *SCENE)
    text = job(whole).communicate(timeout=100)[0]
    assert "job.sh: finished: stage 6" in text
    parts = prepare(tmp_path / AWKWARD, "launcher = \"env X='a b'\"", *SCENE)

    def rerun(folder: Path, limit: int) -> subprocess.Popen[str]:
        script = (folder / "job.sh").read_text()
        (folder / "job.sh").write_text(re.sub(r"(?m)^limit=\d+$", f"limit={limit}", script))
        return job(folder)

    killed = job(parts)
    wait_for(parts / "checkpoint.2.a", killed)
    os.killpg(killed.pid, signal.SIGKILL)
    killed.communicate()
    for name in ("series.txt", "grains.dump", "contacts.dump"):  # what a kill in the middle of a write leaves
        with open(parts / name, "a") as file:
            file.write("12345 0.5 " if name == "series.txt" else "ITEM: TIME\n7.5\nITEM: TIMEST")
    limit, text = 1, "no checkpoint within the time"
    while "no checkpoint within the time" in text:  # a slow machine needs more
        assert limit < 100
        text = rerun(parts, limit).communicate(timeout=200)[0]
        limit *= 2
    assert "continuing from checkpoint." in text
    assert "submitting again, to go on from checkpoint" in text
    assert (cluster / "submitted").read_text() == f"{cluster}/sbatch job.sh\n"
    text = rerun(parts, 600).communicate(timeout=200)[0]
    assert "continuing from checkpoint." in text
    assert "job.sh: finished: stage 6" in text
    assert_same(parts, whole)
    before = (parts / "log.lammps").stat().st_mtime_ns
    assert "finished already" in job(parts).communicate(timeout=20)[0]
    assert (parts / "log.lammps").stat().st_mtime_ns == before
    assert not any(tmp_path.rglob("broken"))


def test_built_from_its_source_it_gives_what_wf_run_gives(environment: dict[str, str], tmp_path: Path, job: Job) -> None:
    """Without optimisation, which takes a quarter of the time; every bit is the same."""
    run = prepare(tmp_path / AWKWARD, "", *QUICK)
    (run / "plugin" / "discplugin.so").unlink()
    environment["CXXFLAGS"] = "-O0"
    text = job(run).communicate(timeout=600)[0]
    assert f"built {run}/plugin/discplugin.so for LAMMPS 22 Jul 2025" in text
    assert "job.sh: finished: stage" in text
    done = call("run", *QUICK, "--out", tmp_path / "ours", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for name in ("grains.dump", "contacts.dump", "series.txt"):
        assert filecmp.cmp(run / name, tmp_path / "ours" / name, shallow=False), name
    done = call("measure", run, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "in equilibrium" in done.stdout
    assert sorted(path.name for path in tmp_path.iterdir()) == [AWKWARD, "ours", "profile.toml", "spool"]


def test_failures_say_what_to_do(tmp_path: Path, job: Job) -> None:
    run = prepare(tmp_path / "run", "", "method1", "--checkpoint-interval", "1000")

    def said(old: str, new: str) -> str:
        """What the job says with one setting changed."""
        script = (run / "job.sh").read_text()
        assert f"\n{old}\n" in script
        (run / "job.sh").write_text(script.replace(old, new))
        text = job(run).communicate(timeout=60)[0]
        (run / "job.sh").write_text(script)
        return text

    plugin = run / "plugin" / "discplugin.so"
    plugin.rename(tmp_path / "kept")
    assert "LAMMPS program 'no lmp' is not found; load its module" in said("lmp=lmp", "lmp='no lmp'")
    (tmp_path / "kept").rename(plugin)
    (run / "grains.data").rename(tmp_path / "kept")
    text = said("limit=85800", "limit=9")
    assert "LAMMPS ended with status 1: ERROR" in text
    assert "grains.data" in text
    (tmp_path / "kept").rename(run / "grains.data")
    assert "no checkpoint within the time of a job; ask for more time" in said("limit=85800", "limit=0")


def test_a_module_that_does_not_load_is_named(tmp_path: Path, job: Job) -> None:
    run = prepare(tmp_path / "run", 'modules = ["none/1"]', *QUICK)
    assert "module none/1 does not load" in job(run).communicate(timeout=20)[0]
    assert not (run / "log.lammps").exists()


def test_a_stop_file_ends_the_job_and_a_lock_keeps_the_second_out(
    tmp_path: Path, job: Job, capsys: pytest.CaptureFixture[str]
) -> None:
    run = prepare(tmp_path / "run", "", "method1", "--n", "1400", "--checkpoint-interval", "0.05")
    first = job(run)
    wait_for(run / "checkpoint.1.a", first)
    assert main(["resume", str(run)]) == 1
    assert "is in use by another wf" in capsys.readouterr().err
    (run / "stop").touch()
    assert "submit again to go on" in first.communicate(timeout=60)[0]


def test_the_shell_reads_checkpoints_as_we_do(packing: Path, tmp_path: Path) -> None:
    """Steps of whole files, and none of what is cut off, empty or something else."""
    text = job_script(Profile(), "x")
    functions = text[text.index("integer()") : text.index("# sets checkpoint")]
    good = sorted(packing.glob("checkpoint.*.[ab]"))
    content = good[0].read_bytes()
    bad = {"cut": content[:-5], "head": content[:16], "empty": b"", "text": b"hello\n" * 50, "zero": bytes(400),
           "other": content[:28] + b"\xff\xff\xff\x7f" + content[32:]}  # fmt: skip
    for name, data in bad.items():
        (tmp_path / name).write_bytes(data)
    for path in [*good, *(tmp_path / name for name in bad)]:
        done = subprocess.run(
            ["bash", "-c", f'{functions}\nstep_of "$1"', "bash", path], capture_output=True, text=True, check=False
        )
        expected = str(step_of(path)) if path in good else ""
        assert (done.stdout, done.stderr) == (expected, ""), path


def test_a_dry_run_shows_deck_and_job(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The bytes of both files that the command would write, and no file."""
    monkeypatch.chdir(tmp_path)
    words = ["deck", "method1", "--n", "60", "--scheduler", "slurm", "--time", "1:00:00"]
    assert main([*words, "--dry-run"]) == 0
    shown = capsys.readouterr().out
    assert not list(tmp_path.iterdir())
    assert main([*words, "--out", "run"]) == 0
    deck, job = ((tmp_path / "run" / name).read_text() for name in ("deck.in", "job.sh"))
    assert shown.startswith(deck)
    assert shown.endswith(job)


def test_options_of_a_job_need_a_scheduler(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["deck", "method1", "--n", "60", "--out", str(tmp_path / "x")]
    assert main([*words, "--time", "01:00:00"]) == 2
    assert "--time is for a job: add --scheduler or --profile" in capsys.readouterr().err
    assert main([*words, "--scheduler", "slurm", "--account", "$(id)"]) == 2
    assert "account: '$(id)' is not allowed" in capsys.readouterr().err
    assert main([*words, "--no-account", "--scheduler", "pbs", "--account", "phys"]) == 0
    assert "variable energy_balance   index no" in (tmp_path / "x" / "deck.in").read_text()
    assert "#PBS -A phys" in (tmp_path / "x" / "job.sh").read_text()

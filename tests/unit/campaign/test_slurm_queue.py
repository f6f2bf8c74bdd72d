"""Job arrays against commands that answer as Slurm does: what is submitted, what a standing becomes, what a refusal leaves."""

from __future__ import annotations

import json
import os
import platform
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from workflow.campaign import slurm
from workflow.campaign.cluster import Profile
from workflow.campaign.study import DONE, FAILED, INTERRUPTED, RUNNING, WAITING, Study
from workflow.campaign.sweep import points_of
from workflow.cli.main import main
from workflow.errors import EnvironmentFault, InputError, WorkflowError
from workflow.runs.directory import RunDirectory

SMALL = {"scene": "method1", "fixed": {"n": 60, "cohesion": False}}
ACCOUNTING_OFF = 'echo "Slurm accounting storage is disabled" >&2; exit 1'


class Commands:
    """Puts programs of these names first on PATH; each notes what it is asked."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir()
        self.set(sbatch="echo 17", squeue="", sacct=ACCOUNTING_OFF, scancel="")

    def set(self, **bodies: str) -> None:
        for name, body in bodies.items():
            (self.folder / name).write_text(f'#!/bin/sh\necho "{name} $*" >> {shlex.quote(str(self.folder))}/asked\n{body}\n')
            (self.folder / name).chmod(0o755)

    def asked(self, name: str) -> list[str]:
        file = self.folder / "asked"
        lines = file.read_text().splitlines() if file.is_file() else []
        return [line for line in lines if line.split()[0] == name]


@pytest.fixture
def commands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Commands:
    made = Commands(tmp_path / "bin")
    monkeypatch.setenv("PATH", f"{made.folder}:/usr/bin:/bin")
    return made


@pytest.fixture
def study(tmp_path: Path) -> Study:
    made = Study(tmp_path / "it's a $(touch broken) study", points_of({**SMALL, "seeds": 7}))
    made.save()
    return made


def record(study: Study, number: int, status: str, **more: Any) -> RunDirectory:
    """What the run of point ``number`` left."""
    directory = study.directory(study.points[number])
    directory.path.mkdir(exist_ok=True)
    entry = {"status": status, "scene": "method1", "digest": study.points[number].digest, "versions": {}, **more}
    (directory / "run.json").write_text(json.dumps(entry))
    return directory


def tasks_of(study: Study, array: str) -> list[list[str]]:
    return list(json.loads((study.folder / "jobs" / array / "tasks.json").read_text())["tasks"])


def test_only_open_points_are_submitted_and_begun_ones_come_first(
    study: Study, commands: Commands, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not what is done, failed or submitted; begun points first; tasks share them evenly."""
    record(study, 0, "finished")
    record(study, 1, "failed", reason="ERROR: lost atoms")
    record(study, 6, "interrupted")
    monkeypatch.setenv("PYTHONPATH", "/a b/$(x)")
    profile = Profile(most_tasks=2, points_at_once=2, ranks=3, time=3600, partition="long", modules=["gcc/12"])
    assert slurm.submit(study, profile, at_once=3) == ("17", 5, 2)
    assert commands.asked("sbatch") == ["sbatch --parsable job.sh"]
    tasks = tasks_of(study, "0001")
    assert [len(task) for task in tasks] == [3, 2]
    assert tasks[0][0] == study.points[6].name
    assert {name for task in tasks for name in task} == {study.points[k].name for k in (2, 3, 4, 5, 6)}
    script = (study.folder / "jobs" / "0001" / "job.sh").read_text()
    for line in ("#SBATCH --array=0-1%2", "#SBATCH --cpus-per-task=6", "#SBATCH --signal=B:USR1@180", "#SBATCH --partition=long",
                 "#SBATCH --job-name=wf-it-s-a---touch-broken--study", "export PYTHONPATH='/a b/$(x)'"):  # fmt: skip
        assert line in script.splitlines()
    assert "module load gcc/12" in script
    commands.set(squeue='for k in 0 1; do echo "17|$k|PENDING|Priority"; done')
    assert slurm.submit(study, profile) is None
    # the queue holds them still; the failed one is tried again when asked, and waits then
    assert slurm.submit(study, profile, retry=True) == ("17", 1, 1)
    assert tasks_of(study, "0002") == [[study.points[1].name]]
    assert study.standing(study.points[1]).status == INTERRUPTED


def test_a_dry_run_shows_what_would_be_submitted(
    study: Study, commands: Commands, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The script to the letter; nothing is written, Slurm is told nothing."""
    (tmp_path / "study.toml").write_text('scene = "method1"\nseeds = 7\n[fixed]\nn = 60\ncohesion = false\n')
    words = ["sweep", str(tmp_path / "study.toml"), "--out", str(study.folder), "--time", "1:00:00", "--jobs", "2"]
    before = sorted(study.folder.parent.rglob("*"))
    assert main([*words, "--scheduler", "slurm", "--dry-run"]) == 0
    said = capsys.readouterr().out
    assert "7 points, 0 done" in said and f"7 points as 7 tasks of '{study.folder}/jobs/0001/job.sh'" in said
    assert sorted(study.folder.parent.rglob("*")) == before
    assert slurm.submit(study, Profile(time=3600), at_once=2) == ("17", 7, 7)
    assert said.endswith((study.folder / "jobs" / "0001" / "job.sh").read_text())
    commands.set(squeue='for k in 0 1 2 3 4 5 6; do echo "17|$k|PENDING|Priority"; done')
    assert main([*words, "--scheduler", "slurm", "--dry-run"]) == 0
    assert capsys.readouterr().out.endswith("nothing to submit\n")
    assert main([*words, "--scheduler", "pbs", "--dry-run", "--out", str(tmp_path / "other")]) == 2
    assert "job arrays are written for slurm" in capsys.readouterr().err


def test_a_warning_before_the_task_listens_does_not_end_it(
    study: Study, commands: Commands, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither while modules load nor while Python starts: what the script becomes lives on."""
    commands.set(python="kill -USR1 $$; echo lives on")
    monkeypatch.setattr(sys, "executable", str(commands.folder / "python"))
    slurm.submit(study, Profile())
    job = study.folder / "jobs" / "0001" / "job.sh"
    done = subprocess.run(["bash", str(job)], env={**os.environ, "SLURM_ARRAY_TASK_ID": "0"}, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "lives on\n", "")


@pytest.mark.parametrize(
    ("when", "status", "points"),
    [("load_scenes", 1, "waiting"), ("compute", 1, "waiting"), ("write_results", 0, "finished")],
)
def test_a_warning_at_any_moment_gives_no_traceback(
    when: str, status: int, points: str, study: Study, commands: Commands
) -> None:
    """Before a point is begun its time is over; behind the last one it is of no matter."""
    slurm.submit(study, Profile(most_tasks=7))
    plan = study.folder / "jobs" / "0001" / "tasks.json"
    if points == "finished":
        for number in range(len(study.points)):
            record(study, number, "finished")
    program = f"""
import os, signal, sys
from workflow.campaign import array_task as task
def warned(*words, real=task.{when}, **more):
    os.kill(os.getpid(), signal.SIGUSR1)
    return real(*words, **more)
task.{when} = warned
sys.exit(task.main([sys.argv[1], "0"]))
"""
    done = subprocess.run([sys.executable, "-c", program, str(plan)], capture_output=True, text=True)
    assert done.returncode == status, done.stderr
    assert "Traceback" not in done.stderr
    assert study.standing(study.points[0]).status == (DONE if points == "finished" else WAITING)


def test_standings_are_those_of_the_queue(study: Study, commands: Commands) -> None:
    slurm.submit(study, Profile(ranks=2))
    states = ["RUNNING|None", "PENDING|Resources", "TIMEOUT|TimeLimit", "CANCELLED|None", "NODE_FAIL|None", "COMPLETED|None"]
    lines = [f"17|{k}|{state}" for k, state in enumerate(states)]
    commands.set(squeue="printf '%s\\n' " + shlex.join([*lines, "17|6|OUT_OF_MEMORY|None", "99|0|RUNNING|None"]))
    away = {"host": "node7", "pid": 1, "started": "2020-01-01T00:00:00Z", "ranks": 2}
    record(study, 0, "running", **away)
    record(study, 2, "running", **away)
    record(study, 3, "interrupted", seconds=5.0)
    record(study, 5, "finished", seconds=10.0, ranks=2)
    found, live, fault = slurm.standings(study)
    assert [one.status for one in found] == [RUNNING, WAITING, FAILED, FAILED, FAILED, DONE, FAILED]
    reasons = [one.reason for one in found]
    assert reasons[0] == "on node7"
    assert reasons[1] == "in the queue: Resources"
    assert reasons[2] == "out of time (its job did not get to stop it before); job 17_2"
    assert reasons[3:5] == ["cancelled; job 17_3", "its node failed; job 17_4"]
    assert reasons[6] == "out of memory; job 17_6"
    assert live == {study.points[0].name, study.points[1].name}
    assert fault is None
    assert found[5].core_seconds == 20.0
    assert found[0].ranks == 2


def test_what_squeue_forgot_is_asked_of_the_accounting(study: Study, commands: Commands) -> None:
    slurm.submit(study, Profile())
    record(study, 4, "running", host="node7", pid=1)
    record(study, 5, "interrupted", reason=None)
    commands.set(squeue='echo "slurm_load_jobs error: Invalid job id specified" >&2; exit 1',
                 sacct="printf '17_0|TIMEOUT\\n17_1|CANCELLED by 0\\n17_2|COMPLETED\\n17_3|RUNNING\\n'")  # fmt: skip
    found = slurm.standings(study)[0]
    assert [one.status for one in found] == [FAILED, FAILED, WAITING, WAITING, FAILED, INTERRUPTED, FAILED]
    assert [str(one.reason).split(";")[0] for one in found[:2]] == [slurm.ENDED["TIMEOUT"], "cancelled"]
    assert "it was killed, or its node failed; job 17_4" in str(found[4].reason)
    commands.set(sacct=ACCOUNTING_OFF)
    for k, one in enumerate(slurm.standings(study)[0]):
        if k != 5:
            assert "Slurm has no record of its job" in str(one.reason), k


def test_a_run_of_this_machine_needs_no_job(study: Study, commands: Commands) -> None:
    """Computed here by another wf after its job was forgotten."""
    slurm.submit(study, Profile())
    record(study, 0, "running", host=platform.node(), pid=os.getpid(), started="2020-01-01T00:00:00Z")
    assert slurm.standings(study)[0][0].status == RUNNING


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ('echo "sbatch: error: Invalid account" >&2; exit 1', "sbatch refused: sbatch: error: Invalid account"),
        ("exit 3", "sbatch refused: exit status 3"),
        ("echo job 17", "sbatch answered 'job 17' instead of the id of a job"),
        ("exec sleep 60", "gave no answer in 0 s; look with 'squeue --me'"),
    ],
)
def test_a_refused_submission_leaves_nothing(
    body: str, words: str, study: Study, commands: Commands, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(slurm, "PATIENCE", 0.3 if "sleep" in body else slurm.PATIENCE)
    commands.set(sbatch=body)
    with pytest.raises(EnvironmentFault) as caught:
        slurm.submit(study, Profile())
    assert words in str(caught.value)
    assert list((study.folder / "jobs").iterdir()) == []
    assert not any(study.folder.parent.rglob("broken"))


def test_nothing_is_submitted_twice_when_slurm_is_silent(study: Study, commands: Commands) -> None:
    slurm.submit(study, Profile())
    commands.set(squeue='echo "Unable to contact slurm controller" >&2; exit 1')
    with pytest.raises(EnvironmentFault, match="squeue refused: Unable to contact"):
        slurm.submit(study, Profile())
    found, live, fault = slurm.standings(study)
    assert {one.status for one in found} == {WAITING}
    assert "Unable to contact" in str(fault)
    assert not live


def test_faults_of_the_commands_are_named(study: Study, commands: Commands, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="job arrays are written for slurm"):
        slurm.submit(study, Profile(scheduler="pbs"))
    slurm.submit(study, Profile())
    (study.folder / "jobs" / "0001" / "tasks.json").write_text("[")
    with pytest.raises(WorkflowError, match=r"jobs/0001' cannot be read"):
        slurm.standings(study)
    monkeypatch.setenv("PATH", "/nowhere")
    other = Study(study.folder.parent / "other", points_of(SMALL))
    other.save()
    with pytest.raises(EnvironmentFault, match="'sbatch' is not found: run this where Slurm's commands are"):
        slurm.submit(other, Profile())

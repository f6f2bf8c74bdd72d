"""The points of a study as job arrays of Slurm: submission, and where their tasks stand.

jobs/0001/job.sh       what was submitted                jobs/0001/tasks.json   names of the points of each task
jobs/0001/job.json     id that Slurm gave it             jobs/0001/12_3.out     what task 3 said (see `array_task`)

The run directories hold what became of a point; Slurm is asked only for what it alone knows: which tasks wait and why, which
run, and how those ended that could not record it.
"""

from __future__ import annotations

import fcntl
import json
import os
import re
import shlex
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from workflow.campaign.cluster import Profile
from workflow.campaign.study import DONE, FAILED, INTERRUPTED, RUNNING, WAITING, Point, PointStatus, Study
from workflow.data.files import atomic_write
from workflow.errors import EnvironmentFault, InputError, WorkflowError
from workflow.runs import directory as rundir
from workflow.runs.installation import absolute, python_child

JOBS, JOB, TASKS, ID = "jobs", "job.sh", "tasks.json", "job.json"
PATIENCE = 120.0  # seconds for Slurm to answer
ENDED = {
    "TIMEOUT": "out of time (its job did not get to stop it before)",
    "DEADLINE": "out of time (deadline of its job)",
    "CANCELLED": "cancelled",
    "NODE_FAIL": "its node failed",
    "BOOT_FAIL": "its node failed to boot",
    "OUT_OF_MEMORY": "out of memory",
    "PREEMPTED": "its job was preempted",
    "FAILED": "its job failed",
    "COMPLETED": "",
    "UNKNOWN": "Slurm has no record of its job: it was killed, or its node failed",
}
Task = tuple[str, int]  # id of the array, number in it


@dataclass(frozen=True)
class State:
    """State of a task in Slurm's words, and why it waits."""

    name: str
    why: str = ""

    @property
    def live(self) -> bool:
        """It runs, or will."""
        return self.name not in ENDED


class Queue:
    """The tasks of the study in ``folder``, as Slurm sees them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @cached_property
    def tasks(self) -> dict[str, Task]:
        """Task of each point that was submitted, the last one; by name of the point."""
        found: dict[str, Task] = {}
        for record in sorted(self.folder.glob(f"{JOBS}/*/{ID}")):
            try:
                number = json.loads(record.read_bytes())["id"]
                if not re.fullmatch("[0-9]+", number):
                    raise ValueError(f"id {number!r}")
                for index, names in enumerate(json.loads(record.with_name(TASKS).read_bytes())["tasks"]):
                    found |= dict.fromkeys(names, (number, index))
            except (OSError, ValueError, KeyError, TypeError, RecursionError) as fault:
                raise WorkflowError(f"'{record.parent}' cannot be read ({fault}); remove it if its jobs have ended") from fault
        return found

    def states(self, tasks: set[Task]) -> dict[Task, State]:
        """What Slurm knows of ``tasks``; those it has forgotten are UNKNOWN.  Raises EnvironmentFault if it does not answer."""
        arrays = ",".join(sorted({array for array, _ in tasks}))
        if not arrays:
            return {}
        found: dict[Task, State] = {}
        try:
            lines = _ask("squeue", "-h", "-r", "-t", "all", "-o", "%F|%K|%T|%r", "-j", arrays)
        except EnvironmentFault as fault:
            if "Invalid job id" not in str(fault):  # forgotten, all of them
                raise
            lines = []
        for line in lines:
            array, index, name, why = line.split("|", 3)
            if index.isdecimal():
                found[array, int(index)] = State(name, why)
        if tasks - found.keys():
            with suppress(EnvironmentFault):  # accounting is not everywhere
                for line in _ask("sacct", "-n", "-P", "-X", "-o", "JobID,State", "-j", arrays):
                    match = re.match(r"(\d+)_(\d+)\|(\w+)", line)
                    if match:
                        found.setdefault((match[1], int(match[2])), State(match[3]))
        return {task: found.get(task, State("UNKNOWN")) for task in tasks}


def standings(study: Study) -> tuple[list[PointStatus], set[str], str | None]:
    """Where the points of ``study`` stand, the names of those whose tasks wait or run, and why Slurm did not answer, if so.

    A point that is neither done nor failed by its own record is ``waiting`` while its task waits (``reason``: what for),
    ``failed`` if its task ended otherwise than by itself, and else as its record says.
    """
    own = [study.standing(point) for point in study.points]
    queue = Queue(study.folder)
    open_ = {point.name for point, now in zip(study.points, own, strict=True) if now.status not in (DONE, FAILED)}
    tasks = {name: task for name, task in queue.tasks.items() if name in open_}
    try:
        states = queue.states(set(tasks.values()))
    except EnvironmentFault as fault:
        return own, set(), str(fault)
    live = {name for name, task in tasks.items() if states[task].live}
    merged = [
        _merged(now, tasks[point.name], states[tasks[point.name]]) if point.name in tasks else now
        for point, now in zip(study.points, own, strict=True)
    ]
    return merged, live, None


def _merged(now: PointStatus, task: Task, state: State) -> PointStatus:
    """The standing of an unfinished point, with what Slurm knows of its task."""
    number = f"{task[0]}_{task[1]}"
    if now.status == RUNNING and (state.name == "RUNNING" or now.reason is None):  # there, or by another wf here
        return now
    if state.live:
        why = "its task has begun" if state.name == "RUNNING" else f"in the queue: {state.why}"
        return replace(now, status=WAITING, reason=why)
    if state.name == "COMPLETED":
        return replace(now, status=INTERRUPTED) if now.status == RUNNING else now
    if now.status == INTERRUPTED and now.reason is None and state.name in ("FAILED", "UNKNOWN"):  # stopped, not queued again
        return now
    return replace(now, status=FAILED, reason=f"{ENDED[state.name]}; job {number}")


def submit(study: Study, profile: Profile, *, at_once: int | None = None, retry: bool = False) -> tuple[str, int, int] | None:
    """Submit what is neither done nor submitted of ``study``, ``at_once`` points at a time at most; failed ones with ``retry``.

    Returns the id of the array and its numbers of points and tasks, None if nothing is left to submit.  Raises WorkflowError
    with Slurm's words if it refuses; then nothing is left behind.
    """
    with _alone(study.folder):
        todo = _todo(study, retry)
        if not todo:
            return None
        array = _array(study, profile, [point for point, _ in todo], at_once)
        for point, state in todo:
            if state.status == FAILED and (study.directory(point) / "run.json").is_file():
                study.directory(point).record(status=rundir.INTERRUPTED, reason=None)
        return _send(array), len(todo), len(array.tasks)


def preview(study: Study, profile: Profile, *, at_once: int | None = None, retry: bool = False) -> str:
    """What `submit` would submit: where, and the script; nothing is written."""
    todo = _todo(study, retry)
    if not todo:
        return "nothing to submit"
    array = _array(study, profile, [point for point, _ in todo], at_once)
    return f"{len(todo)} points as {len(array.tasks)} tasks of '{array.folder / JOB}':\n\n{array.script}".rstrip("\n")


def _todo(study: Study, retry: bool) -> list[tuple[Point, PointStatus]]:
    """What is neither done nor submitted, begun points first."""
    now, live, fault = standings(study)
    if fault:
        raise EnvironmentFault(fault)
    wanted = (WAITING, INTERRUPTED, FAILED) if retry else (WAITING, INTERRUPTED)
    todo = [
        (point, state)
        for point, state in zip(study.points, now, strict=True)
        if state.status in wanted and point.name not in live
    ]
    return sorted(todo, key=lambda one: one[1].status != INTERRUPTED)


@dataclass(frozen=True)
class Array:
    """A job array: ``folder`` for its files, ``script``, points of each of its ``tasks``, ``plan`` that the tasks read."""

    folder: Path
    script: str
    tasks: list[list[str]]
    plan: str


def _array(study: Study, profile: Profile, points: Sequence[Point], at_once: int | None) -> Array:
    """The array that computes ``points``.  Raises InputError for another scheduler."""
    if profile.scheduler != "slurm":
        raise InputError(
            f"scheduler = '{profile.scheduler}' is not allowed for a sweep: job arrays are written for slurm; "
            "for others, 'wf deck' makes the job of one point"
        )
    count = min(profile.most_tasks, -(-len(points) // profile.points_at_once))
    tasks = [[point.name for point in points[k::count]] for k in range(count)]
    folder = study.folder / JOBS / f"{1 + max((int(p.name) for p in study.folder.glob(f'{JOBS}/[0-9]*')), default=0):04d}"
    plan = {"study": str(study.folder.resolve()), "jobs": profile.points_at_once, "ranks": profile.ranks, "tasks": tasks}
    limit = f"%{-(-at_once // profile.points_at_once)}" if at_once else ""
    return Array(folder, array_script(profile, folder, f"0-{count - 1}{limit}"), tasks, json.dumps(plan))


def _send(array: Array) -> str:
    """Write and submit an array; its id."""
    folder = array.folder
    folder.mkdir(parents=True)
    for name, text in ((TASKS, array.plan), (JOB, array.script)):
        with atomic_write(folder / name) as draft:
            draft.write_text(text, encoding="utf-8")
    try:
        number = _ask("sbatch", "--parsable", JOB, cwd=folder)[0].split(";")[0]
        if not number.isdecimal():
            raise EnvironmentFault(f"sbatch answered '{number}' instead of the id of a job")
    except EnvironmentFault:
        for name in (JOB, TASKS):
            (folder / name).unlink()
        folder.rmdir()
        raise
    try:
        with atomic_write(folder / ID) as draft:
            draft.write_text(json.dumps({"id": number, "submitted": rundir.timestamp()}) + "\n")
    except WorkflowError:
        _ask("scancel", number)
        raise
    return number


def array_script(profile: Profile, folder: Path, array: str) -> str:
    """The job of every task: `workflow.campaign.array_task` in the Python that submits it, told before its time is over."""
    head = profile.head(
        "wf-" + re.sub(r"[^A-Za-z0-9_-]", "-", folder.resolve().parents[1].name), "%A_%a.out", f"--array={array}", "--nodes=1",
        "--ntasks=1", f"--cpus-per-task={profile.ranks * profile.points_at_once}", f"--signal=B:USR1@{profile.margin}",
    )  # fmt: skip
    path = os.pathsep.join(absolute(os.environ.get("PYTHONPATH", "")))
    command = shlex.join([*python_child("workflow.campaign.array_task"), str(folder.resolve() / TASKS)])
    return "\n".join([
        "#!/bin/bash", *head, "", "trap '' USR1    # what comes before the task listens would end it", "", *profile.loading(),
        *([f"export PYTHONPATH={shlex.quote(path)}"] if path else []),
        "export HYDRA_LAUNCHER=fork OMP_NUM_THREADS=1    # all ranks of a point are on one node",
        f'exec {command} "$SLURM_ARRAY_TASK_ID"', "",
    ])  # fmt: skip


def _ask(*command: str, cwd: Path | None = None) -> list[str]:
    """Lines that a command of Slurm prints.  Raises EnvironmentFault with its words if it is missing, fails or hangs."""
    try:
        done = subprocess.run(
            command, cwd=cwd, capture_output=True, text=True, errors="replace", stdin=subprocess.DEVNULL, timeout=PATIENCE,
            check=False,
        )  # fmt: skip
    except FileNotFoundError:
        raise EnvironmentFault(f"'{command[0]}' is not found: run this where Slurm's commands are, on a login node") from None
    except subprocess.TimeoutExpired:
        raise EnvironmentFault(
            f"{command[0]} gave no answer in {PATIENCE:.0f} s; look with 'squeue --me' what it did before trying again"
        ) from None
    if done.returncode:
        words = " ".join(done.stderr.split()) or f"exit status {done.returncode}"
        raise EnvironmentFault(f"{command[0]} refused: {words}")
    return done.stdout.splitlines()


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """One submission at a time, so that no point is in two arrays."""
    with open(folder / ".submit", "a") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise WorkflowError(f"another wf submits '{folder}' just now; wait for it") from None
        yield

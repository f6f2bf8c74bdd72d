"""A task of a job array: computes its points, stops them at checkpoints before its time is over, and queues itself again.

    python -m workflow.campaign.array_task TASKS.json INDEX

Slurm sends SIGUSR1 some time before the limit (--signal=B:USR1@...).  What was killed without warning, a failed node
included, goes on from the newest checkpoint when Slurm, or the next `wf sweep`, starts its point again.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from types import FrameType
from typing import Any

from workflow.campaign.local import Outcome, compute
from workflow.campaign.results import write_results
from workflow.campaign.study import DONE, FAILED, Study
from workflow.errors import WorkflowError
from workflow.runs import directory as rundir
from workflow.runs.checkpoint import newest
from workflow.scene.registry import load_scenes


def main(arguments: Sequence[str]) -> int:
    """Compute the points of one task.  Exit status 0 if none failed and none is left, else 1."""
    over = computing = False

    def stop(_: int, __: FrameType | None) -> None:
        nonlocal over
        over = True
        if computing:
            raise KeyboardInterrupt

    signal.signal(signal.SIGUSR1, stop)  # until here it is ignored, see `array_script`
    file, index = arguments
    load_scenes()
    plan = json.loads(Path(file).read_text(encoding="utf-8"))
    whole = Study.open(Path(plan["study"]))
    names = set(plan["tasks"][int(index)])
    study = Study(whole.folder, [point for point in whole.points if point.name in names])
    before = progress(study)
    try:
        computing = True
        outcome = Outcome(interrupted=True) if over else _compute(study, plan)
    except KeyboardInterrupt:  # before it began a point, or behind the last
        outcome = Outcome(interrupted=True)
    computing = False
    if outcome.interrupted and over:
        if progress(study) > before:
            return again()
        give_up(study)
        return 1
    standings = [whole.standing(point) for point in whole.points]
    if all(now.status in (DONE, FAILED) for now in standings):
        write_results(whole)
    return int(outcome.failed > 0)


def _compute(study: Study, plan: dict[str, Any]) -> Outcome:
    """The cores are those that the job asked for, whatever this process may use of them."""
    return compute(study, jobs=plan["jobs"], ranks=plan["ranks"], options=["--oversubscribe"])


def progress(study: Study) -> int:
    """Steps behind the newest checkpoints of the points, and a great number for each point that is done or failed."""
    total = 0
    for point in study.points:
        directory = study.directory(point)
        if study.standing(point).status in (DONE, FAILED):
            total += 1 << 60
        elif directory.path.is_dir() and (checkpoint := newest(directory.path)):
            total += checkpoint.step
    return total


def give_up(study: Study) -> None:
    """Queueing again would repeat the same part for ever."""
    for point in study.points:
        directory = study.directory(point)
        if (directory / "run.json").is_file() and study.standing(point).status not in (DONE, FAILED):
            reason = "no checkpoint within the time of a job; give more --time, or write checkpoints more often"
            directory.record(status=rundir.FAILED, reason=reason)


def again() -> int:
    """Queue this task once more; it keeps its number."""
    number = f"{os.environ['SLURM_ARRAY_JOB_ID']}_{os.environ['SLURM_ARRAY_TASK_ID']}"
    print(f"time is over: queueing {number} again", file=sys.stderr, flush=True)
    done = subprocess.run(["scontrol", "requeue", number], capture_output=True, text=True, check=False)
    if done.returncode:
        print(f"scontrol refused: {done.stderr.strip()}; 'wf sweep' submits what is left", file=sys.stderr)
    return int(done.returncode != 0)


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except WorkflowError as fault:
        sys.exit(f"wf: {fault}")

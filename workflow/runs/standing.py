"""Where a run stands, by its record and its time series."""

from __future__ import annotations

import shlex
from typing import Any

from workflow.data.files import alive
from workflow.data.frame import Floats
from workflow.data.series import read_last_row
from workflow.errors import WorkflowError
from workflow.runs.directory import INTERRUPTED, RUNNING, RunDirectory, seconds_since
from workflow.runs.progress import steps_left
from workflow.scene.base import Scene
from workflow.scene.progress import of_stage, words

NUMBERS = ("stage", "stage_number", "stages", "time", "progress", "remaining", "line")


def standing(directory: RunDirectory) -> dict[str, Any]:
    """Status, equilibrium (True, False, None: not judged), numbers and line of progress, reason of failure of one run.

    ``stage`` is the ``stage_number``-th of ``stages``; ``time`` of the scene; ``progress``: share of the stage's time that is
    over; ``remaining`` seconds of the stage; None: unknown, and of a run that is not at work.
    """
    state = directory.state
    status, reason = state["status"], state.get("reason")
    if status == RUNNING and not alive(state.get("pid")):
        status, reason = INTERRUPTED, f"it was killed; continue with 'wf resume {shlex.quote(str(directory.path))}'"
    numbers = _at_work(directory, state) if status == RUNNING else _at(directory, directory.scene)
    return {
        "directory": str(directory.path), "status": status, "equilibrium": directory.equilibrium(), **numbers,
        "reason": reason, "seconds": state.get("seconds"),
    }  # fmt: skip


def in_words(row: dict[str, Any]) -> str:
    """The status for people."""
    return f"{row['status']}, not in equilibrium" if row["equilibrium"] is False else str(row["status"])


def progress(directory: RunDirectory, scene: Scene) -> str | None:
    """The progress line of the last row of the time series, None without one."""
    line = _at(directory, scene)["line"]
    return None if line is None else str(line)


def _at(directory: RunDirectory, scene: Scene) -> dict[str, Any]:
    """The numbers of the last row."""
    try:
        last = read_last_row(directory / "series.txt") if (directory / "series.txt").is_file() else None
        return dict.fromkeys(NUMBERS) | (_numbers(scene, last) if last else {})
    except (WorkflowError, KeyError):  # caught in the middle of a write
        return dict.fromkeys(NUMBERS)


def _numbers(scene: Scene, series: dict[str, Floats], left: str | None = None) -> dict[str, Any]:
    number, known = int(series["stage"][-1]), list(scene.stages)
    return {
        "stage": scene.stages.get(number), "stage_number": known.index(number) + 1 if number in known else None,
        "stages": len(known), "time": float(series["time"][-1]), "line": scene.progress_line(series, left),
    }  # fmt: skip


def _at_work(directory: RunDirectory, state: dict[str, Any]) -> dict[str, Any]:
    """The numbers of a run at work: what is left at the pace since its beginning."""
    scene = directory.scene
    try:
        series = directory.series()
        if series is None:
            return _at(directory, scene)
        step, rows = float(series["step"][-1]), of_stage(series)
        steps = steps_left(scene, series)
        spent = float(state.get("seconds") or 0.0) + seconds_since(state.get("started"))
        left = None if steps is None or not step else steps * spent / step
        done = rows["step"][-1] - rows["step"][0]
        share = None if steps is None else float(done / (done + steps))
        return dict.fromkeys(NUMBERS) | _numbers(scene, series, words(left)) | {"progress": share, "remaining": left}
    except (WorkflowError, KeyError):  # caught in the middle of a write
        return dict.fromkeys(NUMBERS)

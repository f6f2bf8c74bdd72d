"""Where a run stands, by its record and its time series."""

from __future__ import annotations

import shlex
from typing import Any

from workflow.data.files import alive
from workflow.data.series import read_last_row
from workflow.errors import WorkflowError
from workflow.runs.directory import INTERRUPTED, RUNNING, RunDirectory
from workflow.scene.base import Scene


def standing(directory: RunDirectory) -> dict[str, Any]:
    """Status, progress and reason of failure of one run."""
    state = directory.state
    status, reason = state["status"], state.get("reason")
    if status == RUNNING and not alive(state.get("pid")):
        status, reason = INTERRUPTED, f"  it was killed; continue with 'wf resume {shlex.quote(str(directory.path))}'"
    return {
        "directory": str(directory.path),
        "status": status,
        "progress": progress(directory, directory.scene),
        "reason": reason,
        "seconds": state.get("seconds"),
    }


def progress(directory: RunDirectory, scene: Scene) -> str | None:
    """The progress line of the last row of the time series, None without one."""
    try:
        last = read_last_row(directory / "series.txt") if (directory / "series.txt").is_file() else None
        return scene.progress_line(last, None) if last else None
    except (WorkflowError, KeyError):  # caught in the middle of a write
        return None

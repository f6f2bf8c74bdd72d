"""wf status: where runs stand."""

from __future__ import annotations

import argparse
import json
import os
import shlex
from pathlib import Path
from typing import Any

from workflow.cli.options import command
from workflow.engine.rundir import INTERRUPTED, RUNNING, RunDirectory
from workflow.engine.watch import describe
from workflow.errors import ArchiveError, InputError

EXAMPLES = """
wf status                    every run below runs/
wf status runs/method1-*     some of them
wf status packing --json     for programs
"""


def declare(commands: Any) -> None:
    """Options of `wf status`."""
    parser = command(commands, "status", "show where runs stand", EXAMPLES, action=action)
    parser.add_argument("directories", type=Path, nargs="*", metavar="DIR", help="run directories (default: all of runs/)")
    parser.add_argument("--json", action="store_true", help="print JSON")


def action(arguments: argparse.Namespace) -> int:
    """Print one line per run."""
    paths = arguments.directories or sorted(path.parent for path in Path("runs").glob("*/run.json"))
    if not paths:
        raise InputError("no run directories below 'runs'; give some, or start one with 'wf run'")
    rows = [_row(path) for path in paths]
    if arguments.json:
        print(json.dumps(rows, indent=1))
    else:
        width = max(len(row["directory"]) for row in rows)
        for row in rows:
            print(f"{row['directory']:{width}s}  {row['status']:11s}  {row['progress'] or ''}{row['reason'] or ''}")
    return 0


def _row(path: Path) -> dict[str, Any]:
    """A damaged directory is a row that says so, not the end of the list."""
    directory = RunDirectory.open(path)
    try:
        return standing(directory)
    except ArchiveError as fault:
        return {"directory": str(path), "status": "damaged", "progress": None, "reason": str(fault), "seconds": None}


def standing(directory: RunDirectory) -> dict[str, Any]:
    """Status, progress and reason of failure of one run."""
    state = directory.state
    status, reason = state["status"], state.get("reason")
    if status == RUNNING and not _alive(state.get("pid")):
        status, reason = INTERRUPTED, f"  it was killed; continue with 'wf resume {shlex.quote(str(directory.path))}'"
    series = directory.series()
    return {
        "directory": str(directory.path),
        "status": status,
        "progress": describe(series, directory.scene, None) if series else None,
        "reason": reason,
        "seconds": state.get("seconds"),
    }


def _alive(pid: int | None) -> bool:
    try:
        os.kill(pid or 0, 0)
    except (ProcessLookupError, PermissionError):
        return False
    return bool(pid)

"""wf status: where runs and studies stand."""

from __future__ import annotations

import argparse
import json
import shlex
from collections import Counter
from pathlib import Path
from typing import Any

from workflow.campaign import slurm
from workflow.campaign import study as ensemble
from workflow.campaign.study import POINTS, Study, alive, remaining
from workflow.cli.options import command
from workflow.data.series import read_last_row
from workflow.errors import ArchiveError, InputError, WorkflowError
from workflow.runs.directory import INTERRUPTED, RUNNING, RunDirectory
from workflow.runs.progress import describe
from workflow.scene.registry import Scene

EXAMPLES = """
wf status                    every run below runs/
wf status runs/method1-*     some of them
wf status /scratch/me        every run and study directly below it
wf status runs/study         a study of 'wf sweep' or 'wf reproduce': counts, what runs, what failed and why, core hours
wf status packing --json     for programs
"""
MOST = 20  # of those that run, and of those that failed, that people see


def declare(commands: Any) -> None:
    """Options of `wf status`."""
    parser = command(commands, "status", "show where runs and studies stand", EXAMPLES, action=action)
    parser.add_argument("directories", type=Path, nargs="*", metavar="DIR",
                        help="run directories, studies, or folders that hold such (default: runs)")  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print JSON")


def action(arguments: argparse.Namespace) -> int:
    """Print one line per run, a block per study."""
    paths = [path for given in arguments.directories for path in _at(given) or [given]] or _at(Path("runs"))
    if not paths:
        raise InputError("no run directories below 'runs'; give some, or start one with 'wf run'")
    rows = [_study(path) if (path / POINTS).is_file() else _row(path) for path in paths]
    if arguments.json:
        print(json.dumps(rows, indent=1))
    else:
        width = max(len(row["directory"]) for row in rows)
        for row in rows:
            if "counts" in row:
                print(_block(row))
            else:
                print(f"{row['directory']:{width}s}  {row['status']:11s}  {row['progress'] or ''}{row['reason'] or ''}")
    return 0


def _at(path: Path) -> list[Path]:
    """The run or study at the path, or those directly below it."""
    names = ("run.json", POINTS)
    if any((path / name).is_file() for name in names):
        return [path]
    return sorted(found.parent for name in names for found in path.glob(f"*/{name}"))


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
    if status == RUNNING and not alive(state.get("pid")):
        status, reason = INTERRUPTED, f"  it was killed; continue with 'wf resume {shlex.quote(str(directory.path))}'"
    return {
        "directory": str(directory.path),
        "status": status,
        "progress": _progress(directory, directory.scene),
        "reason": reason,
        "seconds": state.get("seconds"),
    }


def _study(path: Path) -> dict[str, Any]:
    """Counts, core hours spent and left, and every point; the progress of those at work."""
    study = Study.open(path)
    standings, _, fault = slurm.standings(study)
    counts = Counter(now.status for now in standings)
    left = remaining(study.points, standings)
    return {
        "directory": str(path),
        "counts": {status: counts[status] for status in ensemble.STATUSES},
        "scheduler": fault,
        "core_hours_spent": sum(now.core_seconds for now in standings) / 3600.0,
        "core_hours_left": None if left is None else left / 3600.0,
        "points": [
            {
                "name": point.name, "label": study.label(point), "status": now.status, "reason": now.reason,
                "seconds": now.seconds,
                "progress": _progress(study.directory(point), point.scene) if now.status == ensemble.RUNNING else None,
            }
            for point, now in zip(study.points, standings, strict=True)
        ],
    }  # fmt: skip


def _progress(directory: RunDirectory, scene: Scene) -> str | None:
    try:
        last = read_last_row(directory / "series.txt") if (directory / "series.txt").is_file() else None
        return describe(last, scene, None) if last else None
    except (WorkflowError, KeyError):  # caught in the middle of a write
        return None


def _block(row: dict[str, Any]) -> str:
    """A study for people."""
    left = row["core_hours_left"]
    cost = f"core hours: {row['core_hours_spent']:.2f} spent, {'unknown' if left is None else f'about {left:.2f}'} left"
    counts = ", ".join(f"{count} {status}" for status, count in row["counts"].items() if count or status == ensemble.DONE)
    kinds = {kind: [one for one in row["points"] if one["status"] == kind] for kind in (ensemble.RUNNING, ensemble.FAILED)}
    shown = [one for some in kinds.values() for one in some[:MOST]]
    width = max((len(one["label"]) for one in shown), default=0)
    lines = []
    for one in shown:
        words = one["progress"] or one["reason"] or ""
        lines.append(f"  {one['status']:8s} {one['name']}  {one['label']:{width}s}  {words}")
    lines += [f"  and {len(some) - MOST} more {kind}: see --json" for kind, some in kinds.items() if len(some) > MOST]
    waits = Counter(one["reason"] for one in row["points"] if one["status"] == ensemble.WAITING and one["reason"])
    lines += [f"  {count} waiting {reason}" for reason, count in waits.most_common()]
    lines += [f"  the scheduler was not asked: {row['scheduler']}"] if row["scheduler"] else []
    return "\n".join([f"{row['directory']}  {len(row['points'])} points: {counts or 'none'}; {cost}", *lines])

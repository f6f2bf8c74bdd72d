"""wf status: where runs and studies stand."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from workflow.campaign.status import in_words as study_in_words
from workflow.campaign.status import study_standing
from workflow.campaign.study import POINTS
from workflow.cli.options import command
from workflow.errors import ArchiveError, InputError
from workflow.runs.directory import RunDirectory
from workflow.runs.standing import NUMBERS, in_words, standing

EXAMPLES = """
wf status                    every run below runs/
wf status runs/method1-*     some of them
wf status /scratch/me        every run and study directly below it
wf status runs/study         a study of 'wf sweep' or 'wf reproduce': counts, what runs, what failed and why, core hours
wf status packing --json     for programs
"""


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
    rows = [study_standing(path) if (path / POINTS).is_file() else _row(path) for path in paths]
    if arguments.json:
        print(json.dumps(rows, indent=1))
    else:
        width = max(len(row["directory"]) for row in rows)
        for row in rows:
            if "counts" in row:
                print(study_in_words(row))
            else:
                words = filter(None, (f"{row['directory']:{width}s}", f"{in_words(row):11s}", row["line"], row["reason"]))
                print("  ".join(words))
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
        empty = dict.fromkeys((*NUMBERS, "equilibrium", "seconds"))
        return {"directory": str(path), "status": "damaged", **empty, "reason": str(fault)}

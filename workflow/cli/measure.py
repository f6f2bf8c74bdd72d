"""wf measure: the numbers of a run."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from workflow.cli.options import command
from workflow.cli.run import summary
from workflow.engine.collect import ARCHIVE, collect, measures_of
from workflow.engine.rundir import FINISHED, RunDirectory
from workflow.errors import ArchiveError

EXAMPLES = """
wf measure runs/method1-130aae48                  for people
wf measure runs/method1-130aae48 --json           for programs
wf measure runs/method1-130aae48 --frame 0        the first frame instead of the last
"""


def declare(commands: Any) -> None:
    """Options of `wf measure`."""
    parser = command(
        commands,
        "measure",
        "measure a run: density, coordination, forces, equilibrium, energy",
        EXAMPLES,
        action=action,
    )
    parser.add_argument("directory", type=Path, metavar="DIR", help="run directory")
    parser.add_argument("--frame", type=int, default=-1, metavar="K", help="frame, negative from the end (default -1)")
    parser.add_argument(
        "--network", action=argparse.BooleanOptionalAction, default=None,
        help="rigidity, elastic moduli and force percolation too (default: up to 10000 grains)",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print JSON")


def archived(directory: RunDirectory) -> RunDirectory:
    """The directory with its archive, made now if the deck was run by hand."""
    archive, dump = directory / ARCHIVE, directory / "grains.dump"
    if not archive.is_file() or (dump.is_file() and dump.stat().st_mtime_ns > archive.stat().st_mtime_ns):
        if not dump.is_file():
            raise ArchiveError(f"'{directory.path}' has no results yet; run its deck, or 'wf resume {directory.path}'")
        collect(directory)
        result = directory.result()
        if result and not result["stopped"]:  # the deck came to its end; a killed run stays one to resume
            directory.record(status=FINISHED, reason=None)
    return directory


def action(arguments: argparse.Namespace) -> int:
    """Measure and print."""
    directory = archived(RunDirectory.open(arguments.directory))
    measures = measures_of(directory, arguments.frame, network=arguments.network)
    print(json.dumps(measures, indent=1) if arguments.json else summary(measures, directory))
    return 0

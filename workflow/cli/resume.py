"""wf resume: continue an interrupted or killed run."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from workflow.cli.options import add_any_deck, command
from workflow.cli.parser import number
from workflow.cli.run import add_run_options, check_ranks, finish
from workflow.runs.directory import RunDirectory
from workflow.runs.extend import extend

EXAMPLES = """
wf resume runs/method1-130aae48            continue from the newest checkpoint
wf resume runs/method1-130aae48 --ranks 2  the same on two MPI ranks
wf resume runs/method1-130aae48 --max-time 2000  each stage may take 2000 T0: a run that ended before equilibrium goes on
wf resume runs/method1-130aae48 --any-deck  although deck or scene were changed, or another version began it
"""


def declare(commands: Any) -> None:
    """Options of `wf resume`."""
    parser = command(commands, "resume", "continue an interrupted run from its newest checkpoint", EXAMPLES, action=action)
    parser.add_argument("directory", type=Path, metavar="DIR", help="run directory")
    add_run_options(parser, parser, ranks=None)
    parser.add_argument("--max-time", type=number, metavar="T", help="longest time of each stage, in the scene's unit:"
                        " extends a run that ended, or would end, before its equilibrium")  # fmt: skip
    add_any_deck(parser)
    parser.add_argument("--anew", action="store_true", help="begin again if what every checkpoint needs is lost or damaged")


def action(arguments: argparse.Namespace) -> int:
    """Continue the run, with more time if wanted, on as many ranks as it had unless told otherwise."""
    directory = RunDirectory.open(arguments.directory)
    before = directory.state.get("ranks", 1)
    arguments.ranks = before if arguments.ranks is None else arguments.ranks
    check_ranks(arguments)
    if arguments.ranks != before:
        print(
            f"on {arguments.ranks} ranks instead of {before}: rounding differs, so the run does not repeat bit for bit",
            file=sys.stderr,
        )
    extend(directory, arguments.max_time, any_deck=arguments.any_deck)
    return finish(directory, arguments, resume=True, any_deck=arguments.any_deck, anew=arguments.anew)

"""wf verify: is a finished run reproducible here?"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from workflow.campaign.verify import summary, verify
from workflow.cli.lists import whole_number
from workflow.cli.options import add_any_deck, command
from workflow.cli.run import add_oversubscribe, check_ranks
from workflow.runs.directory import RunDirectory

EXAMPLES = """
wf verify runs/method2-130aae48            run it again in a temporary directory and compare every byte
wf verify runs/method2-130aae48 --last     only what followed its last checkpoint
wf verify runs/method2-130aae48 --ranks 2  within bounds on another number of ranks
"""


def declare(commands: Any) -> None:
    """Options of `wf verify`."""
    parser = command(commands, "verify", "run a finished run again and compare; status 0: reproduced, 1: not", EXAMPLES,
                     action=action)  # fmt: skip
    parser.add_argument("directory", type=Path, metavar="DIR", help="run directory")
    parser.add_argument("--last", action="store_true", help="only from the last checkpoint to the end")
    parser.add_argument("--ranks", type=whole_number, metavar="R", help="MPI ranks (default: those of the run)")
    parser.add_argument("--json", action="store_true", help="print JSON")
    add_oversubscribe(parser)
    add_any_deck(parser)


def action(arguments: argparse.Namespace) -> int:
    """Repeat, compare, tell."""
    directory = RunDirectory.open(arguments.directory)
    arguments.ranks = arguments.ranks or directory.state.get("ranks", 1)
    check_ranks(arguments)
    verdict = verify(directory, last=arguments.last, ranks=arguments.ranks, any_deck=arguments.any_deck)
    print(json.dumps(verdict.as_dict(), indent=1) if arguments.json else summary(verdict))
    return 0 if verdict.reproduced else 1

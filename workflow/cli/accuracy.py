"""wf accuracy: error against run time, and the step for a wanted error."""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from workflow.cli.options import command, command_line
from workflow.cli.parser import number
from workflow.data.files import writable_folder
from workflow.errors import InputError
from workflow.runs.installation import engine
from workflow.verification.accuracy import FULL, QUICK, orders, recommend, study
from workflow.verification.pages import steps_in_words, write_accuracy

EXAMPLES = """
wf accuracy --quick --out accuracy          a first look in a minute or two
wf accuracy --error 1e-2 --out accuracy     everything, and the step for an error of one percent
wf accuracy --quick --json --out accuracy   for programs
"""


def declare(commands: Any) -> None:
    """Options of `wf accuracy`."""
    parser = command(
        commands, "accuracy", "measure error against run time over steps, schemes and laws", EXAMPLES, action=action
    )
    parser.add_argument("--error", type=number, default=1e-3, metavar="E", help="wanted error (default 1e-3)")
    parser.add_argument("--quick", action="store_true", help="fewer steps, grains and seeds")
    parser.add_argument("--out", type=Path, default=Path("accuracy"), metavar="DIR", help="where to write (default accuracy)")
    parser.add_argument("--json", action="store_true", help="print JSON")


def action(arguments: argparse.Namespace) -> int:
    """Run, write, print."""
    if not 0.0 < arguments.error < math.inf:
        raise InputError(f"--error {arguments.error:g} is not allowed: it must be above 0 and finite, for example 1e-3")
    engine()
    writable_folder(arguments.out)
    few, many = study(QUICK if arguments.quick else FULL)
    slopes, steps = orders(few), recommend(few, arguments.error)
    write_accuracy(arguments.out, few, many, arguments.error, command_line())
    if arguments.json:
        fitted = [{"case": case, "variant": variant, "order": order} for (case, variant), order in slopes.items()]
        print(json.dumps({"error": arguments.error, "few_bodies": [asdict(row) for row in few], "orders": fitted,
                          "many_bodies": [asdict(row) for row in many], "recommended": steps}, indent=1))  # fmt: skip
        return 0
    print(f"for an error of {arguments.error:g}, steps per stiffest period (wf run ... --steps-per-period):")
    for row in steps:
        print(f"{row['case']!s:20s} {row['variant']!s:22s} {steps_in_words(row)}")
    print(f"{arguments.out}/accuracy.html")
    return 0

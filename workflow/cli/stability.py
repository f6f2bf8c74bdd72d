"""wf stability: which parameters are computed stably, inaccurately, unstably, or refused."""

from __future__ import annotations

import argparse
import json
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

from workflow.cli.options import command, command_line
from workflow.data.files import writable_folder
from workflow.runs.installation import engine
from workflow.verification.pages import write_stability
from workflow.verification.stability import STABLE, study

EXAMPLES = """
wf stability --quick --out stability     short runs, a minute or two
wf stability --out stability             the whole map
wf stability --quick --json              for programs
"""


def declare(commands: Any) -> None:
    """Options of `wf stability`."""
    parser = command(commands, "stability", "map what is stable over stiff and extreme parameters", EXAMPLES, action=action)
    parser.add_argument("--quick", action="store_true", help="shorter runs")
    parser.add_argument("--out", type=Path, default=Path("stability"), metavar="DIR", help="where to write (default stability)")
    parser.add_argument("--json", action="store_true", help="print JSON")


def action(arguments: argparse.Namespace) -> int:
    """Run, write, print what is not stable."""
    engine()
    writable_folder(arguments.out)
    found = study(quick=arguments.quick)
    write_stability(arguments.out, found, command_line())
    if arguments.json:
        print(json.dumps([asdict(row) for row in found], indent=1))
        return 0
    for row in found:
        if row.verdict != STABLE:
            print(f"{row.verdict:10s} {row.parameter} = {row.value:g}: {row.reason}")
    print("  ".join(f"{verdict} {count}" for verdict, count in Counter(row.verdict for row in found).items()))
    print(f"{arguments.out}/stability.html")
    return 0

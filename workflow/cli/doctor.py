"""wf doctor: is everything there, does it fit, does it compute right?"""

from __future__ import annotations

import argparse
import json
from typing import Any

from workflow.cli.options import command
from workflow.runs.doctor import examine

EXAMPLES = """
wf doctor           versions, fit of plugin and engine, a collision of two discs
wf doctor --json    for programs
"""


def declare(commands: Any) -> None:
    """Options of `wf doctor`."""
    parser = command(commands, "doctor", "check the installation and run a self test", EXAMPLES, action=action)
    parser.add_argument("--json", action="store_true", help="print JSON")


def action(arguments: argparse.Namespace) -> int:
    """Examine and report; status 1 if something is wrong."""
    report = examine()
    if arguments.json:
        print(json.dumps(report, indent=1))
    else:
        for name, value in report["versions"].items():
            print(f"{name:10s} {value}")
        for check in report["checks"]:
            print(f"{'ok  ' if check['ok'] else 'FAIL'} {check['name']}: {check['detail']}")
    return 0 if all(check["ok"] for check in report["checks"]) else 1

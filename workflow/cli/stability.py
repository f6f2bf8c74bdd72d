"""wf stability: which parameters are computed stably, inaccurately, unstably, or refused."""

from __future__ import annotations

import argparse
import json
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

from workflow.cli.accuracy import fresh
from workflow.cli.options import command, command_line
from workflow.data.table import write_csv
from workflow.runs.installation import engine
from workflow.verification.stability import INACCURATE, OVERLAP, RESIDUAL, STABLE, UNSTABLE, Verdict, study

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
    fresh(arguments.out)
    found = study(quick=arguments.quick)
    write(arguments.out, found, command_line())
    if arguments.json:
        print(json.dumps([asdict(row) for row in found], indent=1))
        return 0
    for row in found:
        if row.verdict != STABLE:
            print(f"{row.verdict:10s} {row.parameter} = {row.value:g}: {row.reason}")
    print("  ".join(f"{verdict} {count}" for verdict, count in Counter(row.verdict for row in found).items()))
    print(f"{arguments.out}/stability.html")
    return 0


def write(out: Path, found: list[Verdict], words: str) -> None:
    """Table, map and page."""
    from workflow.reports.study_page import write_page
    from workflow.verification.figures import FIGURES

    write_csv(out / "stability.csv", found)
    FIGURES["stability"]["map"].draw(found, out / "stability.png")
    text = (
        f"Every field is one run at the step of the step rule. {INACCURATE}: energy residual above {100 * RESIDUAL:g} % of the "
        f"energy that went through, overlap above {OVERLAP:g} of the smallest radius, or an unresolved tail. {UNSTABLE}: the "
        "energy account is lost or the run breaks down. 'unchecked' passes by the check that refuses such steps."
    )
    rows = [{name: value for name, value in asdict(row).items() if name != "seconds"} for row in found]
    write_page(
        out / "stability.html",
        "Stability over stiff and extreme parameters",
        [("text", text), ("code", words), ("image", out / "stability.png"), ("table", rows)],
    )

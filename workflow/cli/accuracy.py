"""wf accuracy: error against run time, and the step for a wanted error."""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from workflow.cli.options import command, command_line
from workflow.data.table import write_csv
from workflow.errors import InputError
from workflow.runs.installation import engine
from workflow.verification.accuracy import FULL, QUICK, Few, Many, orders, recommend, study

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
    parser.add_argument("--error", type=float, default=1e-3, metavar="E", help="wanted error (default 1e-3)")
    parser.add_argument("--quick", action="store_true", help="fewer steps, grains and seeds")
    parser.add_argument("--out", type=Path, default=Path("accuracy"), metavar="DIR", help="where to write (default accuracy)")
    parser.add_argument("--json", action="store_true", help="print JSON")


def action(arguments: argparse.Namespace) -> int:
    """Run, write, print."""
    if not 0.0 < arguments.error < math.inf:
        raise InputError(f"--error {arguments.error:g} is not allowed: it must be above 0 and finite, for example 1e-3")
    engine()
    fresh(arguments.out)
    few, many = study(QUICK if arguments.quick else FULL)
    slopes, steps = orders(few), recommend(few, arguments.error)
    write(arguments.out, few, many, arguments.error, command_line())
    if arguments.json:
        fitted = [{"case": case, "variant": variant, "order": order} for (case, variant), order in slopes.items()]
        print(json.dumps({"error": arguments.error, "few_bodies": [asdict(row) for row in few], "orders": fitted,
                          "many_bodies": [asdict(row) for row in many], "recommended": steps}, indent=1))  # fmt: skip
        return 0
    print(f"for an error of {arguments.error:g}, steps per stiffest period (wf run ... --steps-per-period):")
    for row in steps:
        print(f"{row['case']!s:20s} {row['variant']!s:22s} {_words(row)}")
    print(f"{arguments.out}/accuracy.html")
    return 0


def fresh(out: Path) -> None:
    """A directory to write into; InputError if it cannot be made."""
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise InputError(f"cannot create '{out}': {fault.strerror}; give a writable --out DIR") from fault


def _words(row: dict[str, Any]) -> str:
    if row["steps_per_period"] is None:
        return f"not reached: least error {row['least_error']:.1e}"
    return f"{row['steps_per_period']:.0f}"


def write(out: Path, few: list[Few], many: list[Many], wanted: float, words: str) -> None:
    """Tables, figures and the page."""
    from workflow.reports.study_page import write_page
    from workflow.verification.figures import FIGURES

    few_figure, many_figure = (FIGURES["accuracy"][name].draw for name in ("few", "packings"))
    slopes, steps = orders(few), recommend(few, wanted)
    write_csv(out / "accuracy.csv", few)
    write_csv(out / "packings.csv", many)
    few_figure(few, slopes, out / "accuracy.png", wanted=wanted, against_time=True)
    few_figure(few, slopes, out / "convergence.png", wanted=wanted, against_time=False)
    many_figure(many, out / "packings.png")
    table = [
        {"case": row["case"], "variant": row["variant"], "fitted order": slopes.get((str(row["case"]), str(row["variant"]))),
         "steps per period": _words(row), "step [T0]": row["step"], "least error": row["least_error"]}
        for row in steps
    ]  # fmt: skip
    write_page(
        out / "accuracy.html",
        "Error against run time",
        [
            ("text", "Few discs against an independent high-order integrator of the exact law; packings by method 1, mean over "
             "seeds with standard errors. Time unit T0, run time of one core."),
            ("code", words),
            ("heading", f"Steps per stiffest period for an error of {wanted:g}"),
            ("table", table),
            ("heading", "Work and precision, few bodies"), ("image", out / "accuracy.png"),
            ("heading", "Convergence, few bodies"), ("image", out / "convergence.png"),
            ("heading", "Packings"), ("image", out / "packings.png"),
            ("table", [asdict(row) for row in many]),
        ],
    )  # fmt: skip

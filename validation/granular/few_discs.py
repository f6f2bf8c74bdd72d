"""Errors of a few discs under LAMMPS's granular law, with and without its synchronized_verlet: few_discs.csv.

python few_discs.py      some minutes; the cases of `wf accuracy` in which discs meet with friction
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

from workflow.verification.accuracy import Plan, few_bodies
from workflow.verification.few_discs import cases
from workflow.verification.one_run import SYNCHRONIZED, VARIANTS

HERE = Path(__file__).parent
PLAN = Plan(groups=6, few=(14, 28, 112, 448), many=(), seeds=0, grains=0, duration=0.0)
COMPARED = ("exact", "exact, paper's scheme", "stock", "stock, synchronized")


def main() -> None:
    """Every case that `wf accuracy` has of discs that meet."""
    print("cases:", ", ".join(case.name for case in cases(PLAN.groups)), file=sys.stderr)
    rows = few_bodies(PLAN, [variant for variant in (*VARIANTS, SYNCHRONIZED) if variant.name in COMPARED])
    with open(HERE / "few_discs.csv", "w", encoding="ascii", newline="") as file:
        table = csv.writer(file)
        table.writerow(["case", "variant", "steps_per_period", "error"])
        table.writerows([row.case, row.variant, f"{row.steps_per_period:g}", f"{row.error:.2e}"] for row in rows)


if __name__ == "__main__":
    main()

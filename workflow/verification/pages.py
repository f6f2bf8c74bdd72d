"""The tables, figures and pages of `wf accuracy`, `wf stability` and `wf crosscheck`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from workflow.data.table import write_csv
from workflow.verification import accuracy, crosscheck, crosscheck_few
from workflow.verification.accuracy import orders, recommend
from workflow.verification.figures import FIGURES
from workflow.verification.stability import INACCURATE, OVERLAP, RESIDUAL, UNSTABLE, Verdict


def write_accuracy(
    out: Path, few: list[accuracy.FewBodyError], many: list[accuracy.PackingStatistics], wanted: float, words: str
) -> None:
    """Tables, figures and the page."""
    from workflow.reports.study_page import write_page

    slopes, steps = orders(few), recommend(few, wanted)
    write_csv(out / "accuracy.csv", few)
    write_csv(out / "packings.csv", many)
    FIGURES["accuracy"]["few"].draw(few, slopes, out / "accuracy.png", wanted=wanted, against_time=True)
    FIGURES["accuracy"]["few"].draw(few, slopes, out / "convergence.png", wanted=wanted, against_time=False)
    FIGURES["accuracy"]["packings"].draw(many, out / "packings.png")
    table = [
        {"case": row["case"], "variant": row["variant"], "fitted order": slopes.get((str(row["case"]), str(row["variant"]))),
         "steps per period": steps_in_words(row), "step [T0]": row["step"], "least error": row["least_error"]}
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


def steps_in_words(row: dict[str, Any]) -> str:
    """Steps per period of a row of `recommend`, or that none of them reaches the error."""
    if row["steps_per_period"] is None:
        return f"not reached: least error {row['least_error']:.1e}"
    return f"{row['steps_per_period']:.0f}"


def write_stability(out: Path, found: list[Verdict], words: str) -> None:
    """Table, map and page."""
    from workflow.reports.study_page import write_page

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


def write_crosscheck(out: Path, few: Sequence[crosscheck_few.FewBodyError], made: Sequence[crosscheck.Result]) -> None:
    """Tables and figures."""
    packed = [result.row for result in made]
    if few:
        write_csv(out / "few.csv", few)
        FIGURES["crosscheck"]["few"].draw(few, out / "few.png")
    if packed:
        write_csv(out / "packings.csv", packed)
        write_csv(out / "means.csv", crosscheck.means(packed))
        FIGURES["crosscheck"]["packings"].draw(made, out / "packings.png")

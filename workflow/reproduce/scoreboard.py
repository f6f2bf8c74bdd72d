"""Ours against theirs, number by number: difference in standard errors and a verdict, as CSV, JSON and Markdown."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from workflow.data.files import atomic_write
from workflow.data.table import write_csv
from workflow.reproduce.papers import Paper, Printed

AGREES, DIFFERS, MISPRINT, UNJUDGED, NOT_RUN = "agrees", "differs", "misprint suspected", "not judged", "not run"
NO_SAMPLE = "no sample is finished"
VERDICTS = (AGREES, DIFFERS, MISPRINT, UNJUDGED, NOT_RUN)
# Standard errors up to which two numbers agree.  With four samples of ours their own scatter is known so badly that a
# larger difference comes by chance once in twenty times (Student's t with three degrees of freedom).
BOUND = 3.0


@dataclass(frozen=True)
class Ours:
    """What the samples give: ``value``, its ``error`` (standard error, None if not known) and the ``scatter`` of one sample.

    ``samples`` measured of ``wanted``; of them ``at_rest``: runs that ended in equilibrium, and ``pooled``: taken from
    another scoreboard.  ``values``: those of the single samples, in the order of ``seeds`` and ``digests``; none of a
    fit, which is made to all of them together.  ``trouble``: why there is no value.
    """

    value: float | None = None
    error: float | None = None
    samples: int = 0
    wanted: int = 0
    at_rest: int = 0
    seeds: str = ""
    digests: str = ""
    values: str = ""
    pooled: int = 0
    trouble: str = ""

    @property
    def scatter(self) -> float | None:
        """Standard deviation of one sample."""
        return None if self.error is None else self.error * math.sqrt(self.samples)


@dataclass(frozen=True)
class Row:
    """A line of the scoreboard: where the number stands, ours, theirs, the verdict."""

    table: str
    row: str
    column: str
    quantity: str
    ours: float | None
    standard_error: float | None
    samples: int
    wanted: int
    at_rest: int
    pooled: int
    printed: float | None
    uncertainty: float | None
    low: float | None
    high: float | None
    difference: float | None
    verdict: str
    reason: str
    measure: str
    seeds: str
    digests: str
    values: str


def judge(number: Printed, ours: Ours) -> Row:
    """The line of one printed number.

    difference = (ours - theirs)/sqrt(SE^2 + u^2), SE our standard error, u the printed uncertainty.  Where one of both
    is not known the other side's stands for it: one sample of ours scatters as theirs do (u), a number printed without
    uncertainty as one sample of ours.  Of a bound the difference is how far ours lies beyond it, 0 inside.  One sample
    can agree, but is not enough to differ.
    """
    difference = _difference(number, ours)
    if ours.value is None:
        verdict, reason = NOT_RUN, ours.trouble or number.reason
    elif difference is None or (abs(difference) > BOUND and ours.error is None):
        verdict, reason = UNJUDGED, "one sample: our scatter is not known"
    elif abs(difference) > BOUND:
        verdict = MISPRINT if number.misprint else DIFFERS
        reason = "; ".join(filter(None, (number.misprint, number.reason)))
    else:
        verdict, reason = AGREES, ""
    return Row(
        *number.case.where, number.quantity, ours.value, ours.error, ours.samples, ours.wanted, ours.at_rest, ours.pooled,
        number.value, number.error, number.low, number.high, difference, verdict, reason, number.measure or "", ours.seeds,
        ours.digests, ours.values,
    )  # fmt: skip


def _difference(number: Printed, ours: Ours) -> float | None:
    if ours.value is None:
        return None
    if number.value is None:
        low, high = (-math.inf if number.low is None else number.low), (math.inf if number.high is None else number.high)
        outside = ours.value - min(max(ours.value, low), high)
        return 0.0 if outside == 0.0 else outside / ours.error if ours.error else None
    own = number.error if ours.error is None else ours.error
    theirs = ours.scatter if number.error is None else number.error
    spread = math.hypot(own or 0.0, theirs or 0.0)
    return (ours.value - number.value) / spread if spread > 0.0 else None


Figures = Sequence[Mapping[str, str]]  # number, file, shows, trouble


def write(folder: Path, paper: Paper, rows: Sequence[Row], figures: Figures, provenance: Mapping[str, Any]) -> None:
    """scoreboard.csv, .json and .md in ``folder``."""
    write_csv(folder / "scoreboard.csv", rows)
    table = {
        "paper": paper.title, "quick": paper.quick, "counts": counts(rows), "numbers": [asdict(row) for row in rows],
        "figures": list(figures), "provenance": dict(provenance),
    }  # fmt: skip
    with atomic_write(folder / "scoreboard.json") as draft:
        draft.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
    with atomic_write(folder / "scoreboard.md") as draft:
        draft.write_text(markdown(paper, rows, figures, provenance), encoding="utf-8")


def counts(rows: Sequence[Row]) -> dict[str, int]:
    """How many numbers have each verdict."""
    found = Counter(row.verdict for row in rows)
    return {verdict: found[verdict] for verdict in VERDICTS}


NOT_THE_SIZE = "Not the paper's size: fewer and smaller samples, to see that everything works. Nothing follows from it."
HOW = (
    "Ours: mean over samples ± standard error (jackknife), and how many samples of those wanted. Theirs: uncertainty {}. The "
    "difference is in standard errors of both together; within {:g} they agree (with four samples a larger one comes by chance "
    "once in twenty times). Where a side has no uncertainty the other's stands for it; one sample of ours can agree, but is "
    "not enough to differ."
)


def markdown(paper: Paper, rows: Sequence[Row], figures: Figures, provenance: Mapping[str, Any]) -> str:
    """The scoreboard for people."""
    lines = [f"# {paper.short}, number by number", "", f"{paper.title}."]
    for text in texts(paper, rows):
        lines += ["", text]
    lines += ["", *(f"* {name}: {value}" for name, value in provenance.items())]
    for heading, table in sections(paper, rows):
        lines += [
            "",
            f"## {heading}",
            "",
            _line(table[0]),
            "|" + "---|" * len(table[0]),
            *(_line(row.values()) for row in table),
        ]
    if figures:
        lines += ["", "## Figures", "", "| figure | ours | the paper shows |", "|---|---|---|"]
        lines += [f"| {one['number']} | {_figure(one)} | {one['shows']} |" for one in figures]
    return "\n".join(lines) + "\n"


def texts(paper: Paper, rows: Sequence[Row]) -> list[str]:
    """What stands above the tables: how many numbers have which verdict, and how they are compared."""
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in counts(rows).items())
    return [
        *([NOT_THE_SIZE] if paper.quick else []),
        f"{len(rows)} numbers: {verdicts}.",
        HOW.format(paper.uncertainty, BOUND),
    ]


def sections(paper: Paper, rows: Sequence[Row]) -> list[tuple[str, list[dict[str, str]]]]:
    """The printed tables: heading and lines, each a mapping of the names of its columns to text."""
    found: list[tuple[str, list[dict[str, str]]]] = []
    for row in rows:
        title = paper.titles[" ".join((row.table, row.row, row.column))]
        heading = f"{f'Table {row.table}' if row.table[0].isdigit() else row.table.capitalize()}: {title}"
        if not found or found[-1][0] != heading:
            found.append((heading, []))
        found[-1][1].append(_cells(row))
    return found


def _cells(row: Row) -> dict[str, str]:
    error = "" if row.standard_error is None else f" ± {row.standard_error:.2g}"
    number = f"{row.samples}/{row.wanted}" + (f", {row.samples - row.at_rest} not at rest" if row.at_rest < row.samples else "")
    number += f", {row.pooled} pooled" if row.pooled else ""
    return {
        "row": row.row,
        "column": row.column,
        "quantity": row.quantity,
        "ours": "" if row.ours is None else f"{row.ours:.4g}{error}",
        "samples": number,
        "theirs": theirs(row),
        "difference": "" if row.difference is None else f"{row.difference:+.1f}",
        "verdict": row.verdict + (f": {row.reason}" if row.reason else ""),
    }


def _line(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def theirs(row: Row) -> str:
    """The printed number or bound."""
    if row.printed is not None:
        return f"{row.printed:g}" + ("" if row.uncertainty is None else f" ± {row.uncertainty:g}")
    if row.low is None:
        return f"below {row.high:g}"
    return f"above {row.low:g}" if row.high is None else f"{row.low:g} to {row.high:g}"


def _figure(one: Mapping[str, str]) -> str:
    return f"[{one['file']}]({one['file']})" if one["file"] else one["trouble"]

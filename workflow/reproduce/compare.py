"""A paper beside the finished runs of a study: every number and figure, written as scoreboard and page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from workflow.campaign.study import Study
from workflow.reproduce.figures import Say, figures
from workflow.reproduce.papers import Drawing, Paper, Printed
from workflow.reproduce.pool import Earlier, origin
from workflow.reproduce.readings import Readings, lines, write_readings
from workflow.reproduce.runs import provenance, rows
from workflow.reproduce.scoreboard import Row, counts, sections, texts, write


def compare(
    study: Study, paper: Paper, numbers: Sequence[Printed], drawings: Sequence[Drawing], earlier: Sequence[Earlier], *,
    command: str, say: Say,
) -> tuple[list[Row], list[dict[str, str]]]:  # fmt: skip
    """Measure, compare, draw; the rows of the scoreboard, which is written to the study's folder, and of the figures.

    ``earlier``: scoreboards made elsewhere, pooled with the runs here; ``command``: what is said to repeat it.
    """
    found = rows(study, numbers, earlier, say)
    drawn, taken = figures(study, drawings, earlier, say)
    say("")
    if found:
        made = provenance(study, command) | origin(earlier, found, taken)
        write(study.folder, paper, found, drawn, made)
        write_page_of(study.folder, paper, found, drawn, made)
    return found, drawn


def compare_readings(study: Study, of: Readings, *, command: str, say: Say) -> None:
    """Compare each reading with the numbers that decide, and write the tables to the study's folder."""
    found = [line for one in of.readings for line in lines(one, rows(study, of.of(one), [], say))]
    say("")
    write_readings(study.folder, of, found, provenance(study, command))


def summary(found: Sequence[Row], figures: Sequence[Mapping[str, str]], folder: Path) -> str:
    """What came out, for people."""
    said = []
    if found:
        said += [", ".join(f"{count} {verdict}" for verdict, count in counts(found).items())]
        said += [f"{folder / 'scoreboard.md'}  (.html, .csv, .json)"]
    drawn = [one["file"] for one in figures if one["file"]]
    if drawn:
        said += [f"{len(drawn)} figures in {folder / 'figures'}"]
    for trouble in dict.fromkeys(one["trouble"] for one in figures if one["trouble"]):
        said += [f"not drawn: {', '.join(one['number'] for one in figures if one['trouble'] == trouble)}: {trouble}"]
    return "\n".join(said)


def write_page_of(
    folder: Path, paper: Paper, found: Sequence[Row], figures: Sequence[Mapping[str, str]], made: Mapping[str, Any]
) -> None:
    """The scoreboard with its figures, to look at in a browser."""
    from workflow.reports.study_page import write_page

    parts: list[tuple[str, Any]] = [("text", f"{paper.title}."), *(("text", text) for text in texts(paper, found))]
    parts += [("code", f"{name}: {value}") for name, value in made.items()]
    for heading, table in sections(paper, found):
        parts += [("heading", heading), ("table", table)]
    for one in figures:
        if one["file"]:
            text = f"The paper shows: {one['shows']}."
            parts += [("heading", f"Figure {one['number']}"), ("image", folder / one["file"]), ("text", text)]
    write_page(folder / "scoreboard.html", f"{paper.short}, number by number", parts)

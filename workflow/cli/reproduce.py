"""wf reproduce: the numbers and figures of a paper from runs of our own, and the scoreboard."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from workflow.campaign.local import Outcome
from workflow.campaign.study import Study
from workflow.cli.deck import job_of
from workflow.cli.options import command, command_line
from workflow.cli.sweep import add_jobs, carry_out, check_jobs, declare_and_adopt, ended, plan, send
from workflow.errors import InputError, WorkflowError
from workflow.reproduce.figures import draw
from workflow.reproduce.papers import Drawing, Paper, papers, points_of, read_paper
from workflow.reproduce.pool import Earlier, origin, read_earlier, take_figure
from workflow.reproduce.readings import lines, read_readings, write_readings
from workflow.reproduce.runs import provenance, rows, samples_of
from workflow.reproduce.scoreboard import Row, counts, sections, texts, write

EXAMPLES = """
wf reproduce gilabert2007 --quick --jobs 2           everything in minutes, at a small size: does it work here?
wf reproduce gilabert2007 --table 2..3 --jobs 2      tables II and III, the paper's size
wf reproduce gilabert2007 --table 5 --samples 2      two samples of each kind instead of the paper's number
wf reproduce gilabert2007 --figure 9                 figures 9a to 9c and the runs they need
wf reproduce gilabert2007 --dry-run                  what would be computed, what is done
wf reproduce gilabert2007 --adopt runs --no-run      the scoreboard of the finished runs found in runs
wf reproduce gilabert2007 --scheduler slurm --time 12:00:00
                                                     as a job array; then --no-run for the scoreboard
wf reproduce gilabert2007 --no-run --pool docs/results/gilabert2007/scoreboard.json
                                                     with the samples of a scoreboard made elsewhere
wf reproduce gilabert2007 --readings --dry-run       what the readings of the procedure would cost
wf reproduce gilabert2007 --readings W0.3,W0.6      these two against the printed numbers, chi^2 of each
wf status runs/gilabert2007                          where it stands
"""


def declare(commands: Any) -> None:
    """Options of `wf reproduce`."""
    parser = command(commands, "reproduce", "compute a paper's numbers and compare them one by one", EXAMPLES, action=action)
    parser.add_argument("paper", metavar="PAPER", help=f"one of: {', '.join(papers())}")
    parser.add_argument("--table", metavar="T", help="tables: 2, or 2..5, or 2,5,text (default: everything)")
    parser.add_argument("--figure", metavar="F", help="figures: 9, or 9b, or 9..12, or 9,23 (default: everything)")
    parser.add_argument("--quick", action="store_true", help="few and small samples, in minutes; not the paper's size")
    parser.add_argument("--readings", metavar="R", nargs="?", const="", help="readings of the procedure (default all, or names "
                        "with commas) against the numbers that decide, instead of the scoreboard")  # fmt: skip
    parser.add_argument("--samples", type=int, metavar="K", help="samples of each kind (default: the paper's number)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the study (default runs/PAPER, or runs/PAPER-quick)")
    add_jobs(parser)
    parser.add_argument("--pool", type=Path, action="append", default=[], metavar="SCOREBOARD.json",
                        help="numbers and figures made elsewhere, beside those of the runs here (repeatable)")  # fmt: skip
    parser.add_argument("--no-run", action="store_true", help="compute nothing: the scoreboard of what is finished")
    parser.add_argument("--json", action="store_true", help="print the scoreboard as JSON")


def action(arguments: argparse.Namespace) -> int:
    """Compute what is missing, measure, compare, draw."""
    check_jobs(arguments)
    profile = job_of(arguments, local=("ranks",))
    if arguments.samples is not None and arguments.samples < 1:
        raise InputError(f"--samples {arguments.samples} is not allowed: it must be at least 1")
    if arguments.readings is not None:
        return _readings(arguments, profile)
    paper = read_paper(arguments.paper, quick=arguments.quick, samples=arguments.samples)
    earlier = [read_earlier(path) for path in arguments.pool]
    numbers, drawings = paper.chosen(_list(arguments.table, "--table"), _list(arguments.figure, "--figure"))
    folder = arguments.out or Path("runs") / (paper.name + ("-quick" if paper.quick else ""))
    study = Study(folder, points_of(numbers, drawings))
    if paper.quick:
        print("quick: fewer and smaller samples, not the paper's size", file=sys.stderr)
    if arguments.dry_run:
        print("\n".join(f"figure {one.number}: {one.plot}: {one.shows}" for one in paper.drawings))
        print(plan(study, profile, arguments))
        return 0
    if profile and not arguments.no_run:
        return send(study, profile, arguments)
    outcome = _computed(study, arguments)
    if outcome.interrupted:
        return ended(outcome)
    found = rows(study, numbers, earlier, _say)
    figures, taken = _figures(study, drawings, folder, earlier)
    _say("")
    words = command_line()
    if found:
        made = provenance(study, words) | origin(earlier, found, taken)
        write(folder, paper, found, figures, made)
        _page(folder, paper, found, figures, made)
    if arguments.json:
        print((folder / "scoreboard.json").read_text(encoding="utf-8") if found else json.dumps({"figures": figures}))
        return ended(outcome)
    _summary(paper, found, figures, folder)
    return ended(outcome)


def _computed(study: Study, arguments: argparse.Namespace) -> Outcome:
    """Compute what the study lacks, or with --no-run take it as it stands."""
    if not arguments.no_run:
        return carry_out(study, arguments, ranks=arguments.ranks)
    declare_and_adopt(study, arguments)
    return Outcome()


def _readings(arguments: argparse.Namespace, profile: Any) -> int:
    """Compute what the readings lack, and compare each with the numbers that decide."""
    for given, option in ((arguments.table, "--table"), (arguments.figure, "--figure"), (arguments.pool, "--pool")):
        if given:
            raise InputError(f"{option} is of the scoreboard: leave it out beside --readings")
    if arguments.quick:
        raise InputError("--quick is of the scoreboard: choose fewer readings, or --samples 1, beside --readings")
    names = [name.strip() for name in arguments.readings.split(",")] if arguments.readings else None
    of = read_readings(arguments.paper, chosen=names, samples=arguments.samples)
    folder = arguments.out or Path("runs") / f"{of.paper.name}-readings"
    study = Study(folder, points_of([number for one in of.readings for number in of.of(one)], []))
    if arguments.dry_run:
        print(plan(study, profile, arguments))
        return 0
    if profile and not arguments.no_run:
        return send(study, profile, arguments)
    outcome = _computed(study, arguments)
    if outcome.interrupted:
        return ended(outcome)
    found = [line for one in of.readings for line in lines(one, rows(study, of.of(one), [], _say))]
    _say("")
    write_readings(folder, of, found, provenance(study, command_line()))
    print((folder / f"readings.{'json' if arguments.json else 'md'}").read_text(encoding="utf-8"), end="")
    return ended(outcome)


def _summary(paper: Paper, found: Sequence[Any], figures: Sequence[dict[str, str]], folder: Path) -> None:
    """What came out, for people."""
    if found:
        print(", ".join(f"{count} {verdict}" for verdict, count in counts(found).items()))
        print(f"{folder / 'scoreboard.md'}  (.html, .csv, .json)")
    drawn = [one["file"] for one in figures if one["file"]]
    if drawn:
        print(f"{len(drawn)} figures in {folder / 'figures'}")
    for trouble in dict.fromkeys(one["trouble"] for one in figures if one["trouble"]):
        print(f"not drawn: {', '.join(one['number'] for one in figures if one['trouble'] == trouble)}: {trouble}")


def _page(folder: Path, paper: Paper, found: Sequence[Row], figures: Sequence[dict[str, str]], made: Mapping[str, Any]) -> None:
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


def _list(text: str | None, option: str) -> list[str] | None:
    """The names in 2..5,7: whole numbers of a range, other words as they are."""
    if text is None:
        return None
    names: list[str] = []
    for part in text.split(","):
        first, dots, last = part.strip().partition("..")
        if not dots:
            names.append(first)
        elif first.isdigit() and last.isdigit() and int(first) <= int(last) < 1000:
            names += [str(k) for k in range(int(first), int(last) + 1)]
        else:
            raise InputError(f"{option} {text} is not allowed: write a number, a range as 2..5, or several with commas")
    return names


def _say(text: str) -> None:
    """A line of a terminal that is written over."""
    if sys.stderr.isatty():
        sys.stderr.write("\r" + text.ljust(40) + ("" if text else "\r"))
        sys.stderr.flush()


def _figures(
    study: Study, drawings: Sequence[Drawing], folder: Path, earlier: Sequence[Earlier]
) -> tuple[list[dict[str, str]], list[str]]:
    """The figures, and the numbers of those taken from elsewhere: of which not all samples are here."""
    found, taken = [], []
    for drawing in drawings:
        row = {"number": drawing.number, "plot": drawing.plot, "file": "", "shows": drawing.shows, "trouble": ""}
        whole = (len(samples_of(study, case)) >= len([*case.values()][: drawing.most]) for case in drawing.cases)
        if earlier and not all(whole):
            row["file"] = take_figure(drawing.number, earlier, folder)
        if row["file"]:
            taken.append(drawing.number)
        found.append(row if row["file"] else _draw(study, drawing, folder, row))
    return found, taken


def _draw(study: Study, drawing: Drawing, folder: Path, row: dict[str, str]) -> dict[str, str]:
    """The figure's file, or why there is none."""
    name = f"figures/fig{drawing.number}.png"
    points, names = [], []
    for case in drawing.cases:
        found = samples_of(study, case)[: drawing.most]
        if not found and not drawing.partial:
            return row | {"trouble": "not all of its samples are finished"}
        points += [(point, case.stage) for point in found]
        names += [" ".join(case.where[1:]).strip()] * len(found)
    if drawing.cases and not points:
        return row | {"trouble": "no sample is finished"}
    _say(f"drawing figure {drawing.number}")
    (folder / "figures").mkdir(exist_ok=True)
    try:
        draw(drawing, [(study.directory(point), stage) for point, stage in points], names, folder / name)
    except WorkflowError as fault:
        return row | {"trouble": str(fault)}
    return row | {"file": name}

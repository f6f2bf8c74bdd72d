"""wf reproduce: the numbers and figures of a paper from runs of our own, and the scoreboard."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from workflow.campaign.carry_out import carry_out, plan, send
from workflow.campaign.study import Study
from workflow.cli.deck import job_of
from workflow.cli.lists import add_list, any_word, listed, ranged, whole_number
from workflow.cli.options import command, command_line
from workflow.cli.sweep import add_jobs, ended, orders_of, print_path
from workflow.cli.terminal import overwrite
from workflow.errors import InputError
from workflow.reproduce.compare import compare, compare_readings, summary
from workflow.reproduce.papers import papers, points_of, read_paper
from workflow.reproduce.pool import read_earlier
from workflow.reproduce.readings import read_readings

EXAMPLES = """
wf reproduce gilabert2007 --quick --jobs 2           everything in minutes, at a small size: does it work here?
wf reproduce gilabert2007 --table 2..3 --jobs 2      tables II and III, the paper's size
wf reproduce gilabert2007 --table 5 --samples 2      two samples of each kind instead of the paper's number
wf reproduce gilabert2007 --figure 9                 figures 9a to 9c and the runs they need
wf reproduce gilabert2007 --dry-run                  what would be computed, what is done
wf reproduce gilabert2007 --adopt runs --no-run      the scoreboard of the finished runs found in runs
wf reproduce gilabert2007 --scheduler slurm --time 12:00:00
                                                     as a job array; then --no-run for the scoreboard
wf reproduce gilabert2007 --no-run --pool validation/gilabert2007/scoreboard.json
                                                     with the samples of a scoreboard made elsewhere
wf reproduce gilabert2007 --readings --dry-run       what the readings of the procedure would cost
wf reproduce gilabert2007 --readings W0.3,W0.6      these two against the printed numbers, chi^2 of each
wf status runs/gilabert2007                          where it stands
"""


def declare(commands: Any) -> None:
    """Options of `wf reproduce`."""
    parser = command(commands, "reproduce", "compute a paper's numbers and compare them one by one", EXAMPLES, action=action)
    parser.add_argument("paper", metavar="PAPER", help=f"one of: {', '.join(papers())}")
    add_list(parser, "--table", "T", "tables: 2, or 2..5, or 2,5,text (default: everything)")
    add_list(parser, "--figure", "F", "figures: 9, or 9b, or 9..12, or 9,23 (default: everything)")
    parser.add_argument("--quick", action="store_true", help="few and small samples, in minutes; not the paper's size")
    parser.add_argument("--readings", metavar="R,...", nargs="?", const="", action="append", help="readings of the procedure "
                        "(default all) against the numbers that decide, instead of the scoreboard")  # fmt: skip
    parser.add_argument("--samples", type=whole_number, metavar="K", help="samples of each kind (default: the paper's number)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the study (default runs/PAPER, or runs/PAPER-quick)")
    add_jobs(parser)
    parser.add_argument("--pool", type=Path, action="append", default=[], metavar="SCOREBOARD.json",
                        help="numbers and figures made elsewhere, beside those of the runs here (repeatable)")  # fmt: skip
    parser.add_argument("--no-run", action="store_true", help="compute nothing: the scoreboard of what is finished")
    parser.add_argument("--json", action="store_true", help="print the scoreboard as JSON")


def action(arguments: argparse.Namespace) -> int:
    """Compute what is missing, measure, compare, draw."""
    orders, profile = orders_of(arguments), job_of(arguments, local=("ranks",))
    if arguments.samples is not None and arguments.samples < 1:
        raise InputError(f"--samples {arguments.samples} is not allowed: it must be at least 1")
    of_readings = arguments.readings is not None
    study, finish = (_readings if of_readings else _scoreboard)(arguments)
    if arguments.dry_run:
        print(plan(study, profile, orders))
        return 0
    if profile and not arguments.no_run:
        return print_path(send(study, profile, orders))
    outcome = carry_out(study, orders, compute_rest=not arguments.no_run)
    if not outcome.interrupted:
        finish()
    return ended(outcome)


def _scoreboard(arguments: argparse.Namespace) -> tuple[Study, Callable[[], None]]:
    """The study of the numbers and figures that are asked for, and what is done with it once it is computed."""
    paper = read_paper(arguments.paper, quick=arguments.quick, samples=arguments.samples)
    earlier = [read_earlier(path) for path in arguments.pool]
    numbers, drawings = paper.chosen(ranged(arguments.table, "--table"), ranged(arguments.figure, "--figure"))
    study = Study(
        arguments.out or Path("runs") / (paper.name + ("-quick" if paper.quick else "")), points_of(numbers, drawings)
    )
    if paper.quick:
        print("quick: fewer and smaller samples, not the paper's size", file=sys.stderr)
    if arguments.dry_run:
        print("\n".join(f"figure {one.number}: {one.plot}: {one.shows}" for one in paper.drawings))

    def finish() -> None:
        found, drawn = compare(
            study, paper, numbers, drawings, earlier, command=command_line(), say=overwrite
        )  # fmt: skip
        if arguments.json:
            print((study.folder / "scoreboard.json").read_text(encoding="utf-8") if found else json.dumps({"figures": drawn}))
        elif said := summary(found, drawn, study.folder):
            print(said)

    return study, finish


def _readings(arguments: argparse.Namespace) -> tuple[Study, Callable[[], None]]:
    """The study of the readings that are asked for, and what is done with it once it is computed."""
    for option in ("table", "figure", "pool"):
        if getattr(arguments, option):
            raise InputError(f"--{option} is of the scoreboard: leave it out beside --readings")
    if arguments.quick:
        raise InputError("--quick is of the scoreboard: choose fewer readings, or --samples 1, beside --readings")
    names = listed("--readings", arguments.readings, any_word) if any(arguments.readings) else None
    of = read_readings(arguments.paper, chosen=names, samples=arguments.samples)
    points = points_of([number for one in of.readings for number in of.of(one)], [])
    study = Study(arguments.out or Path("runs") / f"{of.paper.name}-readings", points)

    def finish() -> None:
        compare_readings(study, of, command=command_line(), say=overwrite)
        print((study.folder / f"readings.{'json' if arguments.json else 'md'}").read_text(encoding="utf-8"), end="")

    return study, finish

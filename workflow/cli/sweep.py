"""wf sweep: a grid of parameters and seeds, computed once."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from workflow.campaign.carry_out import Orders, carry_out, plan, send
from workflow.campaign.local import Outcome
from workflow.campaign.project import MANAGERS, write_project
from workflow.campaign.results import RESULTS, write_results
from workflow.campaign.study import Study
from workflow.campaign.sweep import read_sweep
from workflow.cli.deck import add_cluster, job_of
from workflow.cli.lists import whole_number
from workflow.cli.options import command
from workflow.cli.run import add_oversubscribe

EXAMPLES = """
wf sweep study.toml --dry-run                 the points and what they would cost
wf sweep study.toml --jobs 2                  compute them, two at a time, into runs/study
wf sweep study.toml --adopt runs              take finished runs of the same scenes from runs
wf status runs/study                          where it stands
wf sweep study.toml --retry                   once more what failed
wf sweep study.toml --scheduler slurm --time 12:00:00 --partition long
                                              as a job array; the same command submits what is left,
                                              and with --dry-run prints the script instead
wf sweep study.toml --export snakemake --out project
                                              as a project of Snakemake, signac or row, which then runs the points

a study file; every combination of the lists and seeds is a point:
  scene = "method1"
  seeds = 4                  # seeds 1 to 4; or a list
  [fixed]
  cohesion = false
  [grid]
  mu = [0.15, 0.5]
  rolling = [false, true]
several tables [[grid]] instead of [grid] are several grids
"""


def declare(commands: Any) -> None:
    """Options of `wf sweep`."""
    parser = command(commands, "sweep", "compute a grid of parameters and seeds, each point once", EXAMPLES, action=action)
    parser.add_argument("file", type=Path, metavar="STUDY.toml", help="declaration of the study")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the study (default runs/NAME of the file)")
    parser.add_argument("--export", choices=sorted(MANAGERS), metavar="MANAGER", help="write a project of another workflow "
                        f"manager and compute nothing: {', '.join(sorted(MANAGERS))}")  # fmt: skip
    add_jobs(parser)


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """What every command that computes a study takes."""
    parser.add_argument("--jobs", type=whole_number, metavar="J", help="runs at a time (default 1; in a job array no limit)")
    parser.add_argument("--retry", action="store_true", help="run again what failed")
    parser.add_argument("--adopt", type=Path, action="append", default=[], metavar="DIR",
                        help="link finished runs of the same scenes found there (repeatable)")  # fmt: skip
    parser.add_argument("--any-deck", action="store_true",
                        help="adopt and continue also runs whose deck another version made of the scene")  # fmt: skip
    parser.add_argument("--dry-run", action="store_true", help="say what would be computed; write nothing")
    parser.add_argument("--ranks", type=whole_number, metavar="R", help="MPI ranks of a run (default 1)")
    add_oversubscribe(parser)
    add_cluster(parser)


def orders_of(arguments: argparse.Namespace) -> Orders:
    """How the command line wants a study carried out.  Raises InputError."""
    names = ("jobs", "ranks", "retry", "adopt", "any_deck", "oversubscribe")
    return Orders(**{name: getattr(arguments, name) for name in names})


def action(arguments: argparse.Namespace) -> int:
    """Declare the study, compute it."""
    orders, profile = orders_of(arguments), job_of(arguments, local=("ranks",))
    folder = arguments.out or Path("runs") / arguments.file.stem
    if arguments.export:
        return _export(arguments.file, folder, arguments.export)
    study = Study(folder, read_sweep(arguments.file))
    if arguments.dry_run:
        print(plan(study, profile, orders))
        return 0
    if profile:
        return print_path(send(study, profile, orders))
    outcome = carry_out(study, orders)
    if not outcome.interrupted and write_results(study):
        print(folder / RESULTS)
    print(f"{folder}: {outcome.done} of {len(study.points)} points done")
    return ended(outcome)


def _export(declaration: Path, folder: Path, manager: str) -> int:
    """Write the project and say how it is started."""
    start = write_project(declaration, folder, manager)
    print(f"{folder}: start it there with '{start}'")
    return 0


def print_path(path: Path | None) -> int:
    """Say where something is, if it is anywhere; status 0."""
    if path:
        print(path)
    return 0


def ended(outcome: Outcome) -> int:
    """The exit status."""
    return 130 if outcome.interrupted else int(outcome.failed > 0)

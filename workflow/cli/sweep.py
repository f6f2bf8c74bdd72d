"""wf sweep: a grid of parameters and seeds, computed once."""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path
from typing import Any

from workflow.campaign.cluster import Profile
from workflow.campaign.local import Outcome, compute, duration
from workflow.campaign.results import RESULTS, write_results
from workflow.campaign.slurm import preview, submit
from workflow.campaign.study import DONE, Study, remaining
from workflow.campaign.sweep import read_sweep
from workflow.cli.deck import add_cluster, job_of
from workflow.cli.options import command
from workflow.cli.run import add_oversubscribe
from workflow.errors import InputError
from workflow.runs.installation import check_room, engine

EXAMPLES = """
wf sweep study.toml --dry-run                 the points and what they would cost
wf sweep study.toml --jobs 2                  compute them, two at a time, into runs/study
wf sweep study.toml --adopt runs              take finished runs of the same scenes from runs
wf status runs/study                          where it stands
wf sweep study.toml --retry                   once more what failed
wf sweep study.toml --scheduler slurm --time 12:00:00 --partition long
                                              as a job array; the same command submits what is left,
                                              and with --dry-run prints the script instead

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
    add_jobs(parser)


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """What every command that computes a study takes."""
    parser.add_argument("--jobs", type=int, metavar="J", help="runs at a time (default 1; in a job array no limit)")
    parser.add_argument("--retry", action="store_true", help="run again what failed")
    parser.add_argument("--adopt", type=Path, action="append", default=[], metavar="DIR",
                        help="link finished runs of the same scenes found there (repeatable)")  # fmt: skip
    parser.add_argument("--any-deck", action="store_true",
                        help="adopt and continue also runs whose deck another version made of the scene")  # fmt: skip
    parser.add_argument("--dry-run", action="store_true", help="say what would be computed; write nothing")
    parser.add_argument("--ranks", type=int, metavar="R", help="MPI ranks of a run (default 1)")
    add_oversubscribe(parser)
    add_cluster(parser)


def action(arguments: argparse.Namespace) -> int:
    """Declare the study, compute it."""
    check_jobs(arguments)
    profile = job_of(arguments, local=("ranks",))
    folder = arguments.out or Path("runs") / arguments.file.stem
    study = Study(folder, read_sweep(arguments.file))
    if arguments.dry_run:
        print(plan(study, profile, arguments))
        return 0
    if profile:
        return send(study, profile, arguments)
    outcome = carry_out(study, arguments, ranks=arguments.ranks)
    if not outcome.interrupted and write_results(study):
        print(folder / RESULTS)
    print(f"{folder}: {outcome.done} of {len(study.points)} points done")
    return ended(outcome)


def check_jobs(arguments: argparse.Namespace) -> None:
    """Before anything is written."""
    for name in ("jobs", "ranks"):
        value = getattr(arguments, name, None)
        if value is not None and value < 1:
            raise InputError(f"--{name} {value} is not allowed: it must be at least 1")


def send(study: Study, profile: Profile, arguments: argparse.Namespace) -> int:
    """Write down the study, adopt what is there, submit the rest."""
    engine()
    declare_and_adopt(study, arguments)
    sent = submit(study, profile, at_once=arguments.jobs, retry=arguments.retry)
    if sent:
        number, points, tasks = sent
        print(f"submitted {points} points as {tasks} tasks of job {number}; 'wf status {shlex.quote(str(study.folder))}' "
              "shows how far they are", file=sys.stderr)  # fmt: skip
        return 0
    if write_results(study):
        print(study.folder / RESULTS)
    print("nothing to submit: every point is done, in the queue, or failed (--retry tries those again)", file=sys.stderr)
    return 0


def carry_out(study: Study, arguments: argparse.Namespace, *, ranks: int | None = None) -> Outcome:
    """Write down the study, adopt what is there, compute the rest."""
    check_room(ranks or 1, oversubscribe=arguments.oversubscribe)
    engine()
    declare_and_adopt(study, arguments)
    options = [name for name in ("--any-deck", "--oversubscribe") if getattr(arguments, name[2:].replace("-", "_"))]
    options += ["--anew"] if arguments.retry else []
    outcome = compute(study, jobs=arguments.jobs or 1, ranks=ranks, retry=arguments.retry, options=options)
    if outcome.elsewhere:
        print(f"{outcome.elsewhere} points are left to another wf that works on them", file=sys.stderr)
    if outcome.interrupted:
        print("wf: interrupted; the same command continues", file=sys.stderr)
    elif outcome.failed:
        print(f"wf: {outcome.failed} points failed: 'wf status {shlex.quote(str(study.folder))}' says why, --retry tries again",
              file=sys.stderr)  # fmt: skip
    return outcome


def declare_and_adopt(study: Study, arguments: argparse.Namespace) -> None:
    """Write down the study, link what is there."""
    study.save()
    adopted, left = study.adopt([study.folder, *arguments.adopt], any_deck=arguments.any_deck)
    if adopted:
        print(f"adopted {adopted} finished runs", file=sys.stderr)
    if left:
        print(
            f"{left} finished runs have a deck that another version made of the scene; --any-deck adopts them", file=sys.stderr
        )


def ended(outcome: Outcome) -> int:
    """The exit status."""
    return 130 if outcome.interrupted else int(outcome.failed > 0)


def plan(study: Study, profile: Profile | None, arguments: argparse.Namespace) -> str:
    """One line per point, then what is left to compute, and of a job the script that would be submitted."""
    standings = [study.standing(point) for point in study.points]
    rows = [f"{now.status:11s} {point.name}  {study.label(point)}" for point, now in zip(study.points, standings, strict=True)]
    done = sum(now.status == DONE for now in standings)
    left = remaining(study.points, standings)
    cost = f", about {duration(left)} of one core" if left else ""
    job = [preview(study, profile, at_once=arguments.jobs, retry=arguments.retry)] if profile else []
    return "\n".join([*rows, f"{len(study.points)} points, {done} done{cost}", *job])

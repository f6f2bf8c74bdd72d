"""wf run: scene -> run directory -> engine -> archive and measures."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from pathlib import Path
from typing import Any

from workflow.cli.lists import whole_number
from workflow.cli.options import command
from workflow.cli.scenes import add_scene, scene_of
from workflow.pipeline.collect import stored_measures
from workflow.pipeline.run import run
from workflow.reports.summary import summary
from workflow.runs.directory import INTERRUPTED, RunDirectory, default_directory
from workflow.runs.installation import check_room, engine

EXAMPLES = """
wf run method1 --phi0 0.36                            the cohesive packing of G07 table III
wf run method1 --no-cohesion --mu 0.15 --out dense    without cohesion, into directory dense
wf run consolidation --rolling --unload                an aggregate from P* = 0.001 to 10 and back
wf run scene.toml --seed 2 --ranks 2                  a scene from a file, another seed, two MPI ranks

a scene file holds the options as names and values; every run writes the one that repeats it:
  scene = "method1"
  phi0 = 0.36
  cohesion = false
"""
NOT_IN_EQUILIBRIUM = 3  # exit status of a run that came to the end of its time instead


def declare(commands: Any) -> None:
    """Options of `wf run`."""
    parser = command(commands, "run", "run a scene and measure the result", EXAMPLES, action=action)
    groups = add_scene(parser)
    groups["output"].add_argument("--out", type=Path, metavar="DIR", help="run directory (default runs/NAME-HASH)")
    add_run_options(groups["numerics"], groups["output"])


def add_run_options(numerics: Any, output: Any, ranks: int | None = 1) -> None:
    """What run and resume share, in groups of their parser; ``ranks``: default, None for those of the run."""
    text = "MPI ranks (default 1)" if ranks else "MPI ranks (default: those of the run)"
    numerics.add_argument("--ranks", type=whole_number, default=ranks, metavar="R", help=text)
    add_oversubscribe(numerics)
    output.add_argument("--json", action="store_true", help="print the measures as JSON")


def action(arguments: argparse.Namespace) -> int:
    """Create the directory and run it."""
    check_ranks(arguments)
    scene = scene_of(arguments)
    engine()  # a missing plugin or engine is said before anything is written
    directory = RunDirectory.create(arguments.out or default_directory(scene), scene, ranks=arguments.ranks)
    print(f"{scene.title}\n{scene.sample}, directory {directory.path}", *scene.notes(), sep="\n", file=sys.stderr)
    return finish(directory, arguments, resume=False)


def add_oversubscribe(parser: Any) -> None:
    """What commands that start ranks on this machine share."""
    parser.add_argument("--oversubscribe", action="store_true", help="allow more ranks than this machine has cores")


def check_ranks(arguments: argparse.Namespace) -> None:
    """Before anything is written."""
    check_room(arguments.ranks, oversubscribe=arguments.oversubscribe)


def finish(
    directory: RunDirectory, arguments: argparse.Namespace, *, resume: bool, any_deck: bool = False, anew: bool = False
) -> int:
    """Run or continue, then show the result."""
    status = run(directory, ranks=arguments.ranks, resume=resume, any_deck=any_deck, anew=anew)
    if status == INTERRUPTED:
        print(f"wf: interrupted; continue with 'wf resume {shlex.quote(str(directory.path))}'", file=sys.stderr)
        return 130
    measures = stored_measures(directory)
    print(json.dumps(measures, indent=1) if arguments.json else summary(measures, directory))
    if directory.equilibrium() is not False:
        return 0
    words = f"'wf resume {shlex.quote(str(directory.path))} --max-time T' gives each stage more"
    print(f"wf: not in equilibrium: the time of a stage was over; {words}", file=sys.stderr)
    return NOT_IN_EQUILIBRIUM

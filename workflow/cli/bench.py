"""wf bench: nanoseconds per grain and step beside other engines."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from workflow.cli.lists import grains, listed, one_of, positive, whole_number
from workflow.cli.options import command
from workflow.cli.run import add_oversubscribe
from workflow.data.table import write_csv
from workflow.errors import InputError
from workflow.runs.directory import RunDirectory
from workflow.runs.installation import check_room, engine
from workflow.verification.bench import ENGINES, PROGRAMS, STATES, State, bench, missing, own_states
from workflow.verification.bench_states import state_of_run
from workflow.verification.tables import bench_table

EXAMPLES = """
wf bench                                          1400 grains, gas and dense, every installed engine
wf bench --n 1400,5600,50000 --ranks 1,2          sizes and MPI ranks; lists take commas or blanks
wf bench --state dense --engines exact,granular --json
wf bench --engines exact --switches               what the switches of a scene save, what a barostat costs
wf bench --engines exact --against ENV/bin/python  beside the exact law of another installation
wf bench dense                                    on the last frame of a run made with --no-cohesion
"""


def declare(commands: Any) -> None:
    """Options of `wf bench`."""
    parser = command(
        commands, "bench", "time the exact law beside LAMMPS's own contact styles and other programs", EXAMPLES, action=action
    )
    parser.usage = f"{parser.prog} [DIR] [options]"  # a list would take a DIR that follows it
    parser.add_argument("directory", type=Path, nargs="?", metavar="DIR",
                        help="run directory whose last frame is the state (default: states are made)")  # fmt: skip
    for flag, sign, text in (
        ("--n", "N", "numbers of grains (default 1400)"),
        ("--state", "S", f"states to make (default {','.join(STATES)})"),
        ("--engines", "E", f"engines (default {','.join(ENGINES)})"),
        ("--ranks", "R", "numbers of MPI ranks (default 1)"),
    ):
        parser.add_argument(flag, nargs="+", action="extend", metavar=sign, help=text)
    add_oversubscribe(parser)
    parser.add_argument("--rounds", type=whole_number, default=5, metavar="R", help="rounds, engines taking turns (default 5)")
    parser.add_argument(
        "--steps", type=whole_number, metavar="K", help="timed steps (default: 1e7 grain-steps, at least 500 steps)"
    )
    parser.add_argument("--switches", action="store_true", help="also the exact law with parts of it left out or added")
    parser.add_argument("--against", type=Path, metavar="PYTHON",
                        help="also the exact law of the installation that this Python has, taking turns")  # fmt: skip
    parser.add_argument("--csv", type=Path, metavar="FILE", help="also write the table as CSV")
    parser.add_argument("--json", action="store_true", help="print JSON")


def action(arguments: argparse.Namespace) -> int:
    """Time and print."""
    engines = listed("--engines", arguments.engines or ENGINES, one_of(ENGINES))
    ranks = listed("--ranks", arguments.ranks or ["1"], positive)
    if 1 not in ranks and not set(engines) - set(PROGRAMS):
        raise InputError(f"{' and '.join(engines)} are timed on one rank only; give --ranks 1 too, or another engine")
    check_room(max(ranks), oversubscribe=arguments.oversubscribe)
    for name in ("rounds", "steps"):
        if getattr(arguments, name) is not None:
            positive(str(getattr(arguments, name)), f"--{name}")
    if arguments.csv and not arguments.csv.parent.is_dir():
        raise InputError(f"--csv '{arguments.csv}': there is no directory '{arguments.csv.parent}'; make it first")
    if arguments.against and not shutil.which(arguments.against):
        raise InputError(f"--against '{arguments.against}' is no program; give the Python of an environment, ENV/bin/python")
    states, common = state_of_run(_alone(arguments)) if arguments.directory else (_made(arguments), {})
    engine()
    for name in missing(engines):
        print(f"{name} not installed: apt-get install {name}", file=sys.stderr)
    timings = bench(states, engines, ranks=ranks, rounds=arguments.rounds, steps=arguments.steps,
                    switches=arguments.switches, common=common, against=arguments.against)  # fmt: skip
    if arguments.csv:
        write_csv(arguments.csv, timings)
    print(json.dumps([asdict(timing) for timing in timings], indent=1) if arguments.json else bench_table(timings))
    return 0


def _made(arguments: argparse.Namespace) -> list[tuple[str, State]]:
    return own_states(
        listed("--n", arguments.n or ["1400"], grains(50)),  # fewer have a dense cell too small for the list
        listed("--state", arguments.state or STATES, one_of(STATES)),
    )


def _alone(arguments: argparse.Namespace) -> RunDirectory:
    """The run whose last frame is the state.  Raises InputError if states are asked for too."""
    if arguments.n or arguments.state or arguments.against:
        raise InputError("--n, --state and --against are for states that are made; leave them out or leave out DIR")
    return RunDirectory.open(arguments.directory)

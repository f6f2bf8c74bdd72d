"""wf bench: nanoseconds per grain and step beside other engines."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

from workflow.archive.read import Archive
from workflow.cli.options import command, whole_number
from workflow.cli.run import add_oversubscribe
from workflow.data.table import write_csv
from workflow.errors import InputError
from workflow.pipeline.archived import archived
from workflow.pipeline.collect import ARCHIVE
from workflow.runs.directory import RunDirectory
from workflow.runs.installation import check_room, engine
from workflow.scene.method1 import Method1
from workflow.verification.bench import ENGINES, PROGRAMS, STATES, State, Timing, bench, missing, own_states
from workflow.verification.bench_states import of_frame

EXAMPLES = """
wf bench                                          1400 grains, gas and dense, every installed engine
wf bench --n 1400,5600,50000 --ranks 1,2          sizes and MPI ranks; lists take commas or blanks
wf bench --state dense --engines exact,granular --json
wf bench --engines exact --switches               what the switches of a scene save, what a barostat costs
wf bench dense                                    on the last frame of a run made with --no-cohesion
"""
TITLES = f"{'ns per grain and step':26s}  median    least ..   most  /hooke  /exact   pair  neigh   comm modify  other"
Item = TypeVar("Item")


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
    parser.add_argument("--rounds", type=int, default=5, metavar="R", help="rounds, engines taking turns (default 5)")
    parser.add_argument("--steps", type=int, metavar="K", help="timed steps (default: 1e7 grain-steps, at least 500 steps)")
    parser.add_argument("--switches", action="store_true", help="also the exact law with parts of it left out or added")
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
    states, common = _given(arguments) if arguments.directory else (_made(arguments), {})
    engine()
    for name in missing(engines):
        print(f"{name} not installed: apt-get install {name}", file=sys.stderr)
    timings = bench(states, engines, ranks=ranks, rounds=arguments.rounds, steps=arguments.steps,
                    switches=arguments.switches, common=common)  # fmt: skip
    if arguments.csv:
        write_csv(arguments.csv, timings)
    print(json.dumps([asdict(timing) for timing in timings], indent=1) if arguments.json else table(timings))
    return 0


def _made(arguments: argparse.Namespace) -> list[tuple[str, State]]:
    return own_states(
        listed("--n", arguments.n or ["1400"], grains(50)),  # fewer have a dense cell too small for the list
        listed("--state", arguments.state or STATES, one_of(STATES)),
    )


def _given(arguments: argparse.Namespace) -> tuple[list[tuple[str, State]], dict[str, object]]:
    """The last frame of a run as the only state, with the law and step of the run."""
    if arguments.n or arguments.state:
        raise InputError("--n and --state are for states that are made; leave them out or leave out DIR")
    directory = RunDirectory.open(arguments.directory)
    scene = directory.scene
    law = scene.law_of(list(scene.stages.values())[-1])
    if law is None or scene.cohesive:
        raise InputError(
            f"'{directory.path}' is no packing without cohesion, what LAMMPS's own styles can hold together; "
            "give a run made with --no-cohesion"
        )
    archived(directory)
    with Archive(directory / ARCHIVE) as archive:
        discs = of_frame(archive.frame(-1))
    common: dict[str, object] = {"kn": law.kn, "zeta": law.zeta, "mu": law.mu, "step": scene.step_choice.step}
    return [(directory.path.name, lambda folder: discs)], common


def listed(option: str, given: str | Sequence[str], read: Callable[[str, str], Item]) -> list[Item]:
    """The words of an option, between commas or blanks, each once, as ``read`` understands them."""
    words = (given if isinstance(given, str) else ",".join(given)).replace(" ", ",").split(",")
    found = list(dict.fromkeys(read(word, option) for word in words if word))
    if not found:
        raise InputError(f"{option} is empty; give at least one word, or leave it out")
    return found


def positive(word: str, option: str, least: int = 1) -> int:
    """A whole number of at least ``least``; InputError if it is none."""
    if not word.isdigit() or int(word) < least:
        raise InputError(f"{option} '{word}' is not allowed: give whole numbers of at least {least}")
    return int(word)


def grains(least: int) -> Callable[[str, str], int]:
    """A reader of numbers of grains, also written 1e5, as many as a scene can have."""

    def read(word: str, option: str) -> int:
        try:
            count = positive(str(whole_number(word)), option, least)
        except (ValueError, OverflowError, argparse.ArgumentTypeError):
            raise InputError(f"{option} '{word}' is not allowed: give whole numbers of at least {least}") from None
        Method1(n=count)  # says what no scene can have
        return count

    return read


def one_of(names: Sequence[str]) -> Callable[[str, str], str]:
    """A reader of one of ``names``."""

    def read(word: str, option: str) -> str:
        if word not in names:
            raise InputError(f"{option} '{word}' is not known; known are: {', '.join(names)}")
        return word

    return read


def table(timings: Sequence[Timing]) -> str:
    """The timings in words, one block per state."""
    lines: list[str] = []
    for timing in timings:
        head = (
            f"{timing.state}, {timing.n} grains, {timing.ranks} rank{'s' * (timing.ranks > 1)}, "
            f"{timing.rounds} rounds of {timing.steps} steps"
        )
        if head not in lines:
            lines += ["", head, TITLES]
        parts = " ".join(_shown(part, 6, 1) for part in (timing.pair, timing.neigh, timing.comm, timing.modify, timing.other))
        lines.append(
            f"{timing.engine:26s} {timing.ns_per_grain_step:7.1f}  {timing.least:7.1f} .. {timing.most:6.1f} "
            f"{_shown(timing.ratio, 7, 2)} {_shown(timing.ratio_to_exact, 7, 2)} {parts}"
        )
    return "\n".join(lines[1:])


def _shown(value: float | None, width: int, digits: int) -> str:
    return "-".rjust(width) if value is None else f"{value:{width}.{digits}f}"

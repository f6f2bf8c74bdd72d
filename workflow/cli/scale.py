"""wf scale: time and memory of scenes of many grains, and an estimate for a cluster."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from workflow.cli.bench import grains, listed, one_of, positive
from workflow.cli.options import command, whole_number
from workflow.cli.run import add_oversubscribe
from workflow.data.table import write_csv
from workflow.errors import InputError
from workflow.runs.installation import check_room, engine
from workflow.verification.scale import STATES, Estimate, Stage, estimate, scale

EXAMPLES = """
wf scale                                          1e5 grains, a gas and a packing, on 1 and 2 ranks
wf scale --n 1e5,1e6 --steps 2000 --csv scale.csv
wf scale --for 1e8 --over 4096                    and what 1e8 grains on 4096 ranks would need
"""
LEAST = 2000  # grains: fewer tell nothing


def declare(commands: Any) -> None:
    """Options of `wf scale`."""
    parser = command(commands, "scale", "measure time and memory of every stage of large scenes", EXAMPLES, action=action)
    parser.add_argument("--n", default="1e5", metavar="N,...", help="numbers of grains (default 1e5)")
    parser.add_argument("--state", default=",".join(STATES), metavar="S,...", help="states (default %(default)s)")
    parser.add_argument("--ranks", default="1,2", metavar="R,...", help="numbers of MPI ranks (default 1,2)")
    add_oversubscribe(parser)
    parser.add_argument("--steps", type=int, default=1000, metavar="K", help="steps of each run (default 1000)")
    parser.add_argument("--out", type=Path, default=Path("scale"), metavar="DIR", help="where to work (default scale)")
    parser.add_argument("--for", dest="wanted", type=whole_number, metavar="N", help="estimate for so many grains")
    parser.add_argument("--over", type=whole_number, default=1024, metavar="R", help="on so many ranks (default 1024)")
    parser.add_argument("--bandwidth", type=float, default=10.0, metavar="B", help="of its file system [GB/s] (default 10)")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="also write the table as CSV")
    parser.add_argument("--json", action="store_true", help="print JSON")


def action(arguments: argparse.Namespace) -> int:
    """Measure and print."""
    counts = listed("--n", arguments.n, grains(LEAST))
    states, ranks = listed("--state", arguments.state, one_of(STATES)), listed("--ranks", arguments.ranks, positive)
    if arguments.steps < 1 or arguments.over < 1 or not arguments.bandwidth > 0 or (arguments.wanted or 1) < 1:
        raise InputError("--steps, --for, --over and --bandwidth must be above 0")
    if 1 not in ranks:
        raise InputError(f"--ranks {arguments.ranks} is not allowed: give 1 too, from which the others are judged")
    check_room(max(ranks), oversubscribe=arguments.oversubscribe)
    engine()
    if arguments.out.exists() and (not arguments.out.is_dir() or any(arguments.out.iterdir())):
        raise InputError(f"'{arguments.out}' exists and is not empty; nothing was changed. Give another --out DIR")
    rows = scale(counts, states, ranks, arguments.steps, arguments.out)
    wanted = arguments.wanted
    of = [[row for row in rows if row.state == state] for state in states]
    estimates = [estimate(some, wanted, arguments.over, arguments.bandwidth) for some in of] if wanted else []
    if arguments.csv:
        write_csv(arguments.csv, rows)
    if arguments.json:
        tables = {"stages": map(asdict, rows), "estimates": map(asdict, estimates)}
        print(json.dumps({name: list(table) for name, table in tables.items()}, indent=1))
    else:
        print("\n".join([*table(rows), *(line for one in estimates for line in estimate_lines(one))]))
    return 0


def table(rows: Sequence[Stage]) -> list[str]:
    """The stages for people, one block per scene."""
    lines: list[str] = []
    for row in rows:
        head = f"{row.state}, {row.n} grains"
        if head not in lines:
            titles = f"{'stage':30s} ranks   seconds  processor  peak GB  bytes/grain  ns/grain/step      MB   ghosts"
            lines += ["", head, titles]
        numbers = f"{row.seconds:9.1f} {row.processor_seconds:10.1f} {row.peak_GB:8.2f} {row.bytes_per_grain:12.0f}"
        rest = f"{_shown(row.ns_per_grain_step, 14, 2)} {_shown(row.MB, 7, 0)} {_shown(row.ghosts, 8, 0)}"
        lines.append(f"{row.stage:30s} {row.ranks:5d} {numbers} {rest}")
    return lines[1:]


def _shown(value: float | None, width: int, digits: int) -> str:
    return "-".rjust(width) if value is None else f"{value:{width}.{digits}f}"


def estimate_lines(one: Estimate) -> list[str]:
    """An estimate for people."""
    return [
        "",
        f"estimate: {one.state}, {one.n:.3g} grains on {one.ranks} ranks, {one.grains_per_rank:.0f} grains each",
        f"memory of a rank        {one.memory_GB:.3f} GB",
        f"a million steps         {one.seconds_per_million_steps / 3600:.2f} h",
        f"messages of a rank      {one.sent_kB:.1f} kB a step for {one.ghosts:.0f} ghosts, {one.sent_MB_per_second:.0f} MB/s",
        f"data file               {one.data_GB:.1f} GB",
        f"frame                   {one.frame_GB:.1f} GB as text in at most {one.frame_seconds:.0f} s through one rank, "
        f"{one.archive_GB:.1f} GB in the archive",
        f"restart                 {one.restart_GB:.1f} GB in {one.restart_seconds:.0f} s through one rank, "
        f"{one.restart_seconds_parallel:.1f} s at {one.bandwidth:g} GB/s",
    ]

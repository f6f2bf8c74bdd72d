"""wf scale: time and memory of scenes of many grains, and an estimate for a cluster."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from workflow.cli.lists import add_list, grains, listed, one_of, positive, whole_number
from workflow.cli.options import command
from workflow.cli.parser import number
from workflow.cli.run import add_oversubscribe
from workflow.data.table import write_csv
from workflow.errors import InputError
from workflow.runs.installation import check_room, engine
from workflow.verification.scale import STATES, estimate, scale
from workflow.verification.tables import estimate_lines, scale_table

EXAMPLES = """
wf scale                                          1e5 grains, a gas and a packing, on 1 and 2 ranks
wf scale --n 1e5,1e6 --steps 2000 --csv scale.csv
wf scale --for 1e8 --over 4096                    and what 1e8 grains on 4096 ranks would need
"""
LEAST = 2000  # grains: fewer tell nothing


def declare(commands: Any) -> None:
    """Options of `wf scale`."""
    parser = command(commands, "scale", "measure time and memory of every stage of large scenes", EXAMPLES, action=action)
    add_list(parser, "--n", "N", "numbers of grains (default 1e5)")
    add_list(parser, "--state", "S", f"states (default {','.join(STATES)})")
    add_list(parser, "--ranks", "R", "numbers of MPI ranks (default 1,2)")
    add_oversubscribe(parser)
    parser.add_argument("--steps", type=whole_number, default=1000, metavar="K", help="steps of each run (default 1000)")
    parser.add_argument("--out", type=Path, default=Path("scale"), metavar="DIR", help="where to work (default scale)")
    parser.add_argument("--for", dest="wanted", type=whole_number, metavar="N", help="estimate for so many grains")
    parser.add_argument("--over", type=whole_number, default=1024, metavar="R", help="on so many ranks (default 1024)")
    parser.add_argument("--bandwidth", type=number, default=10.0, metavar="B", help="of its file system [GB/s] (default 10)")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="also write the table as CSV")
    parser.add_argument("--json", action="store_true", help="print JSON")


def action(arguments: argparse.Namespace) -> int:
    """Measure and print."""
    counts = listed("--n", arguments.n or "1e5", grains(LEAST))
    states = listed("--state", arguments.state or STATES, one_of(STATES))
    ranks = listed("--ranks", arguments.ranks or "1,2", positive)
    if arguments.steps < 1 or arguments.over < 1 or not arguments.bandwidth > 0 or (arguments.wanted or 1) < 1:
        raise InputError("--steps, --for, --over and --bandwidth must be above 0")
    if 1 not in ranks:
        raise InputError(f"--ranks {','.join(map(str, ranks))} is not allowed: give 1 too, from which the others are judged")
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
        print("\n".join([*scale_table(rows), *(line for one in estimates for line in estimate_lines(one))]))
    return 0

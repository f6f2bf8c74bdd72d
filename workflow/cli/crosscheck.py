"""wf crosscheck: the same cohesionless discs in LIGGGHTS and YADE."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from workflow.cli.lists import add_list, listed, one_of, positive, whole_number
from workflow.cli.options import command
from workflow.cli.parser import number
from workflow.data.files import writable_folder
from workflow.runs.installation import engine
from workflow.scene.method1 import Method1
from workflow.verification.crosscheck import means, packings, prepare_packings
from workflow.verification.crosscheck_few import few_bodies
from workflow.verification.other_engines import PEERS
from workflow.verification.pages import write_crosscheck
from workflow.verification.tables import few_table, packing_table

EXAMPLES = """
wf crosscheck                                a few discs, and packings of 400 grains from three seeds: ten minutes
wf crosscheck --parts few                    two or three discs only, a minute
wf crosscheck --n 1400 --seeds 1,2,3,4,5     larger packings (hours)
wf crosscheck --deck-only --out decks        the decks of LIGGGHTS and YADE, nothing run
"""
PARTS = ("few", "packings")


def declare(commands: Any) -> None:
    """Options of `wf crosscheck`."""
    parser = command(commands, "crosscheck", "compare with LIGGGHTS and YADE on the same discs", EXAMPLES, action=action)
    parser.add_argument("--n", type=whole_number, default=400, metavar="N", help="grains of a packing (default 400)")
    add_list(parser, "--seeds", "S", "seeds of the packings (default 1,2,3)")
    parser.add_argument("--mu", type=number, default=0.5, metavar="mu", help="friction of the packings (default 0.5)")
    parser.add_argument("--zeta", type=number, default=0.8, metavar="zeta", help="damping of the packings (default 0.8)")
    parser.add_argument("--phi0", type=number, default=0.36, metavar="Phi_I", help="initial solid fraction (default 0.36)")
    add_list(parser, "--engines", "E", f"programs (default {','.join(PEERS)})")
    add_list(parser, "--parts", "P", f"what to compare (default {','.join(PARTS)})")
    parser.add_argument("--deck-only", action="store_true", help="write decks and grains, run nothing")
    parser.add_argument(
        "--out", type=Path, default=Path("crosscheck"), metavar="DIR", help="where to write (default crosscheck)"
    )
    parser.add_argument("--json", action="store_true", help="print JSON")


def action(arguments: argparse.Namespace) -> int:
    """Compare and print; 1 if no other program is installed."""
    parts = listed("--parts", arguments.parts or PARTS, one_of(PARTS))
    chosen = listed("--engines", arguments.engines or list(PEERS), one_of(list(PEERS)))
    scenes = _scenes(arguments)
    writable_folder(arguments.out)
    if arguments.deck_only:
        for folder in prepare_packings(scenes, chosen, arguments.out):
            print(f"{folder}/run.sh")
        return 0
    engine()
    here = [name for name in chosen if shutil.which(name)]
    for name in chosen:
        if name not in here:
            print(f"{name} not installed: apt-get install {name}", file=sys.stderr)
    few = few_bodies(here) if "few" in parts else []
    made = packings(scenes, here, arguments.out) if "packings" in parts else []
    packed = [result.row for result in made]
    write_crosscheck(arguments.out, few, made)
    averages = means(packed) if packed else []
    if arguments.json:
        tables = {"few_bodies": map(asdict, few), "packings": map(asdict, packed), "means": map(asdict, averages)}
        print(json.dumps({name: list(rows) for name, rows in tables.items()}, indent=1))
    else:
        print("\n".join([*few_table(few), *packing_table(packed, averages)]))
    return 0 if here else 1


def _scenes(arguments: argparse.Namespace) -> list[Method1]:
    """The packings to make."""
    values = {name: getattr(arguments, name) for name in ("n", "mu", "zeta", "phi0")}
    seeds = listed("--seeds", arguments.seeds or "1,2,3", partial(positive, least=0))
    # the decks of the other programs have the cell of eq. 3
    return [Method1(cohesion=False, seed=seed, cell="strain", **values) for seed in seeds]

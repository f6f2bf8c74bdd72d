"""wf crosscheck: the same cohesionless discs in LIGGGHTS and YADE."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from workflow.cli.bench import listed, one_of
from workflow.cli.options import command
from workflow.data.table import write_csv
from workflow.errors import InputError
from workflow.runs.installation import engine
from workflow.scene.method1 import Method1
from workflow.verification.crosscheck import Mean, Packed, Result, at_rest, grains, means, packings, place_of, values_of
from workflow.verification.crosscheck_few import Few, few_bodies
from workflow.verification.other_engines import PEERS, prepare

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
    parser.add_argument("--n", type=int, default=400, metavar="N", help="grains of a packing (default 400)")
    parser.add_argument("--seeds", default="1,2,3", metavar="S,...", help="seeds of the packings (default 1,2,3)")
    parser.add_argument("--mu", type=float, default=0.5, metavar="mu", help="friction of the packings (default 0.5)")
    parser.add_argument("--zeta", type=float, default=0.8, metavar="zeta", help="damping of the packings (default 0.8)")
    parser.add_argument("--phi0", type=float, default=0.36, metavar="Phi_I", help="initial solid fraction (default 0.36)")
    parser.add_argument("--engines", default=",".join(PEERS), metavar="E,...", help="programs (default %(default)s)")
    parser.add_argument("--parts", default=",".join(PARTS), metavar="P,...", help="what to compare (default %(default)s)")
    parser.add_argument("--deck-only", action="store_true", help="write decks and grains, run nothing")
    parser.add_argument(
        "--out", type=Path, default=Path("crosscheck"), metavar="DIR", help="where to write (default crosscheck)"
    )
    parser.add_argument("--json", action="store_true", help="print JSON")


def action(arguments: argparse.Namespace) -> int:
    """Compare and print; 1 if no other program is installed."""
    parts = listed("--parts", arguments.parts, one_of(PARTS))
    chosen = listed("--engines", arguments.engines, one_of(PEERS))
    scenes = _scenes(arguments)
    try:
        arguments.out.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise InputError(f"cannot create '{arguments.out}': {fault.strerror}; give a writable --out DIR") from fault
    if arguments.deck_only:
        for scene in scenes:
            discs = grains(scene)
            for name in chosen:
                folder = place_of(arguments.out, scene, name)
                prepare(folder, name, discs, scene.law_in_units, values_of(scene, None), *at_rest(discs))
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
    _write(arguments.out, few, made)
    if arguments.json:
        averages = means(packed) if packed else []
        tables = {"few_bodies": map(asdict, few), "packings": map(asdict, packed), "means": map(asdict, averages)}
        print(json.dumps({name: list(rows) for name, rows in tables.items()}, indent=1))
    else:
        print("\n".join([*few_table(few), *packing_table(packed)]))
    return 0 if here else 1


def _scenes(arguments: argparse.Namespace) -> list[Method1]:
    """The packings to make."""
    values = {name: getattr(arguments, name) for name in ("n", "mu", "zeta", "phi0")}
    seeds = arguments.seeds.split(",")
    if not all(seed.strip().isdigit() for seed in seeds):
        raise InputError(f"--seeds '{arguments.seeds}' is not allowed: give whole numbers with commas, for example 1,2,3")
    # the decks of the other programs have the cell of eq. 3
    return [Method1(cohesion=False, seed=seed, cell="strain", **values) for seed in dict.fromkeys(map(int, seeds))]


def _write(out: Path, few: Sequence[Few], made: Sequence[Result]) -> None:
    """Tables and figures."""
    from workflow.verification.figures import FIGURES

    packed = [result.row for result in made]

    if few:
        write_csv(out / "few.csv", few)
        FIGURES["crosscheck"]["few"].draw(few, out / "few.png")
    if packed:
        write_csv(out / "packings.csv", packed)
        write_csv(out / "means.csv", means(packed))
        FIGURES["crosscheck"]["packings"].draw(made, out / "packings.png")


def few_table(rows: Sequence[Few]) -> list[str]:
    """Few bodies: for each case and engine the errors at the coarsest and finest step."""
    if not rows:
        return []
    coarse, fine = min(r.steps_per_period for r in rows), max(r.steps_per_period for r in rows)
    table = {(row.case, row.engine, row.steps_per_period): row for row in rows}
    heads = "".join(f"{f'{many:g} steps':>14s}" for many in (coarse, fine, coarse, fine))
    lines = [
        "few discs, rms over groups of the largest difference of positions, velocities, surface velocities; steps per period",
        f"{'':50s}{'to the reference of our law':>28s}{'to granular of LAMMPS':>28s}",
        f"{'case':26s}{'engine':24s}{heads}",
    ]
    for case, name in dict.fromkeys((row.case, row.engine) for row in rows):
        first, last = table[case, name, coarse], table[case, name, fine]
        lines.append(
            f"{case:26s}{name:24s}{first.error:14.1e}{last.error:14.1e}{first.to_granular:14.1e}{last.to_granular:14.1e}"
        )
    return lines


def packing_table(rows: Sequence[Packed]) -> list[str]:
    """Packings: means over seeds with standard errors, differences seed by seed, distances of the force distributions."""
    if not rows:
        return []
    lines, found = (
        ["", f"packings of {rows[0].n} grains, {len({row.seed for row in rows})} seed(s): mean +- standard error"],
        means(rows),
    )
    for number in dict.fromkeys(mean.number for mean in found):
        lines += ["", f"{number.replace('_', ' '):26s}{'mean':>22s}{'difference to exact':>24s}"]
        lines += [_line(mean) for mean in found if mean.number == number]
    lines += ["", f"{'force distribution':26s}{'KS distance to exact':>22s}{'5 % level':>12s}{'kinetic energy':>18s}"]
    for name in dict.fromkeys(row.engine for row in rows):
        of = [row for row in rows if row.engine == name]
        ks, level, kinetic = (max(getattr(row, key) for row in of) for key in ("ks", "ks_critical", "kinetic"))
        lines.append(f"{name:26s}{f'{min(r.ks for r in of):.3f} .. {ks:.3f}':>22s}{level:12.3f}{kinetic:18.1e}")
    return lines


def _line(mean: Mean) -> str:
    def shown(value: float, error: float | None, sign: str = "") -> str:
        return f"{value:{sign}.4f}" + (f" +- {error:.4f}" if error is not None else "")

    apart = shown(mean.difference, mean.difference_error, "+") if mean.difference else ""
    return f"  {mean.engine:24s}{shown(mean.mean, mean.error):>22s}{apart:>24s}"

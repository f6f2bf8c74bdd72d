"""wf plot: figures of a run, of several samples, or of another program's dump."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from workflow.cli.options import command
from workflow.cli.sources import add_sources, sources_of
from workflow.reports.draw import draw
from workflow.reports.registry import FIGURES, STUDY

EXAMPLES = """
wf plot runs/method1-130aae48                          forces.png/.svg and history.png/.svg in that directory
wf plot runs/method1-130aae48 --out figures            elsewhere
wf plot runs/method1-130aae48 --frame 0 --format png   the first frame, PNG only
wf plot packing --figure stressed,cloud,angles         chosen figures; all: every one
wf plot sample1 sample2 sample3 --figure scattering    mean and standard error over samples
wf plot runs/method1-* runs/method2-* --figure density  both methods, solid fraction against time (G07 fig. 4)
wf plot runs/method2-130aae48 --figure pores           frames from P* = 0 to P* side by side (fig. 5)
wf plot runs/method2-* --figure agitation              z at P* = 0 against V0/V* (fig. 8)
wf plot runs/consolidation-* --figure consolidation    Phi and z against P*
wf plot grains.dump --contacts contacts.dump           LAMMPS dumps of another deck
wf plot runs/heap-4f1c09d2                             a heap: grains, vectors, forces, maps, film of its largest avalanche
"""


def declare(commands: Any) -> None:
    """Options of `wf plot`."""
    parser = command(
        commands, "plot", "draw the force network, the history and other figures", EXAMPLES + _table(), action=action
    )
    add_sources(parser)
    parser.add_argument("--figure", metavar="NAMES", help="figures, names with commas, or all (default: those with a *)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to write (default: the run directory)")
    parser.add_argument("--format", nargs="+", choices=("png", "svg"), default=["png", "svg"], help="file formats")


def _table() -> str:
    """The figures by group, under the examples of the help."""
    lines = ["", "figures (* drawn unasked), in groups that a scene has or has not:"]
    for group, figures in FIGURES.items():
        if all(figure.of != STUDY for figure in figures.values()):
            lines.append(f" {group}")
            lines += [f"  {name:17s}{figure.meaning}{' *' * figure.unasked}" for name, figure in figures.items()]
    return "\n".join(lines) + "\n"


def action(arguments: argparse.Namespace) -> int:
    """Draw the chosen figures and say where they are."""
    sources = sources_of(arguments)
    for path in draw(sources, arguments.figure, arguments.out or sources[0].folder, arguments.format):
        print(path)
    return 0

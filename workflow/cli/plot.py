"""wf plot: figures of a run, of several samples, or of another program's dump."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from workflow.cli.lists import listed, one_of
from workflow.cli.options import command
from workflow.cli.sources import add_sources, sources_of
from workflow.cli.terminal import overwrite
from workflow.data.files import writable_folder
from workflow.data.notes import tell
from workflow.errors import InputError
from workflow.pipeline.sources import Source
from workflow.reports.draw import ALL, draw
from workflow.reports.paper import COLUMN, DPI, FORMATS, PAGE, Paper, on
from workflow.reports.registry import FIGURES, STUDY

EXAMPLES = """
wf plot runs/method1-130aae48                          forces.png/.svg and history.png/.svg in that directory
wf plot runs/method1-130aae48 --out figures            elsewhere
wf plot runs/method1-130aae48 --frame 0 --format png   the first frame, PNG only
wf plot packing --figure stressed,cloud,angles         chosen figures; all: every one that applies
wf plot packing --format pdf --size 86                 PDF, one column of a journal wide
wf plot packing --film forces.mp4                      a film of all frames
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
    parser.add_argument("--figure", action="append", default=[], metavar="NAMES",
                        help=f"figures, names with commas, or {ALL}: what applies (default: those with a *)")  # fmt: skip
    parser.add_argument("--film", nargs="?", type=Path, const=Path(), metavar="FILE",
                        help="film of all frames, .mp4 (needs ffmpeg) or .gif (default: film.mp4, else film.gif, in the run "
                             "directory); beside it only the figures that are asked for")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to write (default: the run directory)")
    parser.add_argument("--format", nargs="+", action="extend", default=[], metavar="FORMATS",
                        help=f"{', '.join(FORMATS)}, names with commas (default png,svg)")  # fmt: skip
    parser.add_argument("--dpi", type=int, metavar="DOTS", help=f"dots per inch (default {DPI}, of a film 150)")
    parser.add_argument("--size", type=float, metavar="MM",
                        help=f"width of a figure in mm; {COLUMN:g} is one column of a journal, {PAGE:g} its page (default: as "
                             "each is meant)")  # fmt: skip


def _table() -> str:
    """The figures by group, under the examples of the help."""
    lines = ["", "figures (* drawn unasked), in groups that a scene has or has not:"]
    for group, figures in FIGURES.items():
        if all(figure.of != STUDY for figure in figures.values()):
            lines.append(f" {group}")
            lines += [f"  {name:17s}{figure.meaning}{' *' * figure.unasked}" for name, figure in figures.items()]
    return "\n".join(lines) + "\n"


def action(arguments: argparse.Namespace) -> int:
    """Draw the chosen figures and the film, say where they are, and why one is not drawn."""
    paper = Paper(arguments.size, arguments.dpi)
    formats = listed("--format", arguments.format or ["png", "svg"], one_of(FORMATS))
    asked = listed("--figure", arguments.figure, lambda word, _: word) if arguments.figure else []
    sources = sources_of(arguments)
    drawn = 0
    if arguments.film is None or asked:
        for made in draw(sources, asked, arguments.out or sources[0].folder, formats, paper):
            drawn += isinstance(made, Path)
            print(made, flush=True) if isinstance(made, Path) else tell([f"not drawn: {made.name}: {made.reason}"])
    if arguments.film is not None:
        _film(sources, arguments.film, arguments.out, paper)
        drawn += 1
    return 0 if drawn else 1


def _film(sources: Sequence[Source], path: Path, out: Path | None, paper: Paper) -> None:
    """Film the only source and say where the film is."""
    if len(sources) > 1:
        raise InputError(f"--film shows one run, '{sources[1].name}' is a second one; leave it out")
    from workflow.reports.film import film  # matplotlib is slow to import

    folder = writable_folder(out) if out else sources[0].folder
    begun = time.monotonic()

    def said(done: int, total: int) -> None:
        left = (time.monotonic() - begun) / done * (total - done)
        overwrite(f"film: frame {done} of {total}, {left:.0f} s left" if done < total else "")

    try:
        with on(paper):
            print(film(sources[0], None if path == Path() else path if out is None else folder / path, folder, said))
    finally:
        overwrite("")

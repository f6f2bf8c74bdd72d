"""Sources on the command line: run directories, and dumps of other programs with what the user knows of their law."""

from __future__ import annotations

import argparse
import glob
from functools import partial
from pathlib import Path

from workflow.archive.columns import CONTACT_HELP, LIGGGHTS
from workflow.archive.samples import Files, gathered
from workflow.cli.dumps import frame_of_dump, options_of, reading_of, refuse_without_dumps
from workflow.cli.lists import add_list, whole_number
from workflow.cli.parser import number
from workflow.errors import InputError
from workflow.pipeline.sources import Dumps, Run, Source
from workflow.runs.directory import RunDirectory


def add_sources(parser: argparse.ArgumentParser, *, measured: bool = True) -> None:
    """Positional sources, the frame, and what only dumps of other programs need.

    ``measured``: several sources, and the options of the measures; else one source, to be read only.
    """
    parser.add_argument("source", type=Path, nargs="*", metavar="DIR",
                        help="run directory, or LAMMPS dumps of grains, plain or compressed")  # fmt: skip
    parser.add_argument("--frame", type=whole_number, default=-1, metavar="K", help="frame, negative from the end (default -1)")
    if measured:
        parser.add_argument("--window", type=number, nargs=2, metavar=("KMIN", "KMAX"),
                            help="range of k of the fractal fit [1/a] (default: 2 pi/L to pi/a)")  # fmt: skip
        parser.add_argument("--spacing", type=number, metavar="S",
                            help="mesh of C(r) and of the grid holes [a] (default 0.01, coarser beyond 2e7 nodes)")  # fmt: skip
    group = parser.add_argument_group("dumps of other programs (docs/analysis.md)")
    group.add_argument("--contacts", type=Path, nargs="+", action="extend", default=[], metavar="FILE",
                       help=f"dumps local of the contacts: {CONTACT_HELP}")  # fmt: skip
    add_list(group, "--columns", "NAME=COLUMN", "columns of the dumps by their names here")
    group.add_argument("--liggghts", nargs="?", const="", action="append", metavar="KEYWORDS",
                       help="the contacts are of LIGGGHTS' compute pair/gran/local with these keywords, separated by commas "
                       f"(none: its default): {', '.join(LIGGGHTS)}")  # fmt: skip
    group.add_argument("--samples", action="store_true", help="several dumps are different samples, not steps of one")
    group.add_argument("--partial", action="store_true",
                       help="discs that overlap and are not in the table of contacts are no contacts (clumps, "
                            "bonds)")  # fmt: skip
    group.add_argument("--mu", type=number, help="friction coefficient; contacts without a flag slide where |T| reaches mu N")
    if measured:
        group.add_argument("--kn", type=number, default=1.0, help="normal stiffness K_N (default 1: moduli in units of it)")
        group.add_argument("--kt", type=number, help="tangential stiffness K_T (default K_N)")
    group.add_argument("--kr", type=number, default=0.0, help="rolling stiffness K_r; above 0: contacts resist rolling")
    group.add_argument("--f0", type=number, default=0.0, help="attraction F0 (default 0)")
    if measured:
        group.add_argument("--d0", type=number, help="its range D0")
        group.add_argument("--force-unit", type=number, metavar="F1", help="unit of force (default F0, or the mean |N|)")


def sources_of(arguments: argparse.Namespace) -> list[Source]:
    """The run directories, and the dumps gathered to samples with their contacts.  Raises InputError."""
    paths = [path for given in arguments.source for path in _expanded(given)]
    contacts = [path for given in arguments.contacts for path in _expanded(given)]
    if not paths:
        raise InputError("name a run directory or a dump of grains" + " before --contacts" * bool(contacts))
    if len({path.resolve() for path in paths}) < len(paths):
        raise InputError("a source is named twice; samples must be different runs")
    dumps = [path for path in paths if path.is_file()]
    if contacts and not dumps:
        raise InputError(f"--contacts {contacts[0]} goes with dumps of grains; the contacts of '{paths[0]}' are in it")
    refuse_without_dumps(arguments, dumps)
    options = options_of(arguments) if hasattr(arguments, "window") else {}
    runs: list[Source] = [Run(path, arguments.frame, options) for path in paths if not path.is_file()]
    samples = gathered(dumps, contacts, reading_of(arguments), apart=arguments.samples)
    return runs + [_of_dumps(files, arguments) for files in samples]


def _of_dumps(files: Files, arguments: argparse.Namespace) -> Source:
    """A sample of another program, with what the user says of it."""
    load = partial(frame_of_dump, files, arguments)
    return Dumps(files, lambda: files.sample(reading_of(arguments)), load, arguments.frame)


def _expanded(path: Path) -> list[Path]:
    """The files that a pattern in quotes names."""
    if path.exists() or not glob.has_magic(str(path)):
        return [path]
    found = sorted(glob.glob(str(path)))
    if not found:
        raise InputError(f"'{path}' names no file; check the pattern")
    return [Path(name) for name in found]


def one_source(arguments: argparse.Namespace) -> Source:
    """The only source.  Raises InputError for several."""
    found = sources_of(arguments)
    if len(found) > 1:
        raise InputError(f"'{found[1].name}' is a second source; give one run directory, or dumps of one sample")
    if isinstance(found[0], Run):
        RunDirectory.open(found[0].path)  # before anything is written
    return found[0]

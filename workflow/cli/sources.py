"""Where frames come from: run directories, and dumps of other programs with what the user knows of their law."""

from __future__ import annotations

import argparse
import glob
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from workflow.archive.columns import CONTACT_HELP, LIGGGHTS
from workflow.archive.read import Archive
from workflow.archive.samples import Files, gathered
from workflow.cli.dumps import frame_of_dump, options_of, reading_of
from workflow.data.frame import Frame
from workflow.errors import InputError
from workflow.measures.registry import Settings, chosen_groups
from workflow.pipeline.archived import archived
from workflow.pipeline.collect import ARCHIVE, measures_of, settings_of
from workflow.pipeline.dumps import measures_of_dump
from workflow.runs.directory import RunDirectory
from workflow.scene.heap import Heap
from workflow.scene.registry import Packed

Source = Path | Files  # a run directory, or the dumps of one sample


def add_sources(parser: argparse.ArgumentParser, *, measured: bool = True) -> None:
    """Positional sources, the frame, and what only dumps of other programs need.

    ``measured``: several sources, and the options of the measures; else one source, to be read only.
    """
    parser.add_argument("source", type=Path, nargs="*", metavar="DIR",
                        help="run directory, or LAMMPS dumps of grains, plain or compressed")  # fmt: skip
    parser.add_argument("--frame", type=int, default=-1, metavar="K", help="frame, negative from the end (default -1)")
    if measured:
        parser.add_argument("--window", type=float, nargs=2, metavar=("KMIN", "KMAX"),
                            help="range of k of the fractal fit [1/a] (default: 2 pi/L to pi/a)")  # fmt: skip
        parser.add_argument("--spacing", type=float, metavar="S",
                            help="mesh of C(r) and of the grid holes [a] (default 0.01, coarser beyond 2e7 nodes)")  # fmt: skip
    group = parser.add_argument_group("dumps of other programs (docs/analysis.md)")
    group.add_argument("--contacts", type=Path, nargs="+", default=[], metavar="FILE",
                       help=f"dumps local of the contacts: {CONTACT_HELP}")  # fmt: skip
    group.add_argument("--columns", default="", metavar="NAME=COLUMN,...", help="columns of the dumps by their names here")
    group.add_argument("--liggghts", nargs="?", const="", metavar="KEYWORDS",
                       help="the contacts are of LIGGGHTS' compute pair/gran/local with these keywords, separated by commas "
                       f"(none: its default): {', '.join(LIGGGHTS)}")  # fmt: skip
    group.add_argument("--samples", action="store_true", help="several dumps are different samples, not steps of one")
    group.add_argument("--partial", action="store_true",
                       help="discs that overlap and are not in the table of contacts are no contacts (clumps, "
                            "bonds)")  # fmt: skip
    group.add_argument("--mu", type=float, help="friction coefficient; contacts without a flag slide where |T| reaches mu N")
    if measured:
        group.add_argument("--kn", type=float, default=1.0, help="normal stiffness K_N (default 1: moduli in units of it)")
        group.add_argument("--kt", type=float, help="tangential stiffness K_T (default K_N)")
    group.add_argument("--kr", type=float, default=0.0, help="rolling stiffness K_r; above 0: contacts resist rolling")
    group.add_argument("--f0", type=float, default=0.0, help="attraction F0 (default 0)")
    if measured:
        group.add_argument("--d0", type=float, help="its range D0")
        group.add_argument("--force-unit", type=float, metavar="F1", help="unit of force (default F0, or the mean |N|)")


def sources_of(arguments: argparse.Namespace) -> list[Source]:
    """The run directories, and the dumps gathered to samples with their contacts.  Raises InputError."""
    paths = [path for given in arguments.source for path in _expanded(given)]
    contacts = [path for given in arguments.contacts for path in _expanded(given)]
    if not paths:
        raise InputError("name a run directory or a dump of grains" + " before --contacts" * bool(contacts))
    if len({path.resolve() for path in paths}) < len(paths):
        raise InputError("a source is named twice; samples must be different runs")
    runs: list[Source] = [path for path in paths if not path.is_file()]
    dumps = [path for path in paths if path.is_file()]
    if contacts and not dumps:
        raise InputError(f"--contacts {contacts[0]} goes with dumps of grains; the contacts of '{paths[0]}' are in it")
    return runs + list(gathered(dumps, contacts, reading_of(arguments), apart=arguments.samples))


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
        raise InputError(f"'{name_of(found[1])}' is a second source; give one run directory, or dumps of one sample")
    return found[0]


def name_of(source: Source) -> str:
    """Of the run directory, or of its first dump."""
    return str(source if isinstance(source, Path) else source.grains[0])


def folder_of(source: Source) -> Path:
    """Where to write what is made of a source."""
    return source if isinstance(source, Path) else source.grains[0].parent


def frame_of(source: Source, arguments: argparse.Namespace) -> tuple[Frame, Settings]:
    """The frame that ``arguments`` choose, and the settings of its measures."""
    if isinstance(source, Files):
        return frame_of_dump(source, arguments)
    directory = archived(RunDirectory.open(source))
    with Archive(directory / ARCHIVE) as archive:
        frame = archive.frame(arguments.frame)
    scene = packing(directory)
    return frame, settings_of(scene, scene.law_of(frame.stage), **options_of(arguments))


def frames_of(source: Source, arguments: argparse.Namespace, *, notes: bool) -> Iterator[Frame]:
    """The frame that ``arguments`` choose, or with ``arguments.all`` every one, read one at a time; ``notes``: say what is to
    be said of the first."""
    if isinstance(source, Files):
        sample = source.sample(reading_of(arguments))
        for number, frame in enumerate(sample.frames() if arguments.all else [sample.frame(arguments.frame)]):
            tell(frame.notes if not number and notes else ())
            yield frame
        return
    with Archive(archived(RunDirectory.open(source)) / ARCHIVE) as archive:
        yield from archive.frames if arguments.all else [archive.frame(arguments.frame)]


def tell(notes: Sequence[str]) -> None:
    """Notes about a source, on standard error."""
    for note in notes:
        print(f"wf: note: {note}", file=sys.stderr)


def packing(directory: RunDirectory) -> Packed:
    """The scene of a run that made a packing.  Raises InputError for a heap."""
    scene = directory.scene
    if isinstance(scene, Heap):
        raise InputError(f"'{directory.path}' is a heap, no packing in a periodic cell; give 'wf plot' the heap alone")
    return scene


def measures_from(source: Source, arguments: argparse.Namespace, groups: Sequence[str] | None) -> dict[str, Any]:
    """The measures of one source; those of dumps with ``notes`` of what is to be said of them."""
    if isinstance(source, Path):
        return measures_of(archived(RunDirectory.open(source)), arguments.frame, groups=groups, **options_of(arguments))
    frame, law = frame_of_dump(source, arguments)
    return measures_of_dump(frame, law, chosen_groups(groups, frame.grains))


def parameters_of(source: Source, arguments: argparse.Namespace) -> dict[str, Any]:
    """What a sample must share with others to be averaged with them, and its seed."""
    if isinstance(source, Files):
        frame = source.sample(reading_of(arguments)).frame(arguments.frame)
        walls = [not periodic for periodic in frame.periodic]
        return {"data": "dump", "grains": frame.grains, "walls": walls, "not given": sorted(frame.lacks - {"time"})}
    directory = archived(RunDirectory.open(source))
    with Archive(directory / ARCHIVE) as archive:
        stage = archive.frame(arguments.frame).stage
    return {"scene": directory.scene.name, **directory.scene.as_mapping(), "stage of the frame": stage}

"""Where frames come from: run directories, and dumps of other programs with what the user knows of their law."""

from __future__ import annotations

import argparse
import glob
import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from workflow.analysis.contacts import measure, stress_parts
from workflow.analysis.frame import Frame
from workflow.analysis.groups import Constants, attempt, chosen_groups, measure_groups, slipping
from workflow.analysis.network import Springs
from workflow.archive.columns import CONTACT_HELP, LIGGGHTS, Reading
from workflow.archive.read import Archive
from workflow.archive.samples import Files, gathered
from workflow.engine.collect import ARCHIVE, collect, constants_of, dump_sizes, measures_of
from workflow.engine.rundir import FINISHED, RunDirectory
from workflow.errors import ArchiveError, InputError
from workflow.scene.heap import Heap
from workflow.scene.presets import Packed

OPTIONS = ("window", "spacing")  # of the command line that are fields of Constants
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


def options_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """The options that go to the groups of measures."""
    given = {name: getattr(arguments, name) for name in OPTIONS if getattr(arguments, name) is not None}
    if "window" in given:
        low, high = given["window"] = tuple(given["window"])
        if not 0 <= low < high:
            raise InputError(f"--window {low:g} {high:g} is not allowed: it must ascend from 0 or more")
    return given


def archived(directory: RunDirectory) -> RunDirectory:
    """The directory with its archive, made now if the deck was run by hand."""
    dump = directory / "grains.dump"
    if not _up_to_date(directory):
        if not dump.is_file():
            raise ArchiveError(f"'{directory.path}' has no results yet; run its deck, or 'wf resume {directory.path}'")
        collect(directory)
        result = directory.result()
        if result and not result["stopped"]:  # the deck came to its end; a killed run stays one to resume
            directory.record(status=FINISHED, reason=None)
    return directory


def _up_to_date(directory: RunDirectory) -> bool:
    """The archive was made from the dumps as they are: by their sizes, since clocks may jump between two parts of a run."""
    if not (directory / ARCHIVE).is_file():
        return False
    if not (directory / "grains.dump").is_file():
        return True
    with Archive(directory / ARCHIVE) as archive:
        return archive.provenance.get("sizes") == dump_sizes(directory)


def frame_of(source: Source, arguments: argparse.Namespace) -> tuple[Frame, Constants]:
    """The frame that ``arguments`` choose, and the constants of its law."""
    if isinstance(source, Files):
        return _foreign(source, arguments)
    directory = archived(RunDirectory.open(source))
    with Archive(directory / ARCHIVE) as archive:
        frame = archive.frame(arguments.frame)
    scene = packing(directory)
    return frame, constants_of(scene, scene.law_of(frame.stage), **options_of(arguments))


def frames_of(source: Source, arguments: argparse.Namespace) -> Iterator[Frame]:
    """The frame that ``arguments`` choose, or with ``arguments.all`` every one, read one at a time."""
    if isinstance(source, Files):
        sample = source.sample(reading_of(arguments))
        for frame in sample.frames() if arguments.all else [sample.frame(arguments.frame)]:
            tell(frame.notes)
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
    frame, law = _foreign(source, arguments)
    return measures_of_dump(frame, law, chosen_groups(groups, frame.grains))


def measures_of_dump(frame: Frame, law: Constants, groups: Sequence[str]) -> dict[str, Any]:
    """The standard numbers with the two parts of the stress, the groups, and the notes."""
    numbers = measure(frame, force_unit=law.force_unit, tolerance=law.tolerance)
    numbers["stress"] |= stress_parts(frame)
    sliding = None if "sliding" in frame.lacks else int(frame.contacts.sliding.sum())
    time = None if "time" in frame.lacks else frame.time
    found = numbers | {"sliding_contacts": sliding} | measure_groups(frame, law, groups)
    if sliding and "error" not in found.get("rigidity", {"error": "not asked"}):
        found["rigidity"]["slipping"] = attempt(lambda: slipping(frame, law))
    return found | {"time": time, "step": frame.step, "notes": list(frame.notes)}


def reading_of(arguments: argparse.Namespace) -> Reading:
    """What the user says of the dumps.  Raises InputError."""
    for name in ("mu", "kr", "f0"):
        value = getattr(arguments, name)
        if value is not None and not 0.0 <= value < math.inf:
            raise InputError(f"--{name} {value:g} is not allowed: it must be a number from 0 on")
    words = None if arguments.liggghts is None else arguments.liggghts.replace(",", " ").split()
    return Reading(
        names=_names(arguments), liggghts=words, friction=arguments.mu, attraction=arguments.f0, rolling=arguments.kr > 0,
        complete=not arguments.partial,
    )  # fmt: skip


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


def _foreign(files: Files, arguments: argparse.Namespace) -> tuple[Frame, Constants]:
    cohesive = arguments.f0 > 0
    if cohesive and not (arguments.d0 or 0) > 0:
        raise InputError(f"--f0 {arguments.f0:g} needs the range of the attraction; add --d0")
    frame = files.sample(reading_of(arguments)).frame(arguments.frame)
    normal = abs(frame.contacts.normal_force) if "normal" not in frame.lacks else np.empty(0)
    unit = arguments.force_unit or (arguments.f0 if cohesive else float(normal.mean() if len(normal) else 0.0)) or 1.0
    kt = arguments.kn if arguments.kt is None else arguments.kt
    law = Constants(
        springs=Springs(arguments.kn, kt, arguments.kr, -arguments.f0 / arguments.d0 if cohesive else 0.0),
        friction=_friction(frame, arguments.mu), rolling=arguments.kr > 0, force_unit=unit, cohesive=cohesive,
        length=1.0 if "diameter" in frame.lacks else float(frame.diameter.max()), **options_of(arguments),
    )  # fmt: skip
    return frame, law


def _friction(frame: Frame, mu: float | None) -> float | None:
    """mu; NaN where the file itself shows that there is friction, by tangential forces and flags of sliding."""
    shown = not {"tangential", "sliding"} & frame.lacks and bool(frame.contacts.tangential.any())
    return mu if mu is not None else math.nan if shown else None


def _names(arguments: argparse.Namespace) -> dict[str, str]:
    """--columns as {name used here: column}."""
    pairs = [word.split("=", 1) for word in arguments.columns.split(",") if word]
    if any(len(pair) < 2 or not all(pair) for pair in pairs):
        raise InputError(f"--columns {arguments.columns} is not allowed: write NAME=COLUMN,NAME=COLUMN")
    if len({name for name, _ in pairs}) < len(pairs):
        raise InputError(f"--columns {arguments.columns} is not allowed: a name is given twice")
    return dict(pairs)

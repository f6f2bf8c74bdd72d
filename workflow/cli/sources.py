"""Where a frame comes from: a run directory, or the dump of another program with what the user knows of its law."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from workflow.analysis.contacts import measure
from workflow.analysis.frame import Frame
from workflow.analysis.groups import Constants, chosen_groups, measure_groups
from workflow.analysis.network import Springs
from workflow.archive.foreign import CONTACT_HELP, foreign_frames
from workflow.archive.read import Archive
from workflow.engine.archived import archived
from workflow.engine.collect import ARCHIVE, constants_of, measures_of
from workflow.engine.rundir import RunDirectory
from workflow.errors import InputError
from workflow.scene.heap import Heap
from workflow.scene.presets import Packed

OPTIONS = ("window", "spacing")  # of the command line that are fields of Constants


def add_sources(parser: argparse.ArgumentParser, *, measured: bool = True) -> None:
    """Positional sources, the frame, and what only dumps of other programs need.

    ``measured``: several sources, and the options of the measures; else one source, to be read only.
    """
    parser.add_argument("source", type=Path, nargs="+" if measured else 1, metavar="DIR",
                        help="run directory, or a LAMMPS dump of grains")  # fmt: skip
    parser.add_argument("--frame", type=int, default=-1, metavar="K", help="frame, negative from the end (default -1)")
    if measured:
        parser.add_argument("--window", type=float, nargs=2, metavar=("KMIN", "KMAX"),
                            help="range of k of the fractal fit [1/a] (default: 2 pi/L to pi/a)")  # fmt: skip
        parser.add_argument("--spacing", type=float, metavar="S",
                            help="mesh of C(r) and of the grid holes [a] (default 0.01, coarser beyond 2e7 nodes)")  # fmt: skip
    group = parser.add_argument_group("dumps of other programs")
    group.add_argument("--contacts", type=Path, metavar="FILE", help=f"dump local of the contacts: {CONTACT_HELP}")
    group.add_argument("--columns", default="", metavar="NAME=COLUMN,...", help="columns of the dumps by their names here")
    if measured:
        group.add_argument("--mu", type=float, default=0.5, help="friction coefficient (default 0.5)")
        group.add_argument("--kn", type=float, default=1.0, help="normal stiffness K_N (default 1: moduli in units of it)")
        group.add_argument("--kt", type=float, help="tangential stiffness K_T (default K_N)")
        group.add_argument("--kr", type=float, default=0.0, help="rolling stiffness K_r; above 0: contacts resist rolling")
        group.add_argument("--f0", type=float, default=0.0, help="attraction F0 (default 0)")
        group.add_argument("--d0", type=float, help="its range D0")
        group.add_argument("--force-unit", type=float, metavar="F1", help="unit of force (default F0, or the mean |N|)")


def options_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """The options that go to the groups of measures."""
    given = {name: getattr(arguments, name) for name in OPTIONS if getattr(arguments, name) is not None}
    if "window" in given:
        low, high = given["window"] = tuple(given["window"])
        if not 0 <= low < high:
            raise InputError(f"--window {low:g} {high:g} is not allowed: it must ascend from 0 or more")
    return given


def frame_of(source: Path, arguments: argparse.Namespace) -> tuple[Frame, Constants]:
    """The frame that ``arguments`` choose, and the constants of its law."""
    if source.is_file():
        return _foreign(source, arguments)
    directory = archived(RunDirectory.open(source))
    with Archive(directory / ARCHIVE) as archive:
        frame = archive.frame(arguments.frame)
    scene = packing(directory)
    return frame, constants_of(scene, scene.law_of(frame.stage), **options_of(arguments))


def frames_of(source: Path, arguments: argparse.Namespace) -> Iterator[Frame]:
    """The frame that ``arguments`` choose, or with ``arguments.all`` every one, read one at a time."""
    if source.is_file():
        if not arguments.all:
            yield _nth(source, arguments)
            return
        frames = foreign_frames(source, arguments.contacts, names=_names(arguments))
        first = next(frames, None)
        if first is None:
            raise InputError(f"'{source}' (with its contacts) holds no complete frame; give another dump")
        yield from chain([first], frames)
        return
    with Archive(archived(RunDirectory.open(source)) / ARCHIVE) as archive:
        yield from archive.frames if arguments.all else [archive.frame(arguments.frame)]


def packing(directory: RunDirectory) -> Packed:
    """The scene of a run that made a packing.  Raises InputError for a heap."""
    scene = directory.scene
    if isinstance(scene, Heap):
        raise InputError(f"'{directory.path}' is a heap, no packing in a periodic cell; give 'wf plot' the heap alone")
    return scene


def measures_from(source: Path, arguments: argparse.Namespace, groups: Sequence[str] | None) -> dict[str, Any]:
    """The measures of one source."""
    if not source.is_file():
        return measures_of(archived(RunDirectory.open(source)), arguments.frame, groups=groups, **options_of(arguments))
    frame, law = _foreign(source, arguments)
    numbers = measure(frame, force_unit=law.force_unit, tolerance=law.tolerance)
    return numbers | measure_groups(frame, law, chosen_groups(groups, frame.grains)) | {"time": frame.time, "step": frame.step}


def _foreign(grains: Path, arguments: argparse.Namespace) -> tuple[Frame, Constants]:
    frame = _nth(grains, arguments)
    cohesive = arguments.f0 > 0
    if cohesive and not (arguments.d0 or 0) > 0:
        raise InputError(f"--f0 {arguments.f0:g} needs the range of the attraction; add --d0")
    normal = abs(frame.contacts.normal_force)
    unit = arguments.force_unit or (arguments.f0 if cohesive else float(normal.mean() if len(normal) else 0.0)) or 1.0
    kt = arguments.kn if arguments.kt is None else arguments.kt
    law = Constants(
        springs=Springs(arguments.kn, kt, arguments.kr, -arguments.f0 / arguments.d0 if cohesive else 0.0),
        friction=arguments.mu, rolling=arguments.kr > 0, force_unit=unit, cohesive=cohesive,
        length=float(frame.diameter.max()), **options_of(arguments),
    )  # fmt: skip
    return frame, law


def _names(arguments: argparse.Namespace) -> dict[str, str]:
    """--columns as {name used here: column}."""
    pairs = [word.split("=", 1) for word in arguments.columns.split(",") if word]
    if any(len(pair) < 2 for pair in pairs):
        raise InputError(f"--columns {arguments.columns} is not allowed: write NAME=COLUMN,NAME=COLUMN")
    return dict(pairs)


def _nth(grains: Path, arguments: argparse.Namespace) -> Frame:
    """Frame K of the dump, read as a stream: of the frames before it none is kept longer than needed."""
    wanted = arguments.frame
    last: list[Frame] = []
    for number, frame in enumerate(foreign_frames(grains, arguments.contacts, names=_names(arguments))):
        if number == wanted:
            return frame
        if wanted < 0:
            last = [*last[wanted + 1 or len(last) :], frame]
    if wanted < 0 and len(last) == -wanted:
        return last[0]
    raise InputError(f"frame {wanted} does not exist in '{grains}' (with its contacts); choose another --frame")

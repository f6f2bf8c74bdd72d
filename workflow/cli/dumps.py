"""Dumps of other programs on the command line: what the user says of them."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from workflow.archive.columns import Reading
from workflow.archive.samples import Files
from workflow.data.contact_law import ContactLaw
from workflow.data.frame import Frame
from workflow.errors import InputError
from workflow.measures.registry import Settings
from workflow.pipeline.dumps import frame_of_files, settings_of_dump

# options that only dumps need, and what they are where they are not given
OF_DUMPS: dict[str, Any] = {
    "columns": [], "liggghts": None, "samples": False, "partial": False, "mu": None, "kn": 1.0, "kt": None, "kr": 0.0,
    "f0": 0.0, "d0": None, "force_unit": None,
}  # fmt: skip
OPTIONS = ("window", "spacing")  # of the command line that are fields of Settings


def options_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """The options that go to the groups of measures."""
    given = {name: getattr(arguments, name) for name in OPTIONS if getattr(arguments, name) is not None}
    if "window" in given:
        low, high = given["window"] = tuple(given["window"])
        if not 0 <= low < high:
            raise InputError(f"--window {low:g} {high:g} is not allowed: it must ascend from 0 or more")
    return given


def refuse_without_dumps(arguments: argparse.Namespace, dumps: Sequence[Path]) -> None:
    """Raise InputError for options that say what only a dump leaves open, where every source is a run."""
    for name, default in () if dumps else OF_DUMPS.items():
        if getattr(arguments, name, default) != default:
            option = "--" + name.replace("_", "-")
            raise InputError(f"{option} is for dumps of other programs; a run knows its own: leave it out")


def reading_of(arguments: argparse.Namespace) -> Reading:
    """What the user says of the dumps.  Raises InputError."""
    for name in ("mu", "kr", "f0"):
        value = getattr(arguments, name)
        if value is not None and not 0.0 <= value < math.inf:
            raise InputError(f"--{name} {value:g} is not allowed: it must be a number from 0 on")
    words = None if arguments.liggghts is None else ",".join(arguments.liggghts).replace(",", " ").split()
    return Reading(
        names=_names(arguments), liggghts=words, friction=arguments.mu, attraction=arguments.f0, rolling=arguments.kr > 0,
        complete=not arguments.partial,
    )  # fmt: skip


def frame_of_dump(files: Files, arguments: argparse.Namespace) -> tuple[Frame, Settings]:
    """The frame that ``arguments`` choose, and the settings of its measures.  Raises InputError."""
    cohesive = arguments.f0 > 0
    if cohesive and not (arguments.d0 or 0) > 0:
        raise InputError(f"--f0 {arguments.f0:g} needs the range of the attraction; add --d0")
    frame = frame_of_files(files, reading_of(arguments), arguments.frame)
    law = ContactLaw(
        kn=arguments.kn, kt=arguments.kn if arguments.kt is None else arguments.kt,
        mu=math.nan if arguments.mu is None else arguments.mu, f0=arguments.f0, d0=arguments.d0 if cohesive else 0.0,
        kr=arguments.kr, mur=math.inf if arguments.kr > 0 else 0.0,
    )  # fmt: skip
    return frame, settings_of_dump(frame, law, force_unit=arguments.force_unit, **options_of(arguments))


def _names(arguments: argparse.Namespace) -> dict[str, str]:
    """--columns as {name used here: column}."""
    given = ",".join(arguments.columns)
    pairs = [word.split("=", 1) for word in given.split(",") if word]
    if any(len(pair) < 2 or not all(pair) for pair in pairs):
        raise InputError(f"--columns {given} is not allowed: write NAME=COLUMN,NAME=COLUMN")
    if len({name for name, _ in pairs}) < len(pairs):
        raise InputError(f"--columns {given} is not allowed: a name is given twice")
    return dict(pairs)

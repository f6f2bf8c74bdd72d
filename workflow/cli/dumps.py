"""Dumps of other programs on the command line: what the user says of them."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from typing import Any

import numpy as np

from workflow.archive.columns import Reading
from workflow.archive.samples import Files
from workflow.data.frame import Frame
from workflow.errors import InputError
from workflow.measures.network import Springs
from workflow.measures.registry import Constants

OPTIONS = ("window", "spacing")  # of the command line that are fields of Constants


def options_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """The options that go to the groups of measures."""
    given = {name: getattr(arguments, name) for name in OPTIONS if getattr(arguments, name) is not None}
    if "window" in given:
        low, high = given["window"] = tuple(given["window"])
        if not 0 <= low < high:
            raise InputError(f"--window {low:g} {high:g} is not allowed: it must ascend from 0 or more")
    return given


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


def frame_of_dump(files: Files, arguments: argparse.Namespace) -> tuple[Frame, Constants]:
    cohesive = arguments.f0 > 0
    if cohesive and not (arguments.d0 or 0) > 0:
        raise InputError(f"--f0 {arguments.f0:g} needs the range of the attraction; add --d0")
    sample = files.sample(reading_of(arguments))
    frame = sample.frame(arguments.frame)
    if len(sample.steps) > 1:
        place = f"frame {arguments.frame % len(sample.steps) + 1} of {len(sample.steps)}, step {frame.step}"
        frame = replace(frame, notes=(place, *frame.notes))
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

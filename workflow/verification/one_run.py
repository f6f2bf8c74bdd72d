"""One run of the deck accuracy.in: the same grains under a contact law, for a time at a step."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workflow.archive.dumps import read_blocks
from workflow.data.discs import Discs
from workflow.deck.template import data_file
from workflow.errors import EngineError, InputError
from workflow.runs.launch import run_template
from workflow.scene.placement import Floats

COARSE = 0.3  # seconds; the processor's share of a shorter loop is too coarse a number


@dataclass(frozen=True)
class Variant:
    """A way to compute the law: ``law`` and ``scheme`` of the deck; ``cohesion``: it has the attraction."""

    name: str
    law: str
    scheme: str = "second"
    cohesion: bool = True


VARIANTS = (
    Variant("exact", "disc", "second"),
    Variant("exact, paper's scheme", "disc", "paper"),
    Variant("stock", "stock"),
    Variant("hooke/history", "hooke", cohesion=False),
)


SYNCHRONIZED = Variant("stock, synchronized", "stock", "synchronized")  # of the stock law, for discs of very unlike sizes


@dataclass(frozen=True)
class Outcome:
    """Final state (rows in the order of the data), the numbers the deck printed, processor seconds of the timed loop.

    ``position`` (N, 2) unwrapped, ``velocity`` (N, 2), ``omega`` (N,); ``cell`` (2,).  ``result``: begin, end (energy
    account), through (energy that went through), kinetic, pxx, pyy.
    """

    position: Floats
    velocity: Floats
    omega: Floats
    cell: Floats
    result: dict[str, float]
    seconds: float


def run(
    discs: Discs,
    values: dict[str, object],
    *,
    velocity: Floats | None = None,
    omega: Floats | None = None,
    patience: float | None = None,
) -> Outcome:
    """Run the deck on ``discs``, at rest unless ``velocity`` (N, 2) and ``omega`` (N,) are given.

    Raises InputError with the engine's words if it refuses the input before the first step, EngineError if it stops
    later or does not end within ``patience`` seconds.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        text = data_file(discs) + ("" if velocity is None else velocities(velocity, omega))
        (folder / "grains.data").write_text(text, encoding="ascii")
        done = run_template(folder, "accuracy.in", {**values, "data": "grains.data"}, patience=patience)
        found = re.findall(r"^RESULT (.*)$", done.log, re.MULTILINE)
        if done.status or not found:
            raise (EngineError if "\nLoop time" in done.log else InputError)(done.words)
        numbers = found[-1].split()
        result = {key: float(value) for key, value in zip(numbers[::2], numbers[1::2], strict=True)}
        (block,) = read_blocks(folder / "grains.dump", "ATOMS")
        return outcome_of(block.named, result, _processor_time(done.log))


def _processor_time(log: str) -> float:
    """Loop time, of long loops times the share of the processor: on a shared machine the clock alone says little."""
    last = log[log.rindex("Loop time of ") :]
    loop, share = float(last.split()[3]), re.search(r"^([\d.]+)% CPU use", last, re.MULTILINE)
    return loop * float(share[1]) / 100.0 if share and loop > COARSE else loop


def velocities(velocity: Floats, omega: Floats | None) -> str:
    """Section Velocities of a data file."""
    turning = np.zeros(len(velocity)) if omega is None else omega
    rows = zip(velocity.tolist(), turning.tolist(), strict=True)
    return "\nVelocities\n\n" + "".join(f"{k} {u!r} {v!r} 0 0 0 {w!r}\n" for k, ((u, v), w) in enumerate(rows, 1))


def outcome_of(grains: Mapping[str, Floats], result: dict[str, float], seconds: float) -> Outcome:
    """The grains of a dump with image flags, {column: values}; ``result`` has the cell lengths lx and ly with all digits."""
    cell = np.array([result["lx"], result["ly"]])
    image = np.column_stack((grains["ix"], grains["iy"]))
    position = np.column_stack((grains["x"], grains["y"])) + image * cell
    velocity = np.column_stack((grains["vx"], grains["vy"]))
    return Outcome(position, velocity, grains["omegaz"], cell, result, seconds)

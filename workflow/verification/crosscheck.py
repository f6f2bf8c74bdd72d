"""Packings of the same cohesionless discs in engines that others wrote: method 1 from the same grains at rest.

Trajectories part within a T0, so only bulk numbers mean something, and how far those scatter is shown by our own engine at
half the step.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TextIO

import numpy as np
from scipy.stats import ks_2samp

from workflow.archive.dumps import read_blocks
from workflow.data.balance import solid_fraction
from workflow.data.build import make_frame, pairs_in_contact
from workflow.data.discs import Discs
from workflow.data.progress import Meter
from workflow.data.series import read_series
from workflow.deck.template import DATA, DECK, data_file, render
from workflow.errors import EngineError
from workflow.measures.packing import coordination, kinetic_energy
from workflow.runs.launch import run_deck
from workflow.scene.method1 import Method1
from workflow.scene.placement import Floats, diameters, place_randomly
from workflow.verification.one_run import Outcome, outcome_of
from workflow.verification.other_engines import PEERS, prepare
from workflow.verification.other_engines import run as run_peer

EXACT, CONTROL = "exact", "exact, half the step"
CLASSES = 8  # diameters in a packing: LIGGGHTS has one damping constant per pair of atom types
LONGER = 1.25  # times as long as ours takes in all the others run before their drag: they do not stop by themselves
SETTLE = 10.0  # time with drag in the others [T0]
TIME = 40.0  # that ours takes, where it is not known [T0]
ROWS = 0.1  # time between rows of the others' series [T0]
SHARES = {EXACT: 1.0, CONTROL: 2.0, "liggghts": 50.0, "yade": 60.0}  # of the time, for the estimate of what is left
NUMBERS = ("solid_fraction", "coordination", "coordination_backbone", "rattlers", "mean_force", "second_moment")


@dataclass(frozen=True)
class Packed:
    """One packing at its end, measured alike in all engines: N = K_N times the overlap.

    ``coordination`` z of all contacts, ``coordination_backbone`` z*; ``mean_force`` <N> [a P] and ``second_moment``
    <N^2>/<N>^2 over contacts above 1e-4 a P; ``ks``: Kolmogorov-Smirnov distance of N/<N> to that of the exact
    law at its own step, and ``ks_critical``, which 5 % of pairs of samples of one distribution of independent values
    exceed; ``kinetic`` energy per grain without rattlers [a P], ``seconds`` of the whole run.
    """

    seed: int
    engine: str
    n: int
    solid_fraction: float
    coordination: float
    coordination_backbone: float
    rattlers: float
    mean_force: float
    second_moment: float
    ks: float
    ks_critical: float
    kinetic: float
    time: float
    seconds: float


@dataclass(frozen=True)
class Mean:
    """Over seeds: mean of a number of `Packed`, its standard error, and the mean difference to the exact law from the same
    grains with its standard error (None for one seed)."""

    engine: str
    number: str
    seeds: int
    mean: float
    error: float | None
    difference: float
    difference_error: float | None


def grains(scene: Method1) -> Discs:
    """The random gas of the scene with its diameters rounded to the middles of CLASSES classes."""
    rng = scene.random("placement")
    width = (1.0 - scene.smallest) / CLASSES
    size = diameters(scene.n, scene.smallest, rng)
    if width:
        size = scene.smallest + width * (np.floor((size - scene.smallest) / width) + 0.5)
    return place_randomly(size, scene.phi0, 0.0, rng)


@dataclass(frozen=True)
class Result:
    """``row``: the numbers; ``force`` (M,): N/<N> of the contacts that bear force; ``course`` (rows, 2): time [T0] and solid
    fraction on the way."""

    row: Packed
    force: Floats
    course: Floats


def packings(scenes: Sequence[Method1], peers: Sequence[str], out: Path, words: TextIO = sys.stderr) -> list[Result]:
    """Every scene in our engine, twice, and in ``peers``; ``out``/seedK/ENGINE keeps decks and results.

    ``scenes``: method 1 without cohesion, differing in their seed.
    """
    engines = (EXACT, CONTROL, *peers)
    meter = Meter(len(scenes) * sum(SHARES[name] for name in engines), words)
    results = []
    for scene in scenes:
        discs, exact = grains(scene), None
        for name in engines:
            folder, begun = place_of(out, scene, name), time.perf_counter()
            if name in PEERS:
                end = run_peer(folder, name, discs, scene.law_in_units, values_of(scene, exact), *at_rest(discs))
            else:
                step = scene.step_choice.step * (1.0 if name == EXACT else 0.5)
                end = own_run(folder, replace(scene, step=step), discs)
            result = measured(scene, name, discs, end, exact, course(folder, discs), time.perf_counter() - begun)
            exact = result if name == EXACT else exact
            results.append(result)
            meter.add(SHARES[name], f"seed {scene.seed}, {name}")
    meter.end()
    return results


def prepare_packings(scenes: Sequence[Method1], peers: Sequence[str], out: Path) -> Iterator[Path]:
    """Write decks and grains of ``peers`` and run nothing; the folder of each, as it is written."""
    for scene in scenes:
        discs = grains(scene)
        for name in peers:
            folder = place_of(out, scene, name)
            prepare(folder, name, discs, scene.law_in_units, values_of(scene, None), *at_rest(discs))
            yield folder


def place_of(out: Path, scene: Method1, name: str) -> Path:
    """Folder of one engine and seed."""
    return out / f"seed{scene.seed}" / name.replace(", ", "-").replace(" ", "-")


def at_rest(discs: Discs) -> tuple[Floats, Floats]:
    """Velocities and spins of 0."""
    return np.zeros_like(discs.position), np.zeros_like(discs.diameter)


def values_of(scene: Method1, exact: Result | None) -> dict[str, float | int]:
    """Variables of the decks of other programs; times from those of our run, or TIME if it was not done."""
    step, total = scene.step_choice.step, exact.row.time if exact else TIME
    return {
        "stress": scene.pressure, "cell_mass": scene.cell_mass, "step": step, "skin": scene.neighbour_skin,
        "steps": math.ceil(LONGER * total / step), "relax_steps": math.ceil(SETTLE / step), "rows": round(ROWS / step),
    }  # fmt: skip


def own_run(folder: Path, scene: Method1, discs: Discs) -> Outcome:
    """Run the deck of the scene on ``discs``."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / DATA).write_text(data_file(discs), encoding="ascii")
    (folder / DECK).write_text(render(scene), encoding="ascii")
    for name in ("grains.dump", "contacts.dump"):
        (folder / name).unlink(missing_ok=True)
    run_deck(folder, DECK).output()
    *_, block = read_blocks(folder / "grains.dump", "ATOMS")
    series = read_series(folder / "series.txt")
    return outcome_of(block.named, {name: float(series[f"length_{name[1]}"][-1]) for name in ("lx", "ly")}, 0.0)


def course(folder: Path, discs: Discs) -> Floats:
    """Time and solid fraction from the series of a run, ours or another's."""
    with open(folder / "series.txt", encoding="ascii") as file:
        names = file.readline().lstrip("# ").split()
        table = np.loadtxt(file, ndmin=2)
    time_, width, height = (table[:, names.index(name)] for name in ("time", "length_x", "length_y"))
    return np.column_stack((time_, np.sum(np.pi * discs.diameter**2 / 4.0) / (width * height)))


def measured(
    scene: Method1, name: str, discs: Discs, end: Outcome, exact: Result | None, way: Floats, seconds: float
) -> Result:
    """The numbers of the packing at ``end``; ``exact``: that of the exact law, ``way``: its `course`."""
    i, j = pairs_in_contact(end.position, discs.diameter, end.cell)
    branch = end.position[j] - end.position[i]
    branch -= end.cell * np.round(branch / end.cell)
    overlap = (discs.diameter[i] + discs.diameter[j]) / 2.0 - np.hypot(*branch.T)
    normal = scene.law_in_units.kn * overlap
    pairs = {"i": i, "j": j, "branch": branch, "normal": normal}
    frame = make_frame(end.position, discs.diameter, end.cell, pairs, velocity=end.velocity, omega=end.omega)
    threshold = scene.force_tolerance * scene.force_unit
    network, force = coordination(frame, threshold=threshold), normal[normal > threshold]
    if not len(force):
        raise EngineError(f"{name}, seed {scene.seed}: no contact bears force at the end; the packing did not form")
    mean, ks, critical = float(force.mean()), 0.0, 0.0
    if exact:
        ks = float(ks_2samp(force / mean, exact.force).statistic)
        critical = 1.358 * math.sqrt(1.0 / len(force) + 1.0 / len(exact.force))
    row = Packed(
        scene.seed, name, scene.n, solid_fraction(frame), network.z, network.z_backbone, network.rattler_fraction, mean,
        float((force**2).mean()) / mean**2, ks, critical, kinetic_energy(frame, network.rattlers).relative,
        float(way[-1, 0]), seconds,
    )  # fmt: skip
    return Result(row, force / mean, way)


def means(rows: Sequence[Packed]) -> list[Mean]:
    """Per engine and number: the mean over seeds and the mean of the differences, seed by seed, to the exact law."""
    seeds = list(dict.fromkeys(row.seed for row in rows))
    table = {(row.engine, row.seed): row for row in rows}
    result = []
    for name in dict.fromkeys(row.engine for row in rows):
        for number in NUMBERS:
            values = np.array([getattr(table[name, seed], number) for seed in seeds])
            apart = values - np.array([getattr(table[EXACT, seed], number) for seed in seeds])
            result.append(Mean(name, number, len(seeds), *_mean(values), *_mean(apart)))
    return result


def _mean(values: Floats) -> tuple[float, float | None]:
    """Mean and its standard error."""
    return float(values.mean()), float(values.std(ddof=1)) / math.sqrt(len(values)) if len(values) > 1 else None

"""Nanoseconds per grain and step of the exact law beside other engines on the same grains, taking turns as machines drift."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import statistics
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from workflow.data.discs import Discs
from workflow.data.progress import Meter
from workflow.deck.template import data_file, templates
from workflow.errors import EngineError, EnvironmentFault
from workflow.runs.launch import run_program, run_template
from workflow.verification.bench_states import dense, gas

ENGINES = ("exact", "stock", "hooke/history", "granular", "liggghts", "yade")
PROGRAMS = ("liggghts", "yade")  # programs of their own; the others run in this package's LAMMPS
STATES = ("gas", "dense")
REFERENCE, EXACT, OTHER = "hooke/history", "exact", "exact, other installation"
GRAIN_STEPS, LEAST_STEPS = 10_000_000, 500  # timed steps: so many grain-steps, at least so many steps
WARM_SHARE = 5  # one untimed step per so many timed ones
PARTS = ("pair", "neigh", "comm", "modify")

# what the engines of this package change in bench.in; exact: friction, rolling, energy account, fixed cell
OWN: dict[str, dict[str, object]] = {
    "exact": {}, "stock": {"contact_model": "stock"}, "hooke/history": {"contact_model": "hooke"},
    "granular": {"contact_model": "granular"},
}  # fmt: skip
SWITCHES: dict[str, dict[str, object]] = {
    "exact, barostat": {"barostat": "yes"},
    "exact, no friction": {"mu": 0.0},
    "exact, no rolling": {"kr": 0.0, "mur": 0.0},
    "exact, cohesion": {"f0": 1.0, "d0": 1e-3},
    "exact, no account": {"energy_balance": "no"},
    "exact, scheme paper": {"scheme": "paper"},
    "exact, run_style verlet": {"run_style": "verlet"},
}


@dataclass(frozen=True)
class Timing:
    """One engine on one state.

    ``ns_per_grain_step``: median over rounds of LAMMPS's loop time/(n steps), ``least`` and ``most`` of them; ``ratio`` to
    hooke/history and ``ratio_to_exact``: medians of the ratios within a round, None where that engine did not run; ``pair``,
    ``neigh``, ``comm``, ``modify``, ``other`` [ns per grain and step]: LAMMPS's breakdown, None for YADE, which has none.
    """

    engine: str
    state: str
    n: int
    ranks: int
    steps: int
    rounds: int
    ns_per_grain_step: float
    least: float
    most: float
    grain_steps_per_second: float
    ratio: float | None
    ratio_to_exact: float | None
    pair: float | None
    neigh: float | None
    comm: float | None
    modify: float | None
    other: float | None


@dataclass(frozen=True)
class Loop:
    """One timed run: ns per grain and step, and its parts."""

    total: float
    parts: dict[str, float]


Key = tuple[str, int]  # engine, ranks
State = Callable[[Path], Discs]


def own_states(counts: Sequence[int], names: Sequence[str]) -> list[tuple[str, State]]:
    """The states to time, made when their turn comes."""

    def state(name: str, n: int) -> State:
        return (lambda folder: gas(n)) if name == "gas" else (lambda folder: dense(n, folder))

    return [(name, state(name, n)) for n in counts for name in names]


def missing(engines: Sequence[str]) -> list[str]:
    """Which of ``engines`` are not installed."""
    return [name for name in engines if name in PROGRAMS and not shutil.which(name)]


def bench(
    states: Sequence[tuple[str, State]],
    engines: Sequence[str] = ENGINES,
    *,
    ranks: Sequence[int] = (1,),
    rounds: int = 5,
    steps: int | None = None,
    switches: bool = False,
    common: Mapping[str, object] | None = None,
    against: Path | None = None,
    out: TextIO = sys.stderr,
) -> list[Timing]:
    """Time every installed engine on every state, one after the other within each round; LIGGGHTS and YADE on one rank only.

    ``steps``: timed steps (default: GRAIN_STEPS grain-steps); ``common``: variables that all decks take (kn, zeta, mu, step);
    ``against``: the Python of another installation, whose own `wf bench` times its exact law on the same state as row OTHER.
    Raises EnvironmentFault if none of the engines is installed, EngineError if a run fails.
    """
    here = [name for name in engines if name not in missing(engines)]
    if not here:
        raise EnvironmentFault(f"not installed: {', '.join(engines)}; try apt-get install {' '.join(engines)}")
    meter = Meter(len(states) * rounds, out)
    timings: list[Timing] = []
    for name, make in states:
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            discs = make(folder)
            _write(folder, discs)
            grains = len(discs.diameter)
            count = steps or max(LEAST_STEPS, GRAIN_STEPS // grains)
            values = {**(common or {}), "warm": math.ceil(count / WARM_SHARE), "steps": count}
            rows = [*_rows(here, name, switches), *([OTHER] if against else [])]
            keys = [(row, r) for r in ranks for row in rows if r == 1 or row not in PROGRAMS]
            loops: dict[Key, list[Loop]] = {key: [] for key in keys}
            for _ in range(rounds):
                for row, r in keys:
                    other = against if row == OTHER else None
                    loop = _other(other, name, grains, r, count) if other else _loop(folder, row, r, values, grains * count)
                    loops[row, r].append(loop)
                meter.add(1, f"{name}, {grains} grains")
        timings += [_timing(key, loops, name, grains, count) for key in keys]
    meter.end()
    return timings


def _rows(engines: Sequence[str], state: str, switches: bool) -> list[str]:
    """Names of the rows: engines, and after EXACT its variants; cohesion on the gas alone, as it would change the packing."""
    variants = [s for s in SWITCHES if switches and (state == "gas" or "cohesion" not in s)]
    return [row for name in engines for row in (name, *(variants if name == EXACT else ()))]


def _write(folder: Path, discs: Discs) -> None:
    """The state as data files; LIGGGHTS reads an older format and takes a disc's density, 4/pi for m = d^2."""
    text = data_file(discs)
    (folder / "grains.data").write_text(text, encoding="ascii")
    older = re.sub(r"^(\d+ 1 \S+) 1\.0 ", rf"\1 {4.0 / math.pi!r} ", text, flags=re.MULTILINE)
    (folder / "liggghts.data").write_text(older.replace("Atoms # sphere", "Atoms"), encoding="ascii")


def _loop(folder: Path, row: str, ranks: int, values: Mapping[str, object], grain_steps: int) -> Loop:
    """One run, from its last loop time and breakdown."""
    if row == "liggghts":
        options = [str(word) for name, value in values.items() for word in ("-var", name, value)]
        shutil.copy(templates() / "bench_liggghts.in", folder)
        log = run_program([row, "-in", "bench_liggghts.in", "-screen", "none", *options], folder).output()
    elif row == "yade":
        given = {"kn": 1e5, "zeta": 0.8, "mu": 0.5, "step": 1e-4, **values}
        words = ["grains.data", *(str(given[name]) for name in ("kn", "zeta", "mu", "step", "warm", "steps"))]
        log = run_program([row, "-n", "-x", "-j1", str(templates() / "bench_yade.py"), *words], folder).output()
    else:
        changed = {**OWN, **SWITCHES}[row]
        log = run_template(folder, "bench.in", {**values, **changed, "data": "grains.data"}, ranks=ranks).output()
    return read_loop(log, grain_steps)


def _other(python: Path, state: str, grains: int, ranks: int, steps: int) -> Loop:
    """One run of the exact law of another installation: its decks and plugin, its own state of the same name and size."""
    asked = {"--engines": EXACT, "--state": state, "--n": grains, "--ranks": ranks, "--steps": steps, "--rounds": 1}
    words = [str(word) for pair in asked.items() for word in pair]
    apart = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    command = [str(python), "-P", "-m", "workflow.cli.main", "bench", *words, "--json"]
    row = json.loads(run_program(command, environment=apart).output())[0]
    return Loop(row["ns_per_grain_step"], {name: row[name] for name in (*PARTS, "other")})


def read_loop(log: str, grain_steps: int) -> Loop:
    """The last "Loop time" of a log of LAMMPS, or of LIGGGHTS with its older table, per grain and step."""
    found = list(re.finditer(r"^Loop time of (\S+)", log, re.MULTILINE))
    if not found:
        raise EngineError("the benchmark run gave no loop time")
    tail, scale = log[found[-1].start() :], 1e9 / grain_steps
    parts = {}
    for name in PARTS:
        part = re.search(rf"^{name} +\|[^|]*\|\s*(\S+)|^{name} +time \(%\) = (\S+)", tail, re.MULTILINE | re.IGNORECASE)
        if part:
            parts[name] = scale * float(part[1] or part[2])
    total = scale * float(found[-1][1])
    return Loop(total, {**parts, "other": total - sum(parts.values())} if parts else {})


def _timing(key: Key, loops: Mapping[Key, list[Loop]], state: str, grains: int, steps: int) -> Timing:
    row, ranks = key
    own = [loop.total for loop in loops[key]]

    def ratio(other: str) -> float | None:
        of = loops.get((other, ranks))
        return statistics.median(a / b.total for a, b in zip(own, of, strict=True)) if of else None

    def part(name: str) -> float | None:
        values = [loop.parts[name] for loop in loops[key] if name in loop.parts]
        return statistics.median(values) if values else None

    middle = statistics.median(own)
    return Timing(
        row, state, grains, ranks, steps, len(own), middle, min(own), max(own), 1e9 / middle, ratio(REFERENCE), ratio(EXACT),
        *(part(name) for name in (*PARTS, "other")),
    )  # fmt: skip

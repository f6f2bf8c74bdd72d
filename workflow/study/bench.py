"""Speed of the kernels on one state, side by side with LAMMPS's own contact styles, interleaved because machines drift."""

from __future__ import annotations

import re
import shutil
import statistics
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from workflow.analysis.frame import Frame
from workflow.deck.render import data_file, templates
from workflow.engine.environment import engine, python_child
from workflow.errors import EngineError
from workflow.scene.grains import Discs

# name -> variables of bench.in on top of the common ones
CASES: dict[str, dict[str, object]] = {
    "disc/cohesive, stress-controlled cell": {"engine": "disc"},
    "disc/cohesive, without energy account": {"engine": "disc", "account": "no"},
    "disc/cohesive, fixed cell": {"engine": "disc", "stress": 0.0},
    "disc/cohesive, no friction": {"engine": "disc", "mu": 0.0},
    "disc/cohesive, attraction and rolling": {"engine": "disc", "f0": 1.0, "d0": 1e-3, "mur": 0.005, "kr": 10.0},
    "gran/hooke/history, fixed cell": {"engine": "hooke", "stress": 0.0},
    "gran/hooke/history, press/berendsen": {"engine": "hooke"},
    "granular (restitution damping), fixed cell": {"engine": "granular", "stress": 0.0},
}
REFERENCE = "gran/hooke/history, fixed cell"


@dataclass(frozen=True)
class Timing:
    """One case: nanoseconds per grain and step, median and extremes over rounds, and the median ratio to REFERENCE of the
    same round."""

    case: str
    median: float
    least: float
    most: float
    ratio: float


def bench(frame: Frame, *, step: float, steps: int, rounds: int) -> list[Timing]:
    """Time every case on the grains of ``frame``, ``rounds`` times, one case after the other in each round."""
    times: dict[str, list[float]] = {case: [] for case in CASES}
    discs = Discs(frame.diameter, frame.position - frame.origin, frame.cell)
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(templates() / "bench.in", folder)
        Path(folder, "grains.data").write_text(data_file(discs), encoding="ascii")
        for _ in range(rounds):
            for case, values in CASES.items():
                loop = _loop_time(folder, {**values, "data": "grains.data", "step": step, "steps": steps})
                times[case].append(1e9 * loop / (frame.grains * steps))
    reference = times[REFERENCE]
    return [
        Timing(
            case, statistics.median(ns), min(ns), max(ns),
            statistics.median(a / b for a, b in zip(ns, reference, strict=True)),
        )
        for case, ns in times.items()
    ]  # fmt: skip


def _loop_time(folder: str, values: dict[str, object]) -> float:
    """Seconds of the timed run, LAMMPS's own loop time."""
    words = [str(word) for pair in values.items() for word in pair]
    child = subprocess.run(
        [*python_child(), "bench.in", *words],
        cwd=folder,
        env=engine().variables(),
        capture_output=True,
        text=True,
        check=False,
    )
    loops = re.findall(r"^Loop time of (\S+)", Path(folder, "log.lammps").read_text(errors="replace"), re.MULTILINE)
    if child.returncode != 0 or not loops:
        raise EngineError(f"the benchmark deck stopped: {child.stderr.strip()}")
    return float(loops[-1])

"""States that `wf bench` times on: a gas, and the same grains squeezed to a dense packing; rows in spatial order."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np

from workflow.analysis.frame import Frame
from workflow.archive.foreign import foreign_frames
from workflow.deck.render import copy_template, data_file
from workflow.engine.environment import engine, python_child
from workflow.errors import EngineError
from workflow.scene.grains import Discs, cell_length, diameters, gaussian, place, strips

GAS, DENSE = 0.36, 0.80  # solid fractions
SPEED = 0.3  # root mean square speed of the gas
GAP = 1e-4  # least gap at placement


def gas(n: int) -> Discs:
    """``n`` discs with diameters in [1/2, 1] at solid fraction GAS with Maxwell velocities; the same for the same n."""
    rng = np.random.default_rng(n)
    discs = place(diameters(n, 0.5, rng), GAS, GAP, rng)
    return Discs(discs.diameter, discs.position, discs.cell, gaussian(discs.diameter, SPEED, "temperature", rng))


def dense(n: int, folder: Path) -> Discs:
    """The gas squeezed with friction to solid fraction DENSE by the deck bench_dense.in in ``folder``, at rest."""
    start = gas(n)
    length = repr(cell_length(start.diameter, DENSE))
    (folder / "gas.data").write_text(data_file(start), encoding="ascii")
    run_deck(folder, "bench_dense.in", {"data": "gas.data", "width": length, "height": length})
    return of_frame(next(foreign_frames(folder / "dense.dump")))


def of_frame(frame: Frame) -> Discs:
    """The grains of a frame, at rest, in spatial order."""
    position = np.mod(frame.position - frame.origin, frame.cell)
    order = strips(position, frame.cell)
    return Discs(frame.diameter[order], position[order], frame.cell, np.zeros_like(position))


def run_deck(folder: Path, deck: str, values: dict[str, object], ranks: int = 1) -> str:
    """Run a template in ``folder`` on ``ranks`` MPI ranks; its log.  Raises EngineError with the engine's words."""
    copy_template(deck, folder)
    found = engine()
    command = [*python_child(), deck, *(str(word) for pair in values.items() for word in pair)]
    launcher = [str(found.mpiexec), "-n", str(ranks)] if ranks > 1 else []
    return run_command([*launcher, *command], folder, found.variables())


def run_command(command: list[str], folder: Path, environment: dict[str, str] | None = None) -> str:
    """Run ``command`` in ``folder``; what it printed and its log.lammps.  Raises EngineError if it fails."""
    log = folder / "log.lammps"
    log.unlink(missing_ok=True)
    child = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    text = child.stdout + (log.read_text(errors="replace") if log.is_file() else "")
    if child.returncode != 0:
        words = re.search(r"ERROR.*", text + child.stderr)
        last = (child.stderr.strip() or text.strip() or "no message").splitlines()[-1]
        raise EngineError(f"the run {' '.join(command[-40:])!r:.200} stopped: {words[0] if words else last}")
    return text

"""States that `wf bench` times on: a gas, and the same grains squeezed to a dense packing; rows in spatial order."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from workflow.archive.foreign import foreign_frames
from workflow.archive.read import Archive
from workflow.data.discs import Discs, strips
from workflow.data.frame import Frame
from workflow.deck.template import data_file
from workflow.errors import InputError
from workflow.pipeline.archived import archived
from workflow.runs.directory import ARCHIVE, RunDirectory
from workflow.runs.launch import run_template
from workflow.scene.placement import cell_length, diameters, gaussian, place_randomly

GAS, DENSE = 0.36, 0.80  # solid fractions
SPEED = 0.3  # root mean square speed of the gas
GAP = 1e-4  # least gap at placement


def gas(n: int) -> Discs:
    """``n`` discs with diameters in [1/2, 1] at solid fraction GAS with Maxwell velocities; the same for the same n."""
    rng = np.random.default_rng(n)
    discs = place_randomly(diameters(n, 0.5, rng), GAS, GAP, rng)
    return Discs(discs.diameter, discs.position, discs.cell, gaussian(discs.diameter, SPEED, "temperature", rng))


def dense(n: int, folder: Path) -> Discs:
    """The gas squeezed with friction to solid fraction DENSE by the deck bench_dense.in in ``folder``, at rest."""
    start = gas(n)
    length = repr(cell_length(start.diameter, DENSE))
    (folder / "gas.data").write_text(data_file(start), encoding="ascii")
    run_template(folder, "bench_dense.in", {"data": "gas.data", "width": length, "height": length}).output()
    return of_frame(next(foreign_frames(folder / "dense.dump")))


def of_frame(frame: Frame) -> Discs:
    """The grains of a frame, at rest, in spatial order."""
    position = np.mod(frame.position - frame.origin, frame.cell)
    order = strips(position, frame.cell)
    return Discs(frame.diameter[order], position[order], frame.cell, np.zeros_like(position))


def state_of_run(directory: RunDirectory) -> tuple[list[tuple[str, Callable[[Path], Discs]]], dict[str, object]]:
    """The last frame of a run as the only state, with the law and step of the run.

    Raises InputError for what is no packing, or a cohesive one, which LAMMPS's own styles cannot hold together.
    """
    scene = directory.scene
    law = scene.law_of(list(scene.stages.values())[-1])
    if law is None or scene.cohesive:
        raise InputError(
            f"'{directory.path}' is no packing without cohesion, what LAMMPS's own styles can hold together; "
            "give a run made with --no-cohesion"
        )
    with Archive(archived(directory) / ARCHIVE) as archive:
        discs = of_frame(archive.frame(-1))
    common: dict[str, object] = {"kn": law.kn, "zeta": law.zeta, "mu": law.mu, "step": scene.step_choice.step}
    return [(directory.path.name, lambda folder: discs)], common

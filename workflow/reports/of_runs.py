"""Figures of runs that end in packings: how these came about.  Names and meanings: registry.py."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from workflow.archive.read import Archive
from workflow.data.frame import Floats
from workflow.errors import InputError
from workflow.pipeline.archived import archived
from workflow.pipeline.collect import no_packing
from workflow.reports import assembling
from workflow.reports.figures import Paths
from workflow.reports.history import history as draw_history
from workflow.reports.registry import Shown
from workflow.runs.directory import ARCHIVE


def history(runs: Sequence[Shown], paths: Paths) -> bool:
    """The time series of one run; False if it has none."""
    directory = archived(runs[0].directory)
    scene = _packing(runs[0])
    with Archive(directory / ARCHIVE) as archive:
        series = archive.series
    if series:
        draw_history(
            series, paths, density="solid_fraction", stresses=("stress_x", "stress_y"),
            unbalanced=("net_force", "net_moment"),
            targets={number: scene.pressure_of(name) for number, name in scene.stages.items()},
            tolerance=scene.tolerance * scene.force_unit, stages=scene.stages, force="F_0" if scene.cohesive else "aP",
        )  # fmt: skip
    return bool(series)


def density(runs: Sequence[Shown], paths: Paths) -> None:
    """Solid fraction of all runs against time on a logarithmic axis (G07 fig. 4)."""
    curves, stages = {}, {}
    for name, scene, series in _histories(runs):
        curves[name], stages[name] = series, scene.stages
    assembling.density_history(curves, paths, stages=stages)


def agitation(runs: Sequence[Shown], paths: Paths) -> None:
    """Coordination number of the free aggregates of all runs, at P* = 0, against V0 (G07 fig. 8)."""
    found: dict[float, list[float]] = {}
    for name, scene, series in _histories(runs):
        if "aggregation" not in scene.figures:
            raise InputError(f"'{name}' is {scene.name}, whose grains start at rest; give runs of method2")
        free = [number for number, stage in scene.stages.items() if scene.pressure_of(stage) == 0.0]
        rows = np.flatnonzero(np.isin(series["stage"], free))
        if not len(rows):
            raise InputError(f"the cell of '{name}' is not free yet; let it run longer, or leave it out")
        found.setdefault(scene.v0, []).append(float(series["coordination"][rows[-1]]))
    assembling.agitation(found, paths)


def consolidation(runs: Sequence[Shown], paths: Paths) -> None:
    """Solid fraction and coordination number at the end of each stress of all runs."""
    curves = {}
    for name, scene, series in _histories(runs):
        curve: list[tuple[float, float, float]] = []
        for number, stage in scene.stages.items():
            rows = np.flatnonzero(series["stage"] == number)
            stress = scene.pressure_of(stage)
            if not len(rows) or not stress:
                continue
            if curve and curve[-1][0] == stress:  # load, then settle: the latter counts
                curve.pop()
            curve.append((stress, series["solid_fraction"][rows[-1]], series["coordination"][rows[-1]]))
        if not curve:
            raise InputError(f"'{name}' was under no stress yet; let it run longer, or leave it out")
        stresses, densities, coordinations = np.array(curve).T
        curves[name] = (stresses, densities, coordinations)
    assembling.consolidation(curves, paths)


def pores(runs: Sequence[Shown], paths: Paths) -> None:
    """Frames of one run side by side, from P* = 0 to the end (fig. 5); of several runs the first and the last (fig. 7)."""
    frames, titles = [], []
    for run in runs:
        with Archive(archived(run.directory) / ARCHIVE) as archive:
            chosen = assembling.closing(archive.frames, 4 if len(runs) == 1 else 2)
            frames += [archive.frame(k) for k in chosen]
            titles += [f"{run.name}, {archive.stages[k]}" if len(runs) > 1 else archive.stages[k] for k in chosen]
    assembling.snapshots(frames, paths, names=titles)


def _histories(runs: Sequence[Shown]) -> Iterator[tuple[str, Any, Mapping[str, Floats]]]:
    """Name, scene and time series of each run.  Raises InputError for one that is no packing and one without series."""
    for run in runs:
        directory, scene = archived(run.directory), _packing(run)
        with Archive(directory / ARCHIVE) as archive:
            series = archive.series
        if not series:
            raise InputError(f"'{directory.path}' has no time series; let it run longer")
        yield run.name, scene, series


def _packing(run: Shown) -> Any:
    """The scene of a run that these figures show."""
    scene = run.directory.scene
    if "history" not in scene.figures:
        raise InputError(no_packing(run.directory))
    return scene

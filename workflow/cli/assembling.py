"""Figures of `wf plot` that show how packings came about."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from workflow.archive.read import Archive
from workflow.cli.sources import archived, packing
from workflow.data.frame import Floats
from workflow.errors import InputError
from workflow.pipeline.collect import ARCHIVE
from workflow.runs.directory import RunDirectory
from workflow.scene.method2 import Method2
from workflow.scene.registry import Packed


def density(directories: Sequence[Path], paths: Sequence[Path], names: Sequence[str] | None = None) -> None:
    """Solid fraction of all runs against time on a logarithmic axis (G07 fig. 4); ``names`` instead of the directories'."""
    from workflow.reports.assembling import density_history  # matplotlib is slow to import

    runs, stages = {}, {}
    for name, scene, series in _histories(directories, names):
        runs[name], stages[name] = series, scene.stages
    density_history(runs, paths, stages=stages)


def agitation(directories: Sequence[Path], paths: Sequence[Path], names: Sequence[str] | None = None) -> None:
    """Coordination number of the free aggregates of all runs, at P* = 0, against V0 (G07 fig. 8)."""
    from workflow.reports import assembling

    found: dict[float, list[float]] = {}
    for name, scene, series in _histories(directories, names):
        if not isinstance(scene, Method2):
            raise InputError(f"'{name}' is {scene.name}, whose grains start at rest; give runs of method2")
        free = [number for number, stage in scene.stages.items() if scene.pressure_of(stage) == 0.0]
        rows = np.flatnonzero(np.isin(series["stage"], free))
        if not len(rows):
            raise InputError(f"the cell of '{name}' is not free yet; let it run longer, or leave it out")
        found.setdefault(scene.v0, []).append(float(series["coordination"][rows[-1]]))
    assembling.agitation(found, paths)


def consolidation(directories: Sequence[Path], paths: Sequence[Path], names: Sequence[str] | None = None) -> None:
    """Solid fraction and coordination number at the end of each stress of all runs; ``names`` instead of the directories'."""
    from workflow.reports import assembling

    runs = {}
    for name, scene, series in _histories(directories, names):
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
        runs[name] = (stresses, densities, coordinations)
    assembling.consolidation(runs, paths)


def _histories(directories: Sequence[Path], names: Sequence[str] | None) -> Iterator[tuple[str, Packed, Mapping[str, Floats]]]:
    """Name, scene and time series of each run.  Raises InputError for a heap and for a run without series."""
    for path, name in zip(directories, names or [path.name for path in directories], strict=True):
        directory = archived(RunDirectory.open(path))
        scene = packing(directory)
        with Archive(directory / ARCHIVE) as archive:
            series = archive.series
        if not series:
            raise InputError(f"'{path}' has no time series; let it run longer")
        yield name, scene, series


def pores(directories: Sequence[Path], paths: Sequence[Path], names: Sequence[str] | None = None) -> None:
    """Frames of one run side by side, from P* = 0 to the end (fig. 5); of several runs the first and the last (fig. 7).

    ``names`` of the runs instead of the directories'."""
    from workflow.reports.assembling import closing, snapshots

    frames, titles = [], []
    for path, name in zip(directories, names or [path.name for path in directories], strict=True):
        with Archive(archived(RunDirectory.open(path)) / ARCHIVE) as archive:
            chosen = closing(archive.frames, 4 if len(directories) == 1 else 2)
            frames += [archive.frame(k) for k in chosen]
            titles += [f"{name}, {archive.stages[k]}" if len(directories) > 1 else archive.stages[k] for k in chosen]
    snapshots(frames, paths, names=titles)


# by the names of their figures
TOGETHER = {"density": density, "pores": pores, "agitation": agitation, "consolidation": consolidation}

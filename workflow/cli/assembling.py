"""Figures of `wf plot` that show how packings came about."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from workflow.archive.read import Archive
from workflow.cli.sources import archived
from workflow.engine.collect import ARCHIVE
from workflow.engine.rundir import RunDirectory
from workflow.errors import InputError


def density(directories: Sequence[Path], paths: Sequence[Path]) -> None:
    """Solid fraction of all runs against time on a logarithmic axis (G07 fig. 4)."""
    from workflow.report.assembling import density_history  # matplotlib is slow to import

    runs, stages = {}, {}
    for path in directories:
        directory = archived(RunDirectory.open(path))
        with Archive(directory / ARCHIVE) as archive:
            runs[path.name] = archive.series
        stages[path.name] = directory.scene.stages
        if not runs[path.name]:
            raise InputError(f"'{path}' has no time series; let it run longer")
    density_history(runs, paths, stages=stages)


def pores(directories: Sequence[Path], paths: Sequence[Path]) -> None:
    """Frames of one run side by side, from P* = 0 to the end (fig. 5); of several runs the first and the last (fig. 7)."""
    from workflow.report.assembling import closing, snapshots

    frames, names = [], []
    for path in directories:
        with Archive(archived(RunDirectory.open(path)) / ARCHIVE) as archive:
            chosen = closing(archive.frames, 4 if len(directories) == 1 else 2)
            frames += [archive.frame(k) for k in chosen]
            names += [f"{path.name}, {archive.stages[k]}" if len(directories) > 1 else archive.stages[k] for k in chosen]
    snapshots(frames, paths, names=names)

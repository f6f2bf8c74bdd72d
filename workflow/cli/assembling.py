"""Figures of `wf plot` that show how packings came about."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from workflow.archive.read import Archive
from workflow.cli.sources import archived
from workflow.engine.collect import ARCHIVE
from workflow.engine.rundir import RunDirectory
from workflow.errors import InputError


def density(directories: Sequence[Path], paths: Sequence[Path], names: Sequence[str] | None = None) -> None:
    """Solid fraction of all runs against time on a logarithmic axis (G07 fig. 4); ``names`` instead of the directories'."""
    from workflow.report.assembling import density_history  # matplotlib is slow to import

    runs, stages = {}, {}
    for path, name in zip(directories, names or [path.name for path in directories], strict=True):
        directory = archived(RunDirectory.open(path))
        with Archive(directory / ARCHIVE) as archive:
            runs[name] = archive.series
        stages[name] = directory.scene.stages
        if not runs[name]:
            raise InputError(f"'{path}' has no time series; let it run longer")
    density_history(runs, paths, stages=stages)


def pores(directories: Sequence[Path], paths: Sequence[Path], names: Sequence[str] | None = None) -> None:
    """Frames of one run side by side, from P* = 0 to the end (fig. 5); of several runs the first and the last (fig. 7).

    ``names`` of the runs instead of the directories'."""
    from workflow.report.assembling import closing, snapshots

    frames, titles = [], []
    for path, name in zip(directories, names or [path.name for path in directories], strict=True):
        with Archive(archived(RunDirectory.open(path)) / ARCHIVE) as archive:
            chosen = closing(archive.frames, 4 if len(directories) == 1 else 2)
            frames += [archive.frame(k) for k in chosen]
            titles += [f"{name}, {archive.stages[k]}" if len(directories) > 1 else archive.stages[k] for k in chosen]
    snapshots(frames, paths, names=titles)

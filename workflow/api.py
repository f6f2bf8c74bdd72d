"""The public functions of the package: scenes run, opened, measured, drawn, reported and swept from Python.

    >>> import workflow as wf
    >>> packing = wf.run("method1", n=400, mu=0.3)
    >>> packing.measures["solid_fraction"], packing.frames[-1].interactions.to_pandas()
    >>> packing.plot("distribution")

Wrong input raises `InputError`, a `ValueError` whose message is one sentence; see `workflow.errors` for the others.
"""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from os import PathLike
from pathlib import Path, PosixPath
from typing import Any, ClassVar

from workflow.archive.read import Archive
from workflow.campaign.carry_out import Orders, carry_out
from workflow.campaign.results import write_results
from workflow.campaign.study import Study
from workflow.campaign.sweep import points_of
from workflow.data.contact_law import ContactLaw
from workflow.data.frame import Floats, Frame
from workflow.data.series import read_last_row
from workflow.errors import EngineError, InputError, WorkflowError
from workflow.measures.registry import chosen_groups, plain
from workflow.pipeline import run as pipeline
from workflow.pipeline import sources as pipeline_sources
from workflow.pipeline.archived import archived
from workflow.pipeline.collect import measures_of
from workflow.pipeline.dumps import measures_of_dump, settings_of_dump
from workflow.runs.directory import ARCHIVE, RunDirectory, default_directory
from workflow.runs.installation import check_room, engine
from workflow.scene.base import Scene
from workflow.scene.consolidation import Consolidation
from workflow.scene.heap import Heap
from workflow.scene.method1 import Method1
from workflow.scene.method2 import Method2
from workflow.scene.named import scene_named
from workflow.scene.registry import load_scenes

__all__ = [
    "Consolidation", "ContactLaw", "Frame", "Heap", "Method1", "Method2", "Run", "measure", "open", "plot", "report", "run",
    "sweep",
]  # fmt: skip


class Picture(PosixPath):
    """The path of a figure; a notebook shows what is in the file."""

    WIDTH: ClassVar[int] = 560  # pixels in a notebook: figures have the resolution of print

    def _repr_mimebundle_(self, **_: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        kind = {".png": "image/png", ".svg": "image/svg+xml", ".gif": "image/gif"}.get(self.suffix.lower())
        if kind is None or not self.is_file():
            return {"text/plain": str(self)}, {}
        data = self.read_bytes()
        shown = data.decode() if kind.endswith("xml") else b64encode(data).decode("ascii")
        return {"text/plain": str(self), kind: shown}, {kind: {"width": self.WIDTH}}


@dataclass(frozen=True, repr=False)
class Run:
    """A run in its ``directory``, made by `run` or found by `open`.  A notebook shows its first figure and its summary."""

    directory: Path

    def __repr__(self) -> str:
        scene, time = self.scene, ""
        with suppress(WorkflowError, OSError, KeyError):  # it has no row yet, or is caught in the middle of a write
            time = f" at t = {read_last_row(self.directory / 'series.txt')['time'][-1]:.6g} {scene.units.plain.time}"
        return f"<Run {str(self.directory)!r}: {scene.name}, {scene.sample}, {self.status}{time}>"

    def _repr_html_(self) -> str:
        from workflow.reports.card import card

        return card(self._record)

    def plot(self, figure: str = "forces", out: str | PathLike[str] | None = None, frame: int = -1) -> Picture:
        """Draw a figure of `wf plot`, see `plot`."""
        return plot(self, figure, out, frame)

    def report(self, out: str | PathLike[str] | None = None) -> Path:
        """Write the HTML page of the run, see `report`."""
        return report(self, out)

    @property
    def scene(self) -> Scene:
        """The scene that was run; its parameters are attributes, ``run.scene.mu``."""
        return self._record.scene

    @property
    def status(self) -> str:
        """ "finished", "interrupted" (`wf resume` continues it), "failed", "running" or "prepared"."""
        return str(self._record.state["status"])

    @property
    def archive(self) -> Path:
        """The HDF5 file (H5MD) with all frames and the time series, made now if the run has none.  Raises ArchiveError."""
        return archived(self._record) / ARCHIVE

    @property
    def frames(self) -> Sequence[Frame]:
        """All frames, each read when it is asked for: ``run.frames[-1]`` is the last.  Raises ArchiveError."""
        return Archive(self.archive).frames

    @property
    def series(self) -> Mapping[str, Floats]:
        """The time series, column name -> (rows,) float64, in the units of the scene.  Raises ArchiveError."""
        with Archive(self.archive) as archive:
            return archive.series

    @property
    def measures(self) -> dict[str, Any]:
        """The measures of the last frame, as `wf measure --json` prints them.  Raises ArchiveError."""
        return measure(self)

    @property
    def _record(self) -> RunDirectory:
        return RunDirectory.open(self.directory)


Source = Run | str | PathLike[str]


def run(scene: Scene | str | PathLike[str], out: str | PathLike[str] | None = None, ranks: int = 1, **parameters: Any) -> Run:
    """Run a scene to its end, archive and measure it; progress goes to standard error, or to the cell of a
    notebook.

    ``scene``: a scene, ``Method1(mu=0.3)``; or the name of one, or the path of a TOML file, with ``parameters`` on top.
    ``out``: the run directory, made now (None: runs/NAME-HASH); ``ranks``: MPI ranks on this machine.

    A KeyboardInterrupt stops the run at its next checkpoint; its status is then "interrupted".  Raises InputError for
    parameters that are not allowed and for a directory that is not empty, EnvironmentFault if engine or plugin are
    missing, EngineError with the engine's words if it stops.
    """
    check_room(ranks)
    chosen = _scene(scene, parameters)
    engine()
    directory = RunDirectory.create(default_directory(chosen) if out is None else Path(out), chosen, ranks=ranks)
    pipeline.run(directory, ranks=ranks)
    return Run(directory.path)


def _scene(scene: Scene | str | PathLike[str], parameters: Mapping[str, Any]) -> Scene:
    if isinstance(scene, str | PathLike):
        load_scenes()
        return scene_named(str(scene), parameters)
    if parameters:
        name = next(iter(parameters))
        raise InputError(f"'{name}' stands beside a scene, which has its parameters: write {type(scene).__name__}({name}=...)")
    return scene


def open(path: str | PathLike[str]) -> Run:
    """The run in the directory ``path``.  Raises InputError if there is none."""
    return Run(RunDirectory.open(Path(path)).path)


def _opened(source: Source) -> Run:
    """The run.  Raises InputError if ``source`` is neither one nor the path of one."""
    if not isinstance(source, Run | str | PathLike):
        raise InputError(f"{source!r} is no run; give what workflow.run or workflow.open returned, or the path of a run")
    return source if isinstance(source, Run) else open(source)


def measure(
    source: Source | Frame, frame: int = -1, groups: Sequence[str] | None = None, *, window: tuple[float, float] | None = None,
    spacing: float | None = None, law: ContactLaw | None = None, force_unit: float | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Every number that `wf measure --json` gives, under the same keys.

    ``source``: a run, the path of one, or a frame from anywhere.  ``frame``: of a run, negative from the end.  ``groups``:
    names of groups of measures, ["all"] or ["none"] (None: those that are cheap for so many grains).  ``window``: range of
    k of the fractal fit [1/a], ``spacing``: mesh of C(r) and of the holes [a] (None: as `wf measure --help` says).  For a
    frame ``law``: that of its contacts (None: stiffnesses count in units of K_N, and what needs mu is undefined), and
    ``force_unit`` F1 (None: F0, or the mean |N|).

    Raises InputError for a frame or group that does not exist.
    """
    options = {"window": window, "spacing": spacing}
    if not isinstance(source, Frame):
        if law is not None or force_unit is not None:
            raise InputError("law and force_unit are for a frame; a run has its own: leave them out")
        return measures_of(archived(_opened(source)._record), frame, groups=groups, **options)
    given = ContactLaw(kn=1.0, kt=1.0, mu=math.nan) if law is None else law
    settings = settings_of_dump(source, given, force_unit=force_unit, **options)
    return dict(plain(measures_of_dump(source, settings, chosen_groups(groups, source.grains))))


def plot(source: Source, figure: str = "forces", out: str | PathLike[str] | None = None, frame: int = -1) -> Picture:
    """Draw a figure of `wf plot` of one run; the path of the file, which a notebook shows.

    ``figure``: its name; ``out``: the file, of any format that matplotlib writes (None: in the run directory, PNG where the
    figure has no format of its own); ``frame``: negative from the end.  Raises InputError for a figure or a format that does
    not exist, or if the run has not what the figure needs.
    """
    from workflow.reports.draw import draw_one

    return Picture(draw_one(pipeline_sources.Run(_opened(source).directory, frame), figure, None if out is None else Path(out)))


def report(source: Source, out: str | PathLike[str] | None = None) -> Path:
    """Write the HTML page of a run, which needs no other file; its path.

    ``out``: the file (None: report.html in the run directory).  Raises InputError for a name that does not end in .html.
    """
    from workflow.reports.registry import PAGE
    from workflow.reports.sheets import write_page_of  # matplotlib is slow to import

    opened = _opened(source)
    path = opened.directory / PAGE if out is None else Path(out)
    write_page_of([pipeline_sources.Run(opened.directory)], path, "workflow.report")
    return path


def sweep(
    scene: str, grid: Mapping[str, Iterable[Any]], seeds: int | Iterable[int] = 1, out: str | PathLike[str] | None = None,
    jobs: int = 1, **fixed: Any,
) -> list[Run]:  # fmt: skip
    """Compute every combination of the lists of ``grid`` for every seed, each once; the runs in their order.

    ``scene``: its name; ``seeds``: how many (1, 2, ...), or a list; ``fixed``: parameters that all runs share; ``out``:
    folder of the study (None: runs/SCENE-sweep); ``jobs``: runs at a time.  What is there already is not computed again;
    a KeyboardInterrupt stops all runs at their next checkpoints, and the same call continues them.

    Raises InputError for a declaration that is not allowed, EngineError if a run fails.
    """
    load_scenes()
    listed = {name: plain(list(values)) if isinstance(values, Iterable) else values for name, values in grid.items()}
    numbers = seeds if isinstance(seeds, int) else plain(list(seeds))
    points = points_of({"scene": scene, "grid": listed, "seeds": numbers, "fixed": plain(fixed)})
    study = Study(Path("runs") / f"{scene}-sweep" if out is None else Path(out), points)
    outcome = carry_out(study, Orders(jobs=jobs))
    if outcome.interrupted:
        raise KeyboardInterrupt
    if outcome.done < len(study.points):
        raise EngineError(f"{outcome.done} of {len(study.points)} runs are done; 'wf status {study.folder}' says why")
    write_results(study)
    return [Run(study.directory(point).path) for point in study.points]

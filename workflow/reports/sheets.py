"""From sources to the page: the sheet of each run and dump, under names that tell them apart."""

from __future__ import annotations

import hashlib
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from workflow import __version__
from workflow.archive.read import Archive
from workflow.data.frame import Frame
from workflow.data.notes import tell
from workflow.data.si import DIMENSIONS, Powder, in_words
from workflow.errors import InputError, WorkflowError
from workflow.measures.registry import chosen_groups
from workflow.pipeline.collect import stored_measures
from workflow.pipeline.si import of_frame, of_measures, of_scene
from workflow.pipeline.sources import Dumps, Run, Source, measures_of_dump
from workflow.reports.page import write_report
from workflow.reports.page_data import ReportData
from workflow.reports.summary import lines
from workflow.reports.views import VIEWS, PackingView, View
from workflow.runs.directory import ARCHIVE, FINISHED, RunDirectory
from workflow.runs.standing import standing
from workflow.scene.base import Units

FILM, MOST_FRAMES = 4e6, 60  # letters and frames at most that a page plays


def write_page_of(given: Sequence[Source], out: Path, command: str, powder: Powder | None = None) -> None:
    """Write the page of ``given`` sources, of each run below those that are folders of runs; ``command``: what makes it;
    ``powder``: also in SI.

    Of several the page says why one has nothing to show.  Raises InputError.
    """
    if out.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--out {out} is not allowed: the page is HTML; give a name that ends in .html")
    sources = list({found.name: found for source in given for found in _runs(source)}.values())
    sheets, absent = [], []
    room = FILM / len(sources)
    for name, source in zip(_names(sources), sources, strict=True):
        try:
            sheets.append(_of_run(name, source, room) if isinstance(source, Run) else _of_dump(name, source, command, room))
        except WorkflowError as fault:
            if len(sources) == 1 or fault.status == 2:
                raise
            absent.append((name, _state(source), str(fault)))
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise InputError(f"cannot create '{out.parent}': {fault.strerror}; give another --out FILE") from fault
    if powder:
        sheets = [replace(sheet, si=_in_si(sheet, powder)) for sheet in sheets]
    write_report(out, sheets[0].name if len(sources) == 1 else f"{len(sources)} runs", sheets, absent)


def _in_si(sheet: ReportData, powder: Powder) -> list[tuple[str, str]]:
    """The units, the parameters and the measures of a run in SI.  Raises InputError for the dump of another program."""
    if sheet.scene is None:
        raise InputError(f"--si is for runs; '{sheet.name}' is the dump of another program, in units of its own")
    rows = [*of_scene(sheet.scene, powder), *of_measures(sheet.measures), *of_frame(sheet.frame)]
    units = [(f"unit of {name}", in_words(*powder.unit(name))) for name in DIMENSIONS]
    return units + [(name, powder.words(value, dimension)) for name, value, dimension in rows]


def _runs(source: Source) -> Sequence[Source]:
    """The source itself, or the runs below a folder that is none."""
    if isinstance(source, Dumps) or (source.path / "run.json").is_file():
        return [source]
    below = sorted(path.parent for path in source.path.rglob("run.json"))
    if not below:
        RunDirectory.open(source.path)  # says what is wrong
    return [replace(source, path=path) for path in below]


def _names(sources: Sequence[Source]) -> list[str]:
    """Names of the sources, with as many of their folders as it takes to tell them apart."""
    paths = [Path(source.name).resolve() for source in sources]
    for parts in range(1, max(len(path.parts) for path in paths) + 1):
        names = ["/".join(path.parts[-parts:]) for path in paths]
        if len(set(names)) == len(names):
            break
    return names


def _state(source: Source) -> str:
    try:
        return str(standing(RunDirectory.open(source.folder))["status"]) if isinstance(source, Run) else "dump"
    except WorkflowError:
        return "damaged"


def _of_run(name: str, source: Run, room: float) -> ReportData:
    directory = source.run
    scene, state = directory.scene, standing(directory)
    with Archive(directory / ARCHIVE) as archive:
        frame, count, origin = archive.frame(source.number), len(archive), archive.provenance
        series, film = archive.series, _film(archive.frame, count, frame, source.number % count, room)
    last = source.number % count == count - 1
    measures = stored_measures(directory) if last and not source.options else source.measures(None)
    note = f"Frame {source.number % count + 1} of {count}, stage {frame.stage}, t = {frame.time:.6g}, step {frame.step}."
    if state["status"] != FINISHED:
        note = f"The run is {state['status']}: this is how far it came. {note}"
    return ReportData(
        name=name, title=scene.title, state=state["status"], reason=state["reason"], note=note, frame=frame,
        force_unit=scene.force_unit, tolerance=scene.tolerance, cohesive=scene.cohesive, length=1.0, units=scene.units,
        view=VIEWS.get(scene.kind, View)(), scene=scene, series=series, measures=measures,
        numbers=list(lines(measures)), provenance=_provenance(directory, origin),
        text=(directory / "scene.toml").read_text(encoding="utf-8"), film=film,
    )  # fmt: skip


def _film(frames: Callable[[int], Frame], count: int, shown: Frame, number: int, room: float) -> list[tuple[str, Frame]]:
    """As many of the ``count`` frames with their words as have room on the page, evenly over the run, with the first, the last
    and the one that is ``shown``; none where that is all there is room for."""
    size = 17 * shown.grains + 38 * len(shown.interactions)  # bytes of the arrays of `network`
    most = min(count, int(0.75 * room / size), MOST_FRAMES)  # 4 letters hold 3 bytes
    if most < 2 or most < min(count, 3):
        return []
    chosen = sorted({*np.linspace(0, count - 1, most).round().astype(int).tolist(), number})
    found = [(k, shown if k == number else frames(k)) for k in chosen]
    return [(f"frame {k + 1} of {count}: {_words_of(frame)}", frame) for k, frame in found]


def _words_of(frame: Frame) -> str:
    """Stage and time of a frame, as far as they are known."""
    clock = f"step {frame.step}" if "time" in frame.lacks else f"t = {frame.time:.5g}"
    return f"{frame.stage}, {clock}" if frame.stage else clock


def _provenance(directory: RunDirectory, origin: Mapping[str, Any]) -> list[tuple[str, str]]:
    """From run.json and the archive: what made the run, with what, and how to repeat it."""
    state, path = directory.state, shlex.quote(str(directory.path))
    seconds = state.get("seconds")
    rows = {
        "directory": str(directory.path.resolve()), "command": state.get("command"), "started": state.get("started"),
        "finished": state.get("finished"), "run time": None if seconds is None else f"{seconds:.1f} s",
        "MPI ranks": state.get("ranks"), "step": f"{origin['step']:.6g}: {origin['step_reason']}" if "step" in origin else None,
        "relaxation": origin.get("relaxation"), "digest of the scene": state["digest"],
        **{f"version of {name}": version for name, version in state["versions"].items()},
        **{f"SHA-256 of {name}": hashed for name, hashed in origin.get("hashes", {}).items()},
        "to repeat it": f"wf verify {path}, or wf run {path}/scene.toml --out again", "page by": f"workflow {__version__}",
    }  # fmt: skip
    return [(name, str(value)) for name, value in rows.items() if value is not None]


def _of_dump(name: str, source: Dumps, command: str, room: float) -> ReportData:
    frame, law = source.frame()
    tell(frame.notes)
    frame.need("the page of a dump", "normal", "tangential", "diameter", "gap")
    measures = measures_of_dump(frame, law, chosen_groups(None, frame.grains))
    files = [("grains", path) for path in source.files.grains] + [("contacts", path) for path in source.files.contacts]
    rows = [(f"{what}: {path}", f"SHA-256 {_hash(path)}") for what, path in files]
    said = [("note", note) for note in frame.notes]
    sample = source.sample()
    count = len(sample.steps)
    clock = "" if "time" in frame.lacks else f"t = {frame.time:.6g}, "
    return ReportData(
        name=name, title="dump of another program", state="dump", reason=None,
        note=f"Frame {source.number}, {clock}step {frame.step}.", frame=frame, force_unit=law.force_unit,
        tolerance=law.tolerance, cohesive=law.law.cohesive, length=law.length,
        units=Units("a", "F₀" if law.law.cohesive else "F₁", "T₀"), view=PackingView(), scene=None, series={},
        measures=measures, numbers=list(lines({key: value for key, value in measures.items() if key != "notes"})),
        provenance=[*said, *rows, ("command of this page", command), ("page by", f"workflow {__version__}")], text="",
        film=_film(sample.frame, count, frame, source.number % count, room),
    )  # fmt: skip


def _hash(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()

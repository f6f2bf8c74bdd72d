"""wf report: one HTML page of a run, of several, or of another program's dump."""

from __future__ import annotations

import argparse
import hashlib
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workflow import __version__
from workflow.archive.read import Archive
from workflow.archive.samples import Files
from workflow.cli.measure import lines
from workflow.cli.options import command, command_line
from workflow.cli.sources import (
    Source,
    add_sources,
    archived,
    folder_of,
    frame_of,
    measures_from,
    name_of,
    sources_of,
    tell,
)
from workflow.cli.status import standing
from workflow.errors import InputError, WorkflowError
from workflow.measures.registry import chosen_groups
from workflow.pipeline.collect import stored_measures
from workflow.pipeline.dumps import measures_of_dump
from workflow.pipeline.heap import ground
from workflow.runs.directory import ARCHIVE, FINISHED, RunDirectory
from workflow.scene.heap import Heap

if TYPE_CHECKING:
    from workflow.reports.page_data import Sheet

EXAMPLES = """
wf report packing                          packing/report.html: results, force network, time series, errors, provenance
wf report packing --frame 0                of the first frame
wf report runs                             runs/report.html: a table of all runs below, and the page of each
wf report runs/method1-* --out study.html  some of them
wf report grains.dump --contacts contacts.dump   LAMMPS dumps of another deck
"""
PAGE = "report.html"


def declare(commands: Any) -> None:
    """Options of `wf report`."""
    parser = command(commands, "report", "write an HTML page of a run or of several, to look at in a browser", EXAMPLES,
                     action=action)  # fmt: skip
    add_sources(parser)
    parser.add_argument("--out", type=Path, metavar="FILE", help=f"the page (default: {PAGE} in the directory, or here)")


def action(arguments: argparse.Namespace) -> int:
    """Read everything, write the page, say where it is."""
    given = sources_of(arguments)
    out = arguments.out or _place(given)
    write_page(given, out, arguments)
    print(out)
    return 0


def write_page(given: Sequence[Source], out: Path, arguments: argparse.Namespace) -> None:
    """Write the page of ``given`` sources to ``out``.  Raises InputError."""
    if out.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--out {out} is not allowed: the page is HTML; give a name that ends in .html")
    sources = list(dict.fromkeys(found for source in given for found in _runs(source)))
    from workflow.reports.page import write_report  # matplotlib is slow to import

    sheets, absent = [], []
    for name, source in zip(_names(sources), sources, strict=True):
        try:
            sheets.append(_run(name, source, arguments) if isinstance(source, Path) else _dump(name, source, arguments))
        except WorkflowError as fault:
            if len(sources) == 1 or fault.status == 2:
                raise
            absent.append((name, _state(source), str(fault)))
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise InputError(f"cannot create '{out.parent}': {fault.strerror}; give another --out FILE") from fault
    title = sheets[0].name if len(sources) == 1 else f"{len(sources)} runs"
    write_report(out, title, sheets, absent)


def _place(sources: Sequence[Source]) -> Path:
    return Path(PAGE) if len(sources) > 1 else folder_of(sources[0]) / PAGE


def _runs(source: Source) -> list[Source]:
    """The source itself, or the run directories below a folder that is none."""
    if not isinstance(source, Path) or (source / "run.json").is_file():
        return [source]
    below: list[Source] = [*sorted(path.parent for path in source.rglob("run.json"))]
    if not below:
        RunDirectory.open(source)  # says what is wrong
    return below


def _names(sources: Sequence[Source]) -> list[str]:
    """Names of the sources, with as many of their folders as it takes to tell them apart."""
    paths = [Path(name_of(source)).resolve() for source in sources]
    for parts in range(1, max(len(path.parts) for path in paths) + 1):
        names = ["/".join(path.parts[-parts:]) for path in paths]
        if len(set(names)) == len(names):
            break
    return names


def _state(source: Source) -> str:
    if not isinstance(source, Path):
        return "dump"
    try:
        return str(standing(RunDirectory.open(source))["status"])
    except WorkflowError:
        return "damaged"


def _run(name: str, source: Path, arguments: argparse.Namespace) -> Sheet:
    from workflow.reports.page_data import Sheet

    directory = archived(RunDirectory.open(source))
    scene, state = directory.scene, standing(directory)
    with Archive(directory / ARCHIVE) as archive:
        frame, count, origin = archive.frame(arguments.frame), len(archive), archive.provenance
        last = arguments.frame % count == count - 1
        series = archive.series
    usual = last and not arguments.window and not arguments.spacing
    measures = stored_measures(directory) if usual else measures_from(source, arguments, None)
    note = f"Frame {arguments.frame % count + 1} of {count}, stage {frame.stage}, t = {frame.time:.6g}, step {frame.step}."
    if state["status"] != FINISHED:
        note = f"The run is {state['status']}: this is how far it came. {note}"
    return Sheet(
        name=name, title=scene.title, state=state["status"], reason=state["reason"], note=note, frame=frame,
        force_unit=1.0 if isinstance(scene, Heap) else scene.force_unit, tolerance=scene.force_tolerance,
        cohesive=not isinstance(scene, Heap) and scene.cohesion, length=1.0, scene=scene,
        ground=ground(scene) if isinstance(scene, Heap) else None, series=series, measures=measures,
        numbers=list(lines(measures)), provenance=_provenance(directory, origin),
        text=(directory / "scene.toml").read_text(encoding="utf-8"),
    )  # fmt: skip


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


def _dump(name: str, source: Files, arguments: argparse.Namespace) -> Sheet:
    from workflow.reports.page_data import Sheet

    frame, law = frame_of(source, arguments)
    tell(frame.notes)
    frame.need("the page of a dump", "normal", "tangential", "diameter", "gap")
    measures = measures_of_dump(frame, law, chosen_groups(None, frame.grains))
    files = [("grains", path) for path in source.grains] + [("contacts", path) for path in source.contacts]
    rows = [(f"{what}: {path}", f"SHA-256 {_hash(path)}") for what, path in files]
    said = [("note", note) for note in frame.notes]
    given = command_line()
    clock = "" if "time" in frame.lacks else f"t = {frame.time:.6g}, "
    return Sheet(
        name=name, title="dump of another program", state="dump", reason=None,
        note=f"Frame {arguments.frame}, {clock}step {frame.step}.", frame=frame, force_unit=law.force_unit,
        tolerance=law.tolerance, cohesive=law.law.cohesive, length=law.length, scene=None, ground=None, series={},
        measures=measures, numbers=list(lines({key: value for key, value in measures.items() if key != "notes"})),
        provenance=[*said, *rows, ("command of this page", given), ("page by", f"workflow {__version__}")], text="",
    )  # fmt: skip


def _hash(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()

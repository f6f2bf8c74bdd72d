"""The figures of a paper from the runs of a study, or taken from a scoreboard made elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from workflow.archive.read import Archive
from workflow.campaign.measured import frame_index, settings_at
from workflow.campaign.study import Point, Study
from workflow.errors import WorkflowError
from workflow.pipeline.heap import ground
from workflow.reproduce.papers import Drawing
from workflow.reproduce.pool import Earlier, take_figure
from workflow.reproduce.runs import samples_of
from workflow.runs.directory import ARCHIVE
from workflow.scene.heap import Heap

Say = Callable[[str], None]
Together = Mapping[str, Callable[[Sequence[Path], Sequence[Path], Sequence[str] | None], None]]


def figures(
    study: Study, drawings: Sequence[Drawing], earlier: Sequence[Earlier], together: Together, say: Say
) -> tuple[list[dict[str, str]], list[str]]:
    """Draw into ``study.folder``: a row for each figure, and the numbers of those taken from elsewhere, of which not all
    samples are here.  ``together``: the kinds that are drawn from whole runs, by name."""
    found, taken = [], []
    for drawing in drawings:
        row = {"number": drawing.number, "plot": drawing.plot, "file": "", "shows": drawing.shows, "trouble": ""}
        whole = (len(samples_of(study, case)) >= len([*case.values()][: drawing.most]) for case in drawing.cases)
        if earlier and not all(whole):
            row["file"] = take_figure(drawing.number, earlier, study.folder)
        if row["file"]:
            taken.append(drawing.number)
        found.append(row if row["file"] else _draw(study, drawing, together, say, row))
    return found, taken


def _draw(study: Study, drawing: Drawing, together: Together, say: Say, row: dict[str, str]) -> dict[str, str]:
    """The figure's file, or why there is none."""
    name = f"figures/fig{drawing.number}.png"
    points, names = [], []
    for case in drawing.cases:
        found = samples_of(study, case)[: drawing.most]
        if not found and not drawing.partial:
            return row | {"trouble": "not all of its samples are finished"}
        points += [(point, case.stage) for point in found]
        names += [" ".join(case.where[1:]).strip()] * len(found)
    if drawing.cases and not points:
        return row | {"trouble": "no sample is finished"}
    say(f"drawing figure {drawing.number}")
    (study.folder / "figures").mkdir(exist_ok=True)
    try:
        _plot(study, drawing, together, points, names, study.folder / name)
    except WorkflowError as fault:
        return row | {"trouble": str(fault)}
    return row | {"file": name}


def _plot(
    study: Study, drawing: Drawing, together: Together, points: Sequence[tuple[Point, str | None]], names: Sequence[str],
    path: Path,
) -> None:  # fmt: skip
    """Draw by the kind of `wf plot`."""
    from workflow.reports import heap  # matplotlib is slow to import
    from workflow.reports.registry import PLOTS
    from workflow.reproduce.sketches import SKETCHES

    kind = drawing.plot
    if kind in SKETCHES:
        SKETCHES[kind]([path])
        return
    directories = [study.directory(point) for point, _ in points]
    if kind in together:
        together[kind]([directory.path for directory in directories], [path], names)
        return
    frames = []
    for directory, (_, stage) in zip(directories, points, strict=True):
        number = frame_index(directory, stage)
        with Archive(directory / ARCHIVE) as archive:
            frames.append(archive.frame(number if drawing.time is None else archive.nearest(drawing.time)))
    scene = directories[0].scene
    if isinstance(scene, Heap):
        kinds = {"heap": heap.snapshot, "vectors": heap.vectors, "forces": heap.forces, "maps": heap.maps}
        kinds[kind](frames[0], ground(scene), [path])
        return
    laws = [settings_at(directory, stage) for directory, (_, stage) in zip(directories, points, strict=True)]
    PLOTS[kind].draw([(frame, law) for frame, law in zip(frames, laws, strict=True) if law is not None], [path])

"""The figures of a paper: sketches of laws, which need no sample, and figures of the samples of a study."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from workflow.archive.read import Archive
from workflow.campaign.measured import frame_index, settings_at
from workflow.campaign.study import Study
from workflow.errors import WorkflowError
from workflow.reports.registry import FIGURES, RUNS, STUDY, Figure, Shown, figures_of, imported
from workflow.reproduce.papers import Drawing
from workflow.reproduce.pool import Earlier, take_figure
from workflow.reproduce.runs import samples_of
from workflow.runs.directory import ARCHIVE, RunDirectory

Say = Callable[[str], None]
SKETCH = "sketch"  # group of the figures that need no sample
FIGURES[SKETCH] = {
    name: Figure(meaning, imported(f"workflow.reproduce.sketches:draw_{name}"), STUDY)
    for name, meaning in (
        ("cohesive_law", "normal force against the gap, and the Coulomb cone (G07 fig. 1)"),
        ("continuous_law", "force of the continuous potential beside Hooke's law (B97 fig. 4)"),
        ("fourth_disc", "a fourth disc meets three (G07 fig. 13)"),
    )
}


def draw(drawing: Drawing, samples: Sequence[tuple[RunDirectory, str | None]], names: Sequence[str], path: Path) -> None:
    """Draw a figure of a paper from ``samples``, each with the stage at whose end it is shown, called ``names``.

    Raises WorkflowError, with the reason, if they do not give it.
    """
    if drawing.plot in FIGURES[SKETCH]:
        FIGURES[SKETCH][drawing.plot].draw([path])
        return
    figure = figures_of(samples[0][0].scene.figures)[drawing.plot]
    if figure.of == RUNS and figure.several:
        figure.draw([Shown(directory, name) for (directory, _), name in zip(samples, names, strict=True)], [path])
        return
    numbers = [_number(directory, stage, drawing.time) for directory, stage in samples]
    if figure.of == RUNS:
        figure.draw([Shown(*samples[0][:1], names[0], numbers[0])], [path])
        return
    shown = []
    for (directory, stage), number in zip(samples, numbers, strict=True):
        with Archive(directory / ARCHIVE) as archive:
            shown.append((archive.frame(number), settings_at(directory, stage)))
    figure.draw([(frame, law) for frame, law in shown if law is not None], [path])


def _number(directory: RunDirectory, stage: str | None, time: float | None) -> int:
    """The frame at the end of a stage, or the one nearest to a time."""
    number = frame_index(directory, stage)
    if time is None:
        return number
    with Archive(directory / ARCHIVE) as archive:
        return archive.nearest(time)


def figures(
    study: Study, drawings: Sequence[Drawing], earlier: Sequence[Earlier], say: Say
) -> tuple[list[dict[str, str]], list[str]]:
    """Draw into ``study.folder``: a row for each figure, and the numbers of those taken from elsewhere, of which not all
    samples are here."""
    found, taken = [], []
    for drawing in drawings:
        row = {"number": drawing.number, "plot": drawing.plot, "file": "", "shows": drawing.shows, "trouble": ""}
        whole = (len(samples_of(study, case)) >= len([*case.values()][: drawing.most]) for case in drawing.cases)
        if earlier and not all(whole):
            row["file"] = take_figure(drawing.number, earlier, study.folder)
        if row["file"]:
            taken.append(drawing.number)
        found.append(row if row["file"] else _draw(study, drawing, say, row))
    return found, taken


def _draw(study: Study, drawing: Drawing, say: Say, row: dict[str, str]) -> dict[str, str]:
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
        draw(drawing, [(study.directory(point), stage) for point, stage in points], names, study.folder / name)
    except WorkflowError as fault:
        return row | {"trouble": str(fault)}
    return row | {"file": name}

"""The figures of a paper from the runs of a study, or taken from a scoreboard made elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from workflow.campaign.study import Study
from workflow.errors import WorkflowError
from workflow.reproduce.figures import draw
from workflow.reproduce.papers import Drawing
from workflow.reproduce.pool import Earlier, take_figure
from workflow.reproduce.runs import samples_of

Say = Callable[[str], None]


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

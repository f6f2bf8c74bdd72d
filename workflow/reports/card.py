"""What a notebook shows of a run: its first figure beside the rows of its summary, as one piece of HTML."""

from __future__ import annotations

import base64
import io
import tempfile
from html import escape
from pathlib import Path

from PIL import Image  # which matplotlib needs

from workflow.errors import WorkflowError
from workflow.pipeline.collect import stored_measures
from workflow.pipeline.sources import Run
from workflow.reports.draw import draw_one
from workflow.reports.registry import figures_of
from workflow.reports.summary import SUMMARIES, lines
from workflow.runs.directory import ARCHIVE, RunDirectory

PIXELS = 700  # of the longer side of the picture
ROWS = 12  # of a kind of scene without a summary of its own
ROW = '<tr><th style="text-align:left;font-weight:normal;opacity:.7">{}</th><td style="text-align:left">{}</td></tr>'


def card(directory: RunDirectory) -> str:
    """HTML of a run: title, sample and state, then picture and summary if it has an archive; nothing is written for it."""
    scene, state = directory.scene, directory.state["status"]
    head = f"<b>{escape(scene.title)}</b><br>{escape(f'{scene.sample}, {directory.path}: {state}')}"
    if not (directory / ARCHIVE).is_file():
        return f"<div>{head}</div>"
    try:
        of_kind, measures = SUMMARIES.get(scene.kind), stored_measures(directory)
        title, rows = of_kind(measures) if of_kind else ("", list(lines(measures))[:ROWS])
        picture = _picture(directory)
    except WorkflowError as fault:  # a display must not fail; the same call by name raises it
        return f"<div>{head}<br>{escape(str(fault))}</div>"
    table = "".join(ROW.format(escape(name), escape(text)) for name, text in rows)
    return (f'<div>{head}, {escape(title)}<div style="display:flex;flex-wrap:wrap;gap:1em;align-items:flex-start">'
            f'{picture}<table style="width:auto">{table}</table></div></div>')  # fmt: skip


def _picture(directory: RunDirectory) -> str:
    """The first of the figures that `wf plot` draws unasked, as an image; nothing where none is a picture."""
    usual = [name for name, figure in figures_of(directory.scene.figures).items() if figure.unasked and not figure.formats]
    if not usual:
        return ""
    with tempfile.TemporaryDirectory(prefix="wf-card-") as folder:
        drawn = Image.open(draw_one(Run(directory.path), usual[0], Path(folder) / f"{usual[0]}.png"))
        drawn.thumbnail((PIXELS, PIXELS))  # it has the resolution of print
        small = io.BytesIO()
        drawn.save(small, "PNG")
    return (f'<img alt="{escape(usual[0])}" style="width:22em;max-width:100%" '
            f'src="data:image/png;base64,{base64.b64encode(small.getvalue()).decode("ascii")}">')  # fmt: skip

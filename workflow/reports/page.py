"""The HTML page of a run or of several: results, force network, time series, errors, provenance in one file."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import replace
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from workflow.data.files import atomic_write
from workflow.measures.alike import labels
from workflow.reports.numbers import Number, errors
from workflow.reports.page_data import KINDS, ReportData, charts, film, kinds, network, shown_of
from workflow.reports.study_page import document, table, template

SCRIPTS = ("common.js", "network.js", "player.js", "chart.js", "report.js")
MOST_PARAMETERS = 8  # columns of a study's table for the parameters in which its runs differ
LOOKS = {"compressive": "compressive", "tensile": "tensile", "distant": "distant", "no force": "idle"}
DASHES = {"tensile": "dashed", "distant": "dotted"}
WORDS = {"distant": "distant pair", "no force": "contact without force"}
FINE = {True: ("good", "in equilibrium"), False: ("bad", "not in equilibrium")}


def write_report(path: Path, title: str, sheets: Sequence[ReportData], absent: Sequence[tuple[str, str, str]] = ()) -> None:
    """Write the page of ``sheets``; ``absent``: name, state and reason of runs that have nothing to show."""
    several = len(sheets) + len(absent) > 1
    data: dict[str, Any] = {"runs": []}
    articles = []
    words = labels([_parameters(sheet) for sheet in sheets], [sheet.name for sheet in sheets])  # what tells curves apart
    for number, sheet in enumerate(sheets):
        drawn, arrays, every = charts(sheet)
        run = {
            "name": sheet.name,
            "label": words[number],
            "network": network(sheet),
            "charts": drawn,
            "arrays": arrays,
        }
        data["runs"].append(run | ({"film": film(sheet)} if sheet.film else {}))
        articles.append(_article(number, sheet, drawn, every, several))
    theme = '<button type="button" class="screen" data-control="theme">Dark colours</button>'
    body = f"<header><h1>{escape(title)}</h1>{theme}</header><noscript><p>The drawings need JavaScript.</p></noscript><main>"
    if several:
        body += _study(sheets, absent, data["runs"])
    body += "".join(articles) + "</main>"
    text = document(title, body, style=template("report.css"), script="".join(map(template, SCRIPTS)), data=data)
    with atomic_write(path) as draft:
        draft.write_text(text, encoding="utf-8")


def _article(number: int, sheet: ReportData, drawn: Sequence[dict[str, Any]], every: int, several: bool) -> str:
    time = [k for k, chart in enumerate(drawn) if chart["time"]]
    other = [k for k, chart in enumerate(drawn) if not chart["time"]]
    sections = [("network", "Force network", _network(sheet))]
    if time:
        sections.append(("series", "Time series", _series(time, every, len(sheet.series["time"]))))
    if other:
        figures = "".join(f"<div data-group>{_charts([k])}</div>" for k in other)
        sections.append(("distributions", "Distributions and profiles", f'<div class="charts">{figures}</div>'))
    if sheet.si:
        sections.append(("si", "In SI", table(("quantity", "SI"), [list(row) for row in sheet.si])))
    sections += [("errors", "Errors", _errors(sheet)), ("measures", "All measures", _measures(sheet)),
                 ("provenance", "Provenance", _provenance(sheet))]  # fmt: skip
    links = "".join(f'<a href="#r{number}-{key}">{name}</a>' for key, name, _ in sections)
    return (
        f'<article data-run="{number}" id="r{number}">'
        + (f"<h2>{escape(sheet.name)}</h2>" if several else "")
        + f'<p class="muted">{escape(sheet.title)}</p><p>{_badges(sheet)} {escape(sheet.note)}</p>'
        + (f'<p class="bad">{escape(sheet.reason)}</p>' if sheet.reason else "")
        + f'<nav class="screen" aria-label="Sections">{links}</nav>{_cards(sheet.view.results(sheet))}'
        + "".join(f'<section><h2 id="r{number}-{key}">{name}</h2>{html}</section>' for key, name, html in sections)
        + "</article>"
    )


def _badges(sheet: ReportData) -> str:
    found = [({"finished": "good", "failed": "bad"}.get(sheet.state, "muted"), sheet.state)]
    if sheet.measures.get("equilibrated") is not None:
        found.append(FINE[sheet.measures["equilibrated"]])
    return "".join(f'<span class="badge {look}">{escape(word)}</span>' for look, word in found)


def _cards(found: Sequence[Number]) -> str:
    def card(n: Number) -> str:
        note = f"<small>{escape(n.note)}</small>" if n.note else ""
        return f"<div><dt>{escape(n.name)}</dt><dd>{escape(n.text)}{note}</dd></div>"

    return f'<dl class="cards">{"".join(map(card, found))}</dl>'


def _network(sheet: ReportData) -> str:
    """The drawing with its controls."""
    count = np.bincount(kinds(sheet), minlength=len(KINDS))
    ever = count + sum(np.bincount(kinds(replace(sheet, frame=frame)), minlength=len(KINDS)) for _, frame in sheet.film)
    words = [WORDS.get(name, name) for name in KINDS]
    there = [k for k in range(len(KINDS)) if ever[k]]
    keys = [_key(f'data-kind="{k}" checked', _swatch(KINDS[k]), words[k], str(count[k])) for k in there]
    keys += [_key("", _dot(look), name, "") for look, name in sheet.view.marks]
    sliding = int(sheet.frame.interactions.sliding.sum())
    if sliding:
        keys.append(_key('data-control="marks"', _dot("extra"), "mark sliding contacts", str(sliding)))
    parts = ", ".join(f"{count[k]} {words[k]}" for k in there)
    label = f"Force network of {sheet.frame.grains} grains: {parts or 'no interaction'}."
    flat = " flat" if sheet.view.flat else ""
    return Template(template("network.html")).substitute(
        keys="\n".join(keys), label=escape(label), flat=flat, player=_player(sheet)
    )


def _player(sheet: ReportData) -> str:
    """Button and slider over the frames, where there are several."""
    if not sheet.film:
        return ""
    last, shown = len(sheet.film) - 1, shown_of(sheet)
    return (
        '<div class="player screen"><button type="button">Play</button>'
        f'<input type="range" min="0" max="{last}" step="1" value="{shown}" aria-label="Frame">'
        f"<output>{escape(sheet.film[shown][0])}</output></div>\n"
    )


def _key(control: str, sign: str, name: str, count: str) -> str:
    """An entry of the legend, with a box to tick where there is something to ``control``."""
    box = f'<input type="checkbox" class="screen" {control}>' if control else ""
    return f"<label>{box}{sign}{name}<output>{count}</output></label>"


def _swatch(kind: str) -> str:
    thin = " thin" if kind == "no force" else ""
    return f'<span class="swatch{thin} {DASHES.get(kind, "")}" style="border-color: var(--{LOOKS[kind]})"></span>'


def _dot(look: str) -> str:
    return f'<span class="dot" style="background: var(--{look})"></span>'


def _charts(numbers: Sequence[int]) -> str:
    return "".join(f'<figure class="chart" data-chart="{k}"></figure>' for k in numbers)


ZOOM = ('<p class="bar screen"><label><input type="checkbox" data-control="logx">logarithmic time</label>'
        '<button type="button" data-control="whole">Show all times</button><span class="muted">Drag over a stretch of time '
        "to zoom; point to read values.</span></p>")  # fmt: skip


def _series(numbers: Sequence[int], every: int, rows: int) -> str:
    thinned = f'<p class="muted">One row in {every} of {rows}; all are in series.txt and run.h5.</p>' if every > 1 else ""
    return f'{ZOOM}<div class="charts" data-group>{_charts(numbers)}</div>{thinned}'


def _errors(sheet: ReportData) -> str:
    words = {True: "✓ kept", False: "✗ not kept", None: ""}
    rows = [[e.name, e.text, e.limit, words[e.kept]] for e in errors(sheet)]
    return table(("error figure", "value", "limit", "verdict"), rows)


def _measures(sheet: ReportData) -> str:
    rows = table(("measure", "value"), [list(row) for row in sheet.numbers])
    return f"<details><summary>{len(sheet.numbers)} numbers, in units of the scene</summary>{rows}</details>"


def _provenance(sheet: ReportData) -> str:
    scene = f"<h3>scene.toml</h3><pre>{escape(sheet.text)}</pre>" if sheet.text else ""
    return table(("what", "value"), [list(row) for row in sheet.provenance]) + scene


# ---- several runs
def _study(sheets: Sequence[ReportData], absent: Sequence[tuple[str, str, str]], runs: Sequence[dict[str, Any]]) -> str:
    """Table of the runs with mean and standard error, and one quantity of all against time."""
    text = _runs(sheets, absent)
    titles = list(dict.fromkeys(chart["title"] for run in runs for chart in run["charts"] if chart["time"]))
    if titles:
        options = "".join(f"<option>{escape(title)}</option>" for title in titles)
        text += (
            '<section id="compare"><h2>All runs against time</h2>'
            f'<p class="bar"><label>quantity <select>{options}</select></label></p>'
            f'{ZOOM}<figure class="chart" data-compare></figure></section>'
        )
    return text


def _runs(sheets: Sequence[ReportData], absent: Sequence[tuple[str, str, str]]) -> str:
    columns = _columns(sheets)
    head = "".join(f'<th scope="col"><button type="button">{escape(name)}</button></th>' for name in ("run", "state", *columns))
    rows = []
    for number, sheet in enumerate(sheets):
        state = f"{sheet.state}{'' if sheet.measures.get('equilibrated') in (True, None) else ', not in equilibrium'}"
        cells = "".join(f'<td data-value="{_sort(cell)}">{escape(cell.text)}</td>' for cell in _cells(sheet, columns))
        link = f'<a href="#r{number}">{escape(sheet.name)}</a>'
        rows.append(f'<tr data-run="{number}"><th scope="row">{link}</th><td>{escape(state)}</td>{cells}</tr>')
    for name, state, reason in absent:
        rows.append(f'<tr><th scope="row">{escape(name)}</th><td>{escape(state)}</td>'
                    f'<td colspan="{max(len(columns), 1)}">{escape(reason)}</td></tr>')  # fmt: skip
    return (
        f'<section><h2>Runs</h2><div class="wide"><table class="sortable"><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody>{_mean(sheets, columns)}</table></div></section>"
    )


def _sort(cell: Number) -> str:
    return (
        escape(cell.text) if cell.value is None and cell.text != "undefined" else "" if cell.value is None else repr(cell.value)
    )


def _parameters(sheet: ReportData) -> dict[str, Any]:
    return {} if sheet.scene is None else {"scene": sheet.scene.name, **sheet.scene.as_mapping()}


def _columns(sheets: Sequence[ReportData]) -> list[str]:
    """The parameters in which the runs differ, then their results and errors."""
    each = [_parameters(sheet) for sheet in sheets]
    names = dict.fromkeys(name for parameters in each for name in parameters)
    differing = [name for name in names if len({repr(parameters[name]) for parameters in each if name in parameters}) > 1]
    return [*differing[:MOST_PARAMETERS], *dict.fromkeys(n.name for sheet in sheets for n in _judged(sheet))]


def _judged(sheet: ReportData) -> list[Number]:
    residual = sheet.measures.get("energy_residual")
    share = 100 * residual["relative"] if residual else None
    known = Number("energy residual", share, "undefined" if share is None else f"{share:.2g} %")
    return [*sheet.view.results(sheet), known, Number("time", sheet.frame.time, f"{sheet.frame.time:.5g}")]


def _cells(sheet: ReportData, columns: Sequence[str]) -> list[Number]:
    known = {n.name: n for n in _judged(sheet)}
    for name, value in _parameters(sheet).items():
        if name not in known:
            number = float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
            known[name] = Number(name, number, _word(value))
    return [known.get(name, Number(name, None, "")) for name in columns]


def _word(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)


def with_error(mean: float, error: float) -> str:
    """Both to the second digit of the error, or as they are where that would take more than six decimals."""
    decimals = max(1 - math.floor(math.log10(error)), 0) if error > 0 else 7
    return f"{mean:.{decimals}f} ± {error:.{decimals}f}" if decimals <= 6 else f"{mean:.5g} ± {error:.1g}"


def _mean(sheets: Sequence[ReportData], columns: Sequence[str]) -> str:
    """Mean and standard error over runs that differ in the seed alone."""
    each = [{name: value for name, value in _parameters(sheet).items() if name != "seed"} for sheet in sheets]
    if len(sheets) < 2 or not each[0] or any(parameters != each[0] for parameters in each):
        return ""
    cells = []
    for column in zip(*(_cells(sheet, columns) for sheet in sheets), strict=True):
        values = [cell.value for cell in column if cell.value is not None]
        if column[0].name in ("seed", "time") or len(values) < 2:
            cells.append("<td></td>")
            continue
        error = statistics.stdev(values) / len(values) ** 0.5
        cells.append(f"<td>{with_error(statistics.fmean(values), error)}</td>")
    return f'<tfoot><tr><th scope="row">mean ± standard error</th><td>of {len(sheets)}</td>{"".join(cells)}</tr></tfoot>'

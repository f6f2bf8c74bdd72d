"""The data of a report page: the force network and the charts of one run as JSON, its arrays in single precision."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from workflow.data.frame import Floats, Frame
from workflow.reports.canvas import wrap
from workflow.reports.network import LOOK
from workflow.reports.views import KINDS, Sight, View
from workflow.scene.base import Units

MOST_ROWS = 4000  # of a time series on the page; longer ones are thinned
TYPES: dict[str, np.dtype] = {"f4": np.dtype("<f4"), "u4": np.dtype("<u4"), "u1": np.dtype("u1")}


@dataclass(frozen=True)
class ReportData(Sight):
    """What a page says of one run or dump.

    ``state``: finished, failed, ...; ``reason`` of a failure.  ``note``: which frame is shown.  ``units``: names of the units;
    ``view``: what is shown of its kind.  ``numbers``: all measures as (name, text).  ``provenance``: (name, text); ``text``:
    the scene file.  ``si``: (name, text) in SI.  ``film``: words and frames that the page plays, ``frame`` among them.
    """

    name: str
    title: str
    state: str
    reason: str | None
    note: str
    units: Units
    view: View
    series: Mapping[str, Floats]
    measures: Mapping[str, Any]
    numbers: Sequence[tuple[str, str]]
    provenance: Sequence[tuple[str, str]]
    text: str
    si: Sequence[tuple[str, str]] = ()
    film: Sequence[tuple[str, Frame]] = ()


def packed(values: Any, kind: str) -> dict[str, str]:
    """An array as base64 of little-endian numbers."""
    data = np.ascontiguousarray(values, dtype=TYPES[kind])
    return {"type": kind, "base64": base64.b64encode(data.tobytes()).decode("ascii")}


def unpacked(array: Mapping[str, str]) -> np.ndarray:
    """The array of `packed`."""
    return np.frombuffer(base64.b64decode(array["base64"]), dtype=TYPES[array["type"]])


def network(sheet: ReportData) -> dict[str, Any]:
    """Discs and interactions for network.js; forces in units of the scene, ``unit`` the force to divide by."""
    frame, table = sheet.frame, sheet.frame.interactions
    length, symbol, _ = sheet.units
    place = np.where(frame.periodic, wrap(frame, frame.position), frame.position)
    arrays = {
        "id": packed(frame.ids, "u4"), "mark": packed(sheet.view.mark(sheet), "u1"), "d": packed(frame.diameter, "f4"),
        "x": packed(place[:, 0], "f4"), "y": packed(place[:, 1], "f4"),
        "i": packed(table.i, "u4"), "j": packed(table.j, "u4"), "bx": packed(table.branch[:, 0], "f4"),
        "by": packed(table.branch[:, 1], "f4"), "normal": packed(table.normal_force, "f4"),
        "tangential": packed(table.tangential, "f4"), "moment": packed(table.moment, "f4"), "gap": packed(table.gap, "f4"),
        "kind": packed(kinds(sheet), "u1"), "flag": packed(table.sliding + 2 * table.rolling, "u1"),
    }  # fmt: skip
    return {
        "arrays": arrays, "cell": frame.cell.tolist(), "origin": frame.origin.tolist(), "periodic": list(frame.periodic),
        "window": _window(sheet), "unit": sheet.force_unit, "symbol": symbol, "length": length, "band": sheet.view.band(sheet),
        "kinds": KINDS, "dashes": [LOOK[name][1] for name in KINDS], "rolling": bool(table.moment.any()),
        "marks": ["", *(name for _, name in sheet.view.marks)],
    }  # fmt: skip


def shown_of(sheet: ReportData) -> int:
    """Place in the film of the frame that is shown."""
    return next(k for k, (_, frame) in enumerate(sheet.film) if frame.step == sheet.frame.step)


def film(sheet: ReportData) -> dict[str, Any]:
    """The frames for player.js; the one that is shown has its arrays in `network` already."""
    shown, found = shown_of(sheet), []
    for number, (label, frame) in enumerate(sheet.film):
        part = network(replace(sheet, frame=frame))
        kept = {"cell", "origin", "window"} | ({"arrays"} if number != shown else set())
        found.append({"label": label} | {name: value for name, value in part.items() if name in kept})
    return {"frames": found, "shown": shown}


def kinds(sheet: ReportData) -> np.ndarray:
    """Place in KINDS of each interaction, (M,)."""
    kind = np.full(len(sheet.frame.interactions), KINDS.index("no force"))
    for name, rows in sheet.view.kinds(sheet).items():
        kind[rows] = KINDS.index(name)
    return kind


def _window(sheet: ReportData) -> list[float]:
    """Left, bottom, right, top of what is shown at first: the cell, or the grains where nothing is periodic."""
    frame = sheet.frame
    low, high = frame.origin, frame.origin + frame.cell
    shown = sheet.view.shown(sheet)
    if not any(frame.periodic) and shown.any():
        low, high = frame.position[shown].min(axis=0) - 1.0, frame.position[shown].max(axis=0) + 1.0
    return [float(v) for v in (*low, *high)]


def charts(sheet: ReportData) -> tuple[list[dict[str, Any]], dict[str, dict[str, str]], int]:
    """Charts for chart.js, the arrays they name, and every how many rows of the time series there is one on the page."""
    found, columns, every = _of_time(sheet)
    arrays = {name: packed(values, "f4") for name, values in columns.items()}
    for number, (title, xlabel, log, lines) in enumerate(_of_measures(sheet)):
        drawn = []
        for k, (name, x, y) in enumerate(lines):
            arrays[f"x{number}.{k}"], arrays[f"y{number}.{k}"] = packed(x, "f4"), packed(y, "f4")
            drawn.append({"name": name, "x": f"x{number}.{k}", "y": f"y{number}.{k}"})
        found.append({"title": title, "xlabel": xlabel, "ylabel": "", "logy": log, "lines": drawn, "time": False})
    return found, arrays, every


def _of_time(sheet: ReportData) -> tuple[list[dict[str, Any]], dict[str, Floats], int]:
    series = sheet.series
    if not len(series.get("time", ())):
        return [], {}, 1
    every = -(-len(series["time"]) // MOST_ROWS)
    stage = np.asarray(series["stage"], dtype=np.int64)
    ends = np.append(np.flatnonzero(np.diff(stage)), len(stage) - 1)  # the last row of a stage is never left out
    rows = np.union1d(np.arange(0, len(stage), every), ends)
    begins = np.append(0, ends[:-1] + 1)
    names = getattr(sheet.scene, "stages", {})
    stages = [{"name": names.get(int(stage[k]), f"stage {stage[k]}"), "x": float(series["time"][k])} for k in begins]
    length, force, clock = sheet.units
    found, used = [], {"time": series["time"][rows]}
    levels = sheet.view.levels(sheet)
    for title, unit, columns, log in sheet.view.charts(sheet):
        there = [name for name in columns if name in series and (len(columns) == 1 or series[name].any())]
        if not there:
            continue
        used |= {name: sheet.view.column(sheet, name)[rows] for name in there}
        lines = [{"name": name.replace("_", " "), "x": "time", "y": name} for name in there]
        chart = {"title": title, "xlabel": f"time [{clock}]", "ylabel": unit.format(l=length, f=force), "logy": log}
        level = [dict(zip(("name", "y"), levels[title], strict=True))] if title in levels else []
        found.append(chart | {"lines": lines, "levels": level, "stages": stages, "time": True})
    return found, used, every


Lines = list[tuple[str, Any, Any]]


def _of_measures(sheet: ReportData) -> Iterable[tuple[str, str, bool, Lines]]:
    """(title, xlabel, logarithmic, lines) of distributions and profiles among the measures."""
    measures = sheet.measures
    forces = measures.get("forces", {})
    if "distribution" in forces:
        unit = {"F0": "F₀", "mean": "⟨Nₑ⟩"}[forces["distribution"]["unit"]]
        yield "distribution of the normal force", f"N [{unit}]", True, [_outline("density", *_bins(forces["distribution"]))]
    if "angles" in forces:
        yield "angle of force and normal", "degrees", False, [_outline("density", *_bins(forces["angles"]))]
    if "neighbour_shares" in measures:
        shares = measures["neighbour_shares"]
        line = _outline("share of the grains", np.arange(len(shares) + 1) - 0.5, shares)
        yield "neighbours of a grain", "number (the last: and more)", False, [line]
    if "base_force_profile" in measures:
        base, top = measures["base_force_profile"], measures["surface"]
        yield "surface", "x [σ]", False, [("height [σ]", top["x"], top["height"])]
        lines = [("each base disc [mg]", base["x"], base["force"]), ("smoothed over 2 σ", base["x"], base["smoothed"])]
        yield "force on the base", "x [σ]", False, lines


def _bins(found: Mapping[str, Any]) -> tuple[Any, Any]:
    return found["edges"], found["density"]


def _outline(name: str, edges: Any, heights: Any) -> tuple[str, Any, Any]:
    """A histogram as two points per bin, without empty bins at its ends."""
    edges, heights = np.asarray(edges, dtype=float), np.asarray(heights, dtype=float)
    full = np.flatnonzero(heights > 0)
    own = slice(full[0], full[-1] + 1) if len(full) else slice(0, 0)
    return name, np.repeat(edges, 2)[1:-1].reshape(-1, 2)[own].ravel(), np.repeat(heights[own], 2)

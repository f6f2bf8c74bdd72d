"""The history of a run: solid fraction, stresses and unbalanced forces against time, with the name of every stage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workflow.data.frame import Floats
from workflow.errors import InputError
from workflow.reports.figures import INK, LOOKS, Paths, save, sized, style, width
from workflow.reports.paper import NARROW, PAGE

WORDS = {
    "stress_x": r"$\sigma_{xx}$", "stress_y": r"$\sigma_{yy}$", "net_force": "net force",
    "net_moment": "net moment",
}  # fmt: skip
DECADES = 30.0  # ratio of imposed stresses from which on their axis is logarithmic
NAME = 6.5  # points of the letters of a stage
LIMIT: Any = {"color": INK, "linestyle": ":", "linewidth": 1.2}


def history(
    series: Mapping[str, Floats],
    path: Paths,
    *,
    density: str = "solid_fraction",
    stresses: Sequence[str] = ("stress_x", "stress_y"),
    unbalanced: Sequence[str] = ("net_force", "net_moment"),
    targets: Mapping[int, float | None] | None = None,
    tolerance: float = 1e-4,
    stages: Mapping[int, str] | None = None,
    force: str = "F_0",
) -> None:
    """Solid fraction, stresses and unbalanced force and moment (logarithmic) against time, in three panels.

    ``density``, ``stresses``, ``unbalanced``: columns of ``series``.  ``targets``: imposed stress [force/a] of each stage by
    its number in ``series["stage"]``, drawn while the stage lasts, None for a fixed length; where they span a factor of
    DECADES the axis of the stresses is logarithmic.  ``tolerance``: equilibrium level.  Vertical lines where the stage
    changes, with the names ``stages`` of all of them above.  ``force``: its unit in the labels.  Raises InputError for a
    column that does not exist, an empty series, a bad suffix.
    """
    needed = ("time", "stage", density, *stresses, *unbalanced)
    missing = [name for name in needed if name not in series]
    if missing or not len(series["time"]):
        problem = f"column '{missing[0]}' is missing" if missing else "there are no rows"
        raise InputError(f"history: {problem}; columns are {', '.join(series)}; choose from them or let the run go on")
    with style():
        figure = sized(0.85 if width(PAGE) >= NARROW else 1.6, PAGE)
        figure.set_layout_engine("constrained", hspace=0.09)
        top, middle, bottom = figure.subplots(3, 1, sharex=True)
        _curves(top, series, [density], "solid fraction $\\Phi$")
        _curves(middle, series, stresses, rf"stress $[{force}/a]$")
        _curves(bottom, series, unbalanced, rf"largest unbalanced $[{force},\ {force}\,a]$")
        _imposed(middle, series, targets or {})
        bottom.set_yscale("log", nonpositive="mask")
        bottom.axhline(tolerance, **LIMIT, label=f"tolerance {tolerance:g}")
        bottom.set_xlabel("time $[T_0]$")
        for axes in (middle, bottom):
            axes.legend(ncols=3, loc="lower right", bbox_to_anchor=(1, 0.97), borderpad=0, columnspacing=1.2,
                        handlelength=2.0).set_in_layout(False)  # fmt: skip
        _stages(figure, (top, middle, bottom), series, stages or {})
        save(figure, path)


def _curves(axes: Axes, series: Mapping[str, Floats], names: Sequence[str], label: str) -> None:
    """One line per column, told apart by colour and by dash."""
    for name, (colour, dash, _) in zip(names, LOOKS, strict=False):
        axes.plot(series["time"], series[name], color=colour, linestyle=dash, label=WORDS.get(name, name.replace("_", " ")))
    axes.set_ylabel(label)
    axes.margins(x=0.01)


def _spans(series: Mapping[str, Floats]) -> list[tuple[int, float, float]]:
    """Number, begin and end of each stage."""
    time, stage = series["time"], np.asarray(series["stage"], dtype=np.int64)
    first = np.append(0, np.flatnonzero(np.diff(stage)) + 1)
    ends = np.append(time[first[1:]], time[-1])
    return [(int(stage[k]), float(time[k]), float(end)) for k, end in zip(first, ends, strict=True)]


def _imposed(axes: Axes, series: Mapping[str, Floats], targets: Mapping[int, float | None]) -> None:
    """The imposed stress of each stage while it lasts."""
    spans = [(begin, end, target) for number, begin, end in _spans(series) if (target := targets.get(number)) is not None]
    if not spans:
        return
    time = [t for begin, end, _ in spans for t in (begin, end, np.nan)]
    values = sorted({target for *_, target in spans})
    only = f" {values[0]:g}" if len(values) == 1 else ""
    axes.plot(time, [t for *_, target in spans for t in (target, target, np.nan)], **LIMIT, label=f"imposed{only}")
    positive = [value for value in values if value > 0]
    if positive and positive[-1] > DECADES * positive[0]:
        axes.set_yscale("log", nonpositive="mask")
        axes.set_ylim(0.1 * positive[0], None)


def _stages(figure: Figure, panels: Sequence[Axes], series: Mapping[str, Floats], names: Mapping[int, str]) -> None:
    """Boundaries in all panels; above the first the name of every stage, upright, with a line to its middle."""
    spans = _spans(series)
    for _, begin, _ in spans[1:]:
        for axes in panels:
            axes.axvline(begin, color=INK, linestyle=(0, (1, 2)), linewidth=0.6)
    figure.draw_without_rendering()  # the place of the panels is known from here on
    low, high = panels[0].get_xlim()
    room = 72 / figure.dpi * panels[0].get_window_extent().width  # points
    middles = np.array([((begin + end) / 2 - low) / (high - low) for _, begin, end in spans])
    size = min(NAME, room / (1.25 * len(spans)))
    places = spread(middles, 1.25 * size / room)
    for (number, *_), middle, place in zip(spans, middles, places, strict=True):
        panels[0].annotate(
            names.get(number, f"stage {number}"), (middle, 1.0), (place, 1.09), xycoords="axes fraction",
            textcoords="axes fraction", rotation=90, ha="center", va="bottom", fontsize=size, annotation_clip=False,
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "color": INK, "shrinkA": 0, "shrinkB": 0, "relpos": (0.5, 0.0)},
        )  # fmt: skip


def spread(middles: Floats, apart: float) -> Floats:
    """Places of labels in their order, at least ``apart`` from each other inside 0 to 1, near their ``middles`` (n,)."""
    steps = apart * np.arange(len(middles))
    forward = np.maximum.accumulate(middles - steps)  # pushed to the right by those before
    backward = np.minimum.accumulate((middles - steps)[::-1])[::-1]  # pushed to the left by those behind
    return np.asarray(np.clip(0.5 * (forward + backward), 0.0, max(1.0 - steps[-1], 0.0)) + steps)

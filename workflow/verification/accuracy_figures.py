"""Figures of `wf accuracy`: convergence, work-precision, packings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from workflow.reports.figures import BLUE, GREEN, INK, ORANGE, RED, PathLike, save, style
from workflow.verification.accuracy import FewBodyError, PackingStatistics

# drawn one over the other, each smaller than the last, so that curves that coincide are all seen
LOOK = ((BLUE, "o", 7.0), (ORANGE, "D", 5.0), (RED, "s", 3.5), (GREEN, "^", 2.5), (INK, "v", 2.0))


def few_figure(
    rows: Sequence[FewBodyError], orders: Mapping[tuple[str, str], float], path: PathLike, *, wanted: float, against_time: bool
) -> None:
    """One panel per case: error against steps per stiffest period with the fitted order, or against run time.

    Dashed: the ``wanted`` error.
    """
    names = list(dict.fromkeys(row.case for row in rows))
    variants = list(dict.fromkeys(row.variant for row in rows))
    with style():
        figure = Figure(figsize=(13.0, 6.4), layout="constrained")
        panels = figure.subplots(2, (len(names) + 1) // 2, squeeze=False).ravel()
        for axes in panels[len(names) :]:
            axes.set_axis_off()
        for axes, name in zip(panels, names, strict=False):
            panel(axes, name, "run time per T0 [s]" if against_time else "steps per stiffest period", "error")
            for variant, (colour, mark, size) in zip(variants, LOOK, strict=False):
                of = [row for row in rows if (row.case, row.variant) == (name, variant)]
                order = orders.get((name, variant))
                label = variant if order is None or against_time else f"{variant}, order {order:.1f}"
                across = [row.seconds if against_time else row.steps_per_period for row in of]
                look = {"color": colour, "marker": mark, "markersize": size, "linewidth": size / 3.0}
                if of:
                    axes.plot(across, [row.error for row in of], label=label, **look)
            axes.axhline(wanted, color=INK, linestyle="--", linewidth=0.8)
            low, high = axes.get_ylim()
            axes.set_ylim(low * (low / high) ** 0.25, high)  # room for the legend
            axes.legend(frameon=False, fontsize=7, loc="lower left")
        save(figure, path)


def many_figure(rows: Sequence[PackingStatistics], path: PathLike) -> None:
    """Packings: solid fraction, coordination and stress with their standard errors, and energy residual, over run time."""
    names = list(dict.fromkeys(row.case for row in rows))
    variants = list(dict.fromkeys(row.variant for row in rows))
    with style():
        figure = Figure(figsize=(13.0, 6.0), layout="constrained")
        grid = figure.subplots(len(names), 4, squeeze=False)
        for line, name in zip(grid, names, strict=True):
            for variant, (colour, mark, size) in zip(variants, LOOK, strict=False):
                of = [row for row in rows if (row.case, row.variant) == (name, variant)]
                if of:
                    _bulk(
                        line,
                        of,
                        {"color": colour, "marker": mark, "markersize": size, "linewidth": size / 3.0, "label": variant},
                    )
            time = "run time per T0 [s]"
            panel(line[0], name, time, r"solid fraction $\Phi$", up_log=False)
            panel(line[1], name, time, "coordination $z$", up_log=False)
            panel(line[2], name, time, r"$|\sigma - P|$ [$F_1/a$]")
            panel(line[3], name, time, "energy residual")
            line[0].legend(frameon=False, fontsize=7)
        save(figure, path)


def _bulk(line: Sequence[Axes], of: Sequence[PackingStatistics], look: dict[str, Any]) -> None:
    seconds = [row.seconds for row in of]
    for axes, name in zip(line, ("solid_fraction", "coordination", "stress"), strict=False):
        bars = [getattr(row, f"{name}_error") for row in of]
        axes.errorbar(seconds, [getattr(row, name) for row in of], bars, capsize=2, **look)
    if of[0].residual is not None:
        line[3].plot(seconds, [row.residual or 0.0 for row in of], **look)


def panel(axes: Axes, title: str, across: str, up: str, *, up_log: bool = True) -> None:
    """Logarithmic axes with title, labels and grid."""
    axes.set(xscale="log", xlabel=across, ylabel=up)
    axes.set_title(title, fontsize=9)
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter("")
    axes.grid(True, color="#E3E3E3", linewidth=0.5)
    if up_log:
        axes.set_yscale("log")
        axes.yaxis.set_minor_formatter("")

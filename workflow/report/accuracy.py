"""Figures of `wf accuracy`: convergence, work-precision, packings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workflow.report.figures import BLUE, GREEN, INK, ORANGE, RED, STYLE, PathLike, save
from workflow.study.accuracy import Few, Many

LOOK = ((BLUE, "o"), (RED, "s"), (GREEN, "^"), (ORANGE, "D"), (INK, "v"))


def few_figure(
    rows: Sequence[Few], orders: Mapping[tuple[str, str], float], path: PathLike, *, wanted: float, against_time: bool
) -> None:
    """One panel per case: error against steps per stiffest period with the fitted order, or against run time.

    Dashed: the ``wanted`` error.
    """
    names = list(dict.fromkeys(row.case for row in rows))
    variants = list(dict.fromkeys(row.variant for row in rows))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(13.0, 6.4), layout="constrained")
        panels = figure.subplots(2, (len(names) + 1) // 2, squeeze=False).ravel()
        for axes in panels[len(names) :]:
            axes.set_axis_off()
        for axes, name in zip(panels, names, strict=False):
            for variant, (colour, mark) in zip(variants, LOOK, strict=False):
                of = [row for row in rows if (row.case, row.variant) == (name, variant)]
                if of:
                    order = orders.get((name, variant))
                    label = variant if order is None or against_time else f"{variant}, order {order:.1f}"
                    across = [row.seconds for row in of] if against_time else [row.steps_per_period for row in of]
                    axes.plot(across, [row.error for row in of], color=colour, marker=mark, markersize=4, label=label)
            _log(axes, name, "run time per T0 [s]" if against_time else "steps per stiffest period", "error")
            axes.axhline(wanted, color=INK, linestyle="--", linewidth=0.8)
            axes.legend(frameon=False, fontsize=7, loc="lower left")
        save(figure, path)


def many_figure(rows: Sequence[Many], path: PathLike) -> None:
    """Packings: solid fraction, coordination, energy residual and stress deviation over the step, with error bars."""
    names = list(dict.fromkeys(row.case for row in rows))
    variants = list(dict.fromkeys(row.variant for row in rows))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(13.0, 6.0), layout="constrained")
        grid = figure.subplots(len(names), 4, squeeze=False)
        for line, name in zip(grid, names, strict=True):
            for k, (variant, (colour, mark)) in enumerate(zip(variants, LOOK, strict=False)):
                of = [row for row in rows if (row.case, row.variant) == (name, variant)]
                if of:
                    _bulk(line, of, variant, colour, mark, 1.0 + 0.03 * k)
            line[0].set(xscale="log", xlabel="steps per stiffest period", ylabel=r"solid fraction $\Phi$", title=name)
            line[1].set(xscale="log", xlabel="steps per stiffest period", ylabel="coordination $z$")
            _log(line[2], "", "run time per T0 [s]", "energy residual")
            _log(line[3], "", "run time per T0 [s]", r"stress deviation $|\sigma/P - 1|$")
            for axes in line[:2]:
                axes.grid(True, color="#E3E3E3", linewidth=0.5)
            line[0].legend(frameon=False, fontsize=7)
        save(figure, path)


def _bulk(line: Sequence[Axes], of: Sequence[Many], variant: str, colour: str, mark: str, shift: float) -> None:
    look = {"color": colour, "marker": mark, "markersize": 4, "label": variant}
    steps, seconds = [shift * row.steps_per_period for row in of], [row.seconds for row in of]
    for axes, name in zip(line, ("solid_fraction", "coordination"), strict=False):
        bars = [getattr(row, f"{name}_error") for row in of]
        axes.errorbar(steps, [getattr(row, name) for row in of], bars, capsize=2, linewidth=0.9, **look)  # type: ignore[arg-type]
    if of[0].residual is not None:
        line[2].plot(seconds, [row.residual for row in of], **look)  # type: ignore[arg-type]
    line[3].plot(seconds, [row.stress for row in of], **look)  # type: ignore[arg-type]


def _log(axes: Axes, title: str, across: str, up: str) -> None:
    axes.set(xscale="log", yscale="log", xlabel=across, ylabel=up, title=title)
    axes.title.set_fontsize(9)
    axes.grid(True, color="#E3E3E3", linewidth=0.5)

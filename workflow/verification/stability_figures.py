"""The map of `wf stability`."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from workflow.reports.figures import PathLike, save, style
from workflow.verification.stability import INACCURATE, REFUSED, STABLE, UNSTABLE, Verdict

# colour and hatch, so that the map reads in grey too
LOOK = {
    STABLE: ("#BFE3D0", ""),
    INACCURATE: ("#F6D48A", "//"),
    UNSTABLE: ("#E2755F", "xx"),
    REFUSED: ("#D9D9D9", ".."),
}


def stability_map(rows: Sequence[Verdict], path: PathLike) -> None:
    """One line per parameter, one field per value, with the energy residual in percent below it; one map per scheme."""
    schemes = list(dict.fromkeys(row.scheme for row in rows))
    names = list(dict.fromkeys(row.parameter for row in rows))
    with style({"hatch.linewidth": 0.3}):
        figure = Figure(figsize=(9.5 * len(schemes), 0.36 * len(names) + 1.2), layout="constrained")
        panels = figure.subplots(1, len(schemes), squeeze=False)[0]
        for axes, scheme in zip(panels, schemes, strict=True):
            _map(axes, [row for row in rows if row.scheme == scheme], names)
            axes.set_title(scheme, fontsize=10)
        handles = [Patch(facecolor=c, hatch=h, edgecolor="#777777", label=name) for name, (c, h) in LOOK.items()]
        figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
        save(figure, path)


def _map(axes: Axes, rows: Sequence[Verdict], names: Sequence[str]) -> None:
    widest = 0
    for line, name in enumerate(names):
        for column, row in enumerate(row for row in rows if row.parameter == name):
            colour, hatch = LOOK[row.verdict]
            axes.add_patch(
                Rectangle((column, line), 1.0, 0.9, facecolor=colour, hatch=hatch, edgecolor="#999999", linewidth=0.4)
            )
            axes.text(column + 0.5, line + 0.3, f"{row.value:g}", ha="center", va="center", fontsize=8)
            if row.residual is not None:
                axes.text(column + 0.5, line + 0.68, f"{100 * row.residual:.2g} %", ha="center", va="center", fontsize=5.5)
            widest = max(widest, column + 1)
    axes.set(xlim=(0, widest), ylim=(len(names), 0), xticks=[], yticks=[k + 0.45 for k in range(len(names))], yticklabels=names)
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0)

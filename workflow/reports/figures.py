"""Pictures of a run: the force network of a frame (as in G07 fig. 2) and the history of its time series.

Drawn with matplotlib's object interface (no global state).  Files carry no date and are equal for equal input.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from workflow.data.balance import solid_fraction
from workflow.data.files import PathLike, atomic_write
from workflow.data.frame import Bools, Floats, Frame
from workflow.errors import InputError
from workflow.measures.packing import coordination
from workflow.measures.percolation import force_magnitude

# Metadata per format that would otherwise hold the date or the library version.
FORMATS = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
# The red, green and blue of G07 fig. 2, dark to light, so that colour-blind readers and grey prints tell them apart.
RED, GREEN, BLUE, ORANGE, INK = "#A80F14", "#4DB86F", "#2C7FB8", "#E69F00", "#333333"
FILL, RATTLER, OUTLINE = "#F7F7F7", "#C4C4C4", "#9A9A9A"
STYLE: Any = {"svg.hashsalt": "workflow", "font.size": 9, "axes.linewidth": 0.6, "lines.linewidth": 1.2}

LONG_SIDE = 7.0  # inches of the longer cell side on paper
BAND = 0.12  # width of the line of one force unit, in length units a
THINNEST = 0.35  # points; below, a line is not seen


def force_network(
    frame: Frame,
    path: PathLike | Sequence[PathLike],
    *,
    force_unit: float = 1.0,
    symbol: str = "F_0",
    tolerance: float = 1e-4,
    threshold: float | None = None,
    band: float = BAND,
) -> None:
    """Draw the discs and the normal forces of ``frame`` to ``path`` (one or several; .png, .svg or .pdf).

    Line width proportional to |N|, ``band`` wide for N = ``force_unit`` (F0, or a P without cohesion; ``symbol`` is its
    name in the legend); red compressive, green tensile, blue distant, thin dark for |N| < tolerance force_unit;
    rattlers grey.  With a ``threshold`` [force] as G07 figs. 11, 12, 19-22: blue where the total force is below it, and
    grey the grains that have only such contacts.  The cell is drawn with the periodic images that reach into it.  Raises
    InputError (suffix, force_unit).
    """
    if not force_unit > 0:
        raise InputError(f"force_unit is {force_unit}; it must be positive: give F0, or P a without cohesion")
    with mpl.rc_context(STYLE):
        figure, axes, points = sheet(frame)
        network = coordination(frame, threshold=tolerance * force_unit)
        kinds, grey = kinds_of_fig2(frame, force_unit, tolerance), network.rattlers
        if threshold is not None:
            kinds, grey = kinds_of_fig11(frame, threshold), np.ones(frame.grains, dtype=bool)
            for rows, _ in list(kinds.values())[1:]:
                grey[frame.interactions.i[rows]] = grey[frame.interactions.j[rows]] = False
        discs(axes, frame, np.where(grey, RATTLER, FILL).tolist(), points)
        size = np.abs(frame.interactions.normal_force) / force_unit
        seen = bonds(axes, frame, kinds, np.maximum(size * band * points, THINNEST * (1 + (threshold is not None))))
        axes.set_title(
            rf"$\Phi$ = {solid_fraction(frame):.4f}   $z$ = {network.z:.3f}   $N$ = {frame.grains}   "
            rf"$t$ = {frame.time:.6g}",
            fontsize=10,
        )
        name = "rattler" if threshold is None else "unstressed grain"
        below(axes, _legend(seen, symbol, band * points, name if grey.any() else None))
        save(figure, path)


def below(axes: Axes, handles: Sequence[Line2D]) -> None:
    """Legend under the cell, in one row or, where the sheet is too narrow for that, in two."""
    for columns in (len(handles), (len(handles) + 1) // 2):
        legend = axes.legend(
            handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.01), ncols=max(columns, 1), frameon=False,
            handlelength=2.2, columnspacing=1.4, fontsize=8, borderaxespad=0.2,
        )  # fmt: skip
        if legend.get_window_extent().width <= axes.figure.bbox.width:
            return


def sheet(frame: Frame, bottom: float = 0.5) -> tuple[Figure, Axes, float]:
    """Figure with the cell as axes over ``bottom`` inches, and the points on paper per unit of length."""
    inch = LONG_SIDE / float(frame.cell.max())
    width, height = frame.cell * inch
    margin, top = 0.15, 0.35
    # The title and the legend need some width even above a narrow cell.
    total = (max(width, 5.6) + 2 * margin, height + top + bottom)
    figure = Figure(figsize=total)
    axes = figure.add_axes(((1 - width / total[0]) / 2, bottom / total[1], width / total[0], height / total[1]))
    axes.set(xlim=frame.origin[0] + np.array([0, frame.cell[0]]), ylim=frame.origin[1] + np.array([0, frame.cell[1]]),
             xticks=[], yticks=[])  # fmt: skip
    return figure, axes, 72 * inch


def wrap(frame: Frame, position: Floats) -> Floats:
    return frame.origin + np.mod(position - frame.origin, frame.cell)


def discs(axes: Axes, frame: Frame, fill: Sequence[Any], points: float) -> None:
    """All discs in the colours ``fill`` (N,), and the images of those that reach over an edge; axes clip the rest."""
    centre, radius, colours = wrap(frame, frame.position), frame.diameter[:, None] / 2, np.asarray(fill)
    for image in product((-1, 0, 1), repeat=2):
        moved = centre + image * frame.cell
        lower, upper = frame.origin, frame.origin + frame.cell
        seen = ((moved + radius > lower) & (moved - radius < upper)).all(axis=1)
        size = frame.diameter[seen]
        axes.add_collection(
            EllipseCollection(
                size, size, np.zeros_like(size), units="xy", offsets=moved[seen], offset_transform=axes.transData,
                facecolors=colours[seen].tolist(), edgecolors=OUTLINE,
                linewidths=float(np.clip(0.03 * points, 0.15, 0.6)), zorder=1,
            )
        )  # fmt: skip


Kinds = Mapping[str, tuple[Bools, str]]  # name -> (interactions of this kind, colour), drawn in this order


def kinds_of_fig2(frame: Frame, unit: float, tolerance: float) -> Kinds:
    """G07 fig. 2: by sign of N, distant pairs apart."""
    table = frame.interactions
    idle = table.in_contact & (np.abs(table.normal_force) < tolerance * unit)
    return {
        "no force": (idle, INK),
        "distant": (~table.in_contact, BLUE),
        "tensile": (table.in_contact & ~idle & (table.normal_force < 0), GREEN),
        "compressive": (table.in_contact & ~idle & (table.normal_force > 0), RED),
    }


def kinds_of_fig11(frame: Frame, threshold: float) -> Kinds:
    """G07 figs. 11, 12, 19-22: blue where the total force is below ``threshold``, the others by sign of N."""
    idle, normal = force_magnitude(frame) < threshold, frame.interactions.normal_force
    return {
        "unstressed": (idle, BLUE),
        "tensile": (~idle & (normal < 0), GREEN),
        "compressive": (~idle & (normal >= 0), RED),
    }


def bonds(axes: Axes, frame: Frame, kinds: Kinds, widths: Floats) -> list[str]:
    """Lines of ``widths`` (M,) points between centres; returns the kinds that occur."""
    table = frame.interactions
    start = wrap(frame, frame.position[table.i])
    crossing = np.floor((start + table.branch - frame.origin) / frame.cell)
    for order, (chosen, colour) in enumerate(kinds.values()):
        for along in product((0, 1), repeat=2):
            rows = chosen & ((crossing != 0) | (np.array(along) == 0)).all(axis=1)
            ends = (start - crossing * along * frame.cell)[rows]
            lines = np.stack((ends, ends + table.branch[rows]), axis=1)
            axes.add_collection(
                LineCollection(list(lines), linewidths=widths[rows], colors=colour, capstyle="round", zorder=2 + order)
            )
    return [name for name, (chosen, _) in kinds.items() if chosen.any()]


def _legend(kinds: Sequence[str], symbol: str, width: float, grey: str | None) -> list[Line2D]:
    def line(colour: str, thickness: float, label: str) -> Line2D:
        return Line2D([], [], color=colour, linewidth=thickness, label=label, solid_capstyle="butt")

    look = {
        "compressive": (RED, width, f"compressive, $N = {symbol}$"),
        "tensile": (GREEN, width, f"tensile, $N = -{symbol}$"),
        "distant": (BLUE, width, f"distant pair, $N = -{symbol}$"),
        "no force": (INK, THINNEST, "contact without force"),
        "unstressed": (BLUE, 2 * THINNEST, "contact without stress"),
    }
    handles = [line(*look[kind]) for kind in look if kind in kinds]
    if grey:
        handles.append(Line2D([], [], linestyle="", marker="o", markersize=7, markerfacecolor=RATTLER,
                              markeredgecolor=OUTLINE, markeredgewidth=0.5, label=grey))  # fmt: skip
    return handles


def history(
    series: Mapping[str, Floats],
    path: PathLike | Sequence[PathLike],
    *,
    density: str = "phi",
    stresses: Sequence[str] = ("sxx", "syy"),
    unbalanced: Sequence[str] = ("fmax", "mmax"),
    targets: Sequence[float | None] = (),
    tolerance: float = 1e-4,
    stages: Mapping[int, str] | None = None,
    force: str = "F_0",
) -> None:
    """Solid fraction, stresses and unbalanced force and moment (log scale) against time, in three panels.

    ``density``, ``stresses``, ``unbalanced``: columns of ``series``.  ``targets``: imposed stresses (dashed), None for
    a fixed length.  ``tolerance``: equilibrium level (dashed).  Dotted verticals where ``series["stage"]`` changes,
    labelled with ``stages``.  ``force``: its unit in the labels.  Raises InputError for a column that does not exist, an
    empty series, a bad suffix.
    """
    needed = ("time", "stage", density, *stresses, *unbalanced)
    missing = [name for name in needed if name not in series]
    if missing or not len(series["time"]):
        problem = f"column '{missing[0]}' is missing" if missing else "there are no rows"
        raise InputError(f"history: {problem}; columns are {', '.join(series)}; choose from them or let the run go on")
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.5, 6.2), layout="constrained")
        top, middle, bottom = figure.subplots(3, 1, sharex=True)
        _curves(top, series, [density], r"solid fraction $\Phi$")
        _curves(middle, series, stresses, rf"stress $[{force}/a]$")
        _curves(bottom, series, unbalanced, rf"unbalanced $[{force},\ {force}\,a]$")
        for target in sorted({target for target in targets if target is not None}):
            middle.axhline(target, color=INK, linestyle="--", linewidth=0.8, label=f"target {target:g}")
        bottom.set_yscale("log", nonpositive="mask")
        bottom.axhline(tolerance, color=INK, linestyle="--", linewidth=0.8, label=f"tolerance {tolerance:g}")
        bottom.set_xlabel("time $[T_0]$")
        for axes in (middle, bottom):
            axes.legend(frameon=False, ncols=4, fontsize=8, loc="lower right", bbox_to_anchor=(1, 0.97), borderpad=0)
        _stages(top, (middle, bottom), series, stages or {})
        save(figure, path)


def _curves(axes: Axes, series: Mapping[str, Floats], names: Sequence[str], label: str) -> None:
    """One line per column, told apart by colour and by dash."""
    for name, colour, dash in zip(names, (BLUE, RED, GREEN, ORANGE), ("-", (0, (5, 1)), "-.", ":"), strict=False):
        axes.plot(series["time"], series[name], color=colour, linestyle=dash, label=name)
    axes.set_ylabel(label)
    axes.margins(x=0.01)
    axes.spines[["top", "right"]].set_visible(False)


def _stages(top: Axes, others: Sequence[Axes], series: Mapping[str, Floats], names: Mapping[int, str]) -> None:
    """Boundaries in all panels; above the first the name of each stage that lasts long enough to hold it."""
    time, stage = series["time"], np.asarray(series["stage"], dtype=np.int64)
    changes = np.flatnonzero(np.diff(stage)) + 1
    for row in changes:
        for axes in (top, *others):
            axes.axvline(time[row], color=INK, linestyle=":", linewidth=0.8)
    edges = [0, *changes, len(time) - 1]
    for first, last in pairwise(edges):
        if time[last] - time[first] < 0.08 * (time[-1] - time[0]):
            continue
        name = names.get(int(stage[first]), f"stage {stage[first]}")
        top.text((time[first] + time[last]) / 2, 1.02, name, transform=top.get_xaxis_transform(), ha="center",
                 va="bottom", fontsize=8)  # fmt: skip


def save(figure: Figure, path: PathLike | Sequence[PathLike]) -> None:
    """Write ``figure`` to one or several files, format by suffix; each appears complete or not at all."""
    targets = [Path(p) for p in ([path] if isinstance(path, str | os.PathLike) else path)]
    for target in targets:
        if target.suffix.lower() not in FORMATS:
            raise InputError(f"figure '{target}': suffix '{target.suffix}' is not known; use {', '.join(FORMATS)}")
    with mpl.rc_context(STYLE):
        for target in targets:
            suffix = target.suffix.lower()
            with atomic_write(target) as draft:
                figure.savefig(draft, format=suffix[1:], dpi=200, metadata=FORMATS[suffix])

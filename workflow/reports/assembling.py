"""Pictures of how a packing came about: density against time (as in G07 fig. 4), the closing of pores (figs. 5, 7),
coordination against the first agitation (fig. 8)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.patches import Rectangle

from workflow.data.balance import solid_fraction
from workflow.data.frame import Floats, Frame
from workflow.errors import InputError
from workflow.reports.figures import BLUE, INK, LOOKS, MM, RED, Paths, panel, save, sized, style, width
from workflow.reports.paper import NARROW, PAGE
from workflow.scene.method2 import Method2

DISC, EDGE = "#5B6B7A", "#FFFFFF"


def density_history(runs: Mapping[str, Mapping[str, Floats]], path: Paths, *, stages: Mapping[str, Mapping[int, str]]) -> None:
    """Solid fraction against time on a logarithmic axis, one curve per run; a dot where a stage ends, with its name.

    ``runs``: label -> time series with ``time``, ``stage`` and ``solid_fraction``; ``stages``: label -> names of stages by
    number.  The row at t = 0 is left out.  Raises InputError without any row.
    """
    if not runs or not all((series["time"] > 0).any() for series in runs.values()):
        raise InputError("density against time: a run has no row beyond t = 0; let it go on")
    with style():
        figure, axes = panel(0.62, PAGE)
        for number, (label, series) in enumerate(runs.items()):
            colour, dash, mark = LOOKS[number % len(LOOKS)]
            shown = series["time"] > 0
            time, density = series["time"][shown], series["solid_fraction"][shown]
            axes.plot(time, density, color=colour, linestyle=dash, label=label)
            _ends(axes, time, density, series["stage"][shown], stages.get(label, {}), (colour, mark), number)
        axes.set(xscale="log", xlabel="time $t/T_0$", ylabel=r"solid fraction $\Phi$")
        axes.margins(y=0.12)
        if len(runs) > 1:
            figure.legend(loc="outside lower center", ncols=min(len(runs), 4 if width(PAGE) >= NARROW else 2))
        save(figure, path)


def _ends(
    axes: Axes, time: Floats, density: Floats, stage: Floats, names: Mapping[int, str], look: tuple[str, str], number: int
) -> None:
    """A mark where each stage ends; its name, with those that end too close to it to have a place of their own.

    The names of every other run stand below the curve, those of each second pair of runs farther away."""
    colour, mark = look
    side, away = (1, "bottom") if number % 2 == 0 else (-1, "top"), 5 + 9 * (number // 2)
    rows = np.append(np.flatnonzero(np.diff(stage)), len(stage) - 1)
    axes.plot(time[rows], density[rows], mark, markersize=4, color=colour, linestyle="none")
    apart, high = np.log10(time[-1] / time[0]) / 25, max(float(np.ptp(density)), 1e-3) / 12
    groups: list[list[int]] = []
    for row in rows:
        last = groups[-1][-1] if groups else None
        if last is not None and np.log10(time[row] / time[last]) < apart and abs(density[row] - density[last]) < high:
            groups[-1].append(row)
        else:
            groups.append([row])
    for group in groups:
        words = ", ".join(names.get(int(stage[row]), f"stage {stage[row]:.0f}") for row in group)
        axes.annotate(words, (time[group[-1]], density[group[-1]]), textcoords="offset points", xytext=(-3, side[0] * away),
                      ha="right", va=side[1],
                      fontsize=6.5, color=colour)  # fmt: skip


def agitation(found: Mapping[float, Sequence[float]], path: Paths) -> None:
    """Mean and standard error of z over the samples of each V0/V*, on a logarithmic axis; a line at the speed of the
    paper's series, 9.48 (G07 fig. 8).  Raises InputError without a sample that moved."""
    speeds = sorted(speed for speed in found if speed > 0)
    if not speeds:
        raise InputError("agitation: no run with V0 > 0 was given; choose one or more")
    samples = [np.array(found[speed]) for speed in speeds]
    error = [z.std(ddof=1) / np.sqrt(len(z)) if len(z) > 1 else 0.0 for z in samples]
    with style():
        figure, axes = panel()
        axes.errorbar(speeds, [z.mean() for z in samples], error, fmt="o-", color=INK, markersize=4, linewidth=0.8, ecolor=BLUE,
                      capsize=2)  # fmt: skip
        usual = Method2.v0
        if usual in found:
            axes.axvline(
                usual, color=RED, linestyle=(0, (4, 2)), zorder=0, label=f"$V_0/V^*$ = {usual:g}, as in the series of G07"
            )
            figure.legend(loc="outside upper center")
        axes.set(xscale="log", xlabel="initial speed $V_0/V^*$", ylabel="coordination number $z$",
                 xlim=(speeds[0] / 2, speeds[-1] * 2))  # fmt: skip
        axes.margins(y=0.2)
        save(figure, path)


def consolidation(runs: Mapping[str, tuple[Floats, Floats, Floats]], path: Paths) -> None:
    """Solid fraction and coordination number against P* on a logarithmic axis; open marks where the stress falls.

    ``runs``: label -> (P*, Phi, z), float64 (n,), in the order in which the stresses were put on.  Raises InputError
    without a run.
    """
    if not runs:
        raise InputError("consolidation: no run was given; choose one or more")
    with style():
        beside = width(PAGE) >= NARROW
        figure = sized(0.5 if beside else 1.6, PAGE)
        names = (r"solid fraction $\Phi$", "coordination number $z$")
        for column, (axes, name) in enumerate(zip(figure.subplots(*((1, 2) if beside else (2, 1))), names, strict=True)):
            for number, (label, curve) in enumerate(runs.items()):
                colour, dash, mark = LOOKS[number % len(LOOKS)]
                stress, value = curve[0], curve[1 + column]
                top = int(np.argmax(stress))
                first, label = column == 0, f"{label}: " if len(runs) > 1 else ""
                axes.plot(stress[: top + 1], value[: top + 1], mark, linestyle=dash, markersize=4, color=colour,
                          label=f"{label}stress grows" if first else None)  # fmt: skip
                if top + 1 < len(stress):
                    axes.plot(stress[top:], value[top:], mark, linestyle=dash, markersize=4, color=colour, linewidth=0.6,
                              markerfacecolor="white", label=f"{label}stress falls" if first else None)  # fmt: skip
            axes.set(xscale="log", xlabel="imposed stress $P^*$", ylabel=name)
        figure.legend(loc="outside lower center", ncols=2)
        save(figure, path)


def snapshots(frames: Sequence[Frame], path: Paths, *, names: Sequence[str]) -> None:
    """Frames side by side at one scale, each with its cell, so that the shrinking of cell and pores is seen.

    ``names``: a word for each image, written above it with Phi and time.  Raises InputError without a frame.
    """
    if not frames:
        raise InputError("snapshots: no frame was given; choose one or more")
    with style():
        columns = min(len(frames), 4 if width(PAGE) >= NARROW else 2)
        rows = -(-len(frames) // columns)
        extent = np.max([frame.cell for frame in frames], axis=0)
        side = width(PAGE) / columns  # mm
        figure = sized(rows * (side * extent[1] / extent[0] + 9.0) / width(PAGE), PAGE)
        grid = list(figure.subplots(rows, columns, squeeze=False).flat)
        for axes, frame, name in zip(grid, frames, names, strict=False):
            _image(axes, frame, extent, 72 * MM * side / extent[0])
            axes.set_title(f"{name}\n$\\Phi$ = {solid_fraction(frame):.3f}, $t$ = {frame.time:.4g} $T_0$", fontsize=7)
        for axes in grid:
            axes.set_axis_off()
        save(figure, path)


def _image(axes: Axes, frame: Frame, extent: Floats, points: float) -> None:
    """Filled discs with the images that reach over an edge, in the middle of a window of size ``extent``."""
    centre = frame.origin + np.mod(frame.position - frame.origin, frame.cell)
    middle = frame.origin + frame.cell / 2
    for image in product((-1, 0, 1), repeat=2):
        moved = centre + np.array(image) * frame.cell
        away = np.abs(moved - middle) - frame.cell / 2
        seen = (away < frame.diameter[:, None] / 2).all(axis=1)
        size = frame.diameter[seen]
        axes.add_collection(
            EllipseCollection(
                size, size, np.zeros_like(size), units="xy", offsets=moved[seen], offset_transform=axes.transData,
                facecolors=DISC, edgecolors=EDGE, linewidths=min(0.02 * points, 0.4),
            )
        )  # fmt: skip
    corner, (width, height) = frame.origin, frame.cell
    axes.add_patch(Rectangle(tuple(corner), width, height, fill=False, edgecolor=INK, linewidth=0.6))
    half = 0.51 * extent
    axes.set(xlim=(middle[0] - half[0], middle[0] + half[0]), ylim=(middle[1] - half[1], middle[1] + half[1]), aspect="equal",
             xticks=[], yticks=[])  # fmt: skip


def closing(frames: Sequence[Frame], count: int = 4) -> list[int]:
    """Indices of up to ``count`` frames from the last of the loosest stage on, spread evenly over solid fraction."""
    density = np.array([solid_fraction(frame) for frame in frames])
    under = [k for k, frame in enumerate(frames) if frame.stage.startswith(("load", "settle"))]
    first = max(under[0] - 1, 0) if under else 0
    wanted = np.linspace(density[first], density[-1], count)
    chosen = {first, len(frames) - 1, *(first + int(np.argmin(np.abs(density[first:] - value))) for value in wanted)}
    return [*sorted(chosen)[:-1][: count - 1], len(frames) - 1]

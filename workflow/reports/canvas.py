"""A cell with its discs drawn to scale, between a title and a legend with a bar of length and a line of force to scale."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text

from workflow.data.frame import Bools, Floats, Frame
from workflow.reports.figures import INK, MM, OUTLINE, width
from workflow.reports.paper import PAGE

MARGIN, GAP = 3.0, 4.0  # points round the picture; between its parts
HIGHEST = 1.35  # of a cell, in widths of the figure; a higher one is drawn narrower
WIDEST = 5.0  # points of the line of force in the legend
THINNEST = 0.35  # points; below, a line is not seen
SWATCH = 24.0  # points of the lines in the legend
SOLID, DASHED, DOTTED = (1.0, 0.0), (0.16, 0.09), (0.045, 0.045)  # on and off, in the usual length of a line


class Bar(NamedTuple):
    """A line to scale in the legend: ``length`` and ``width`` in points, its words, whether its ends are marked."""

    length: float
    width: float
    words: str
    ends: bool = False


class Kind(NamedTuple):
    """Interactions drawn alike: which, (M,) bool; colour; marks and gaps along the line in its usual length."""

    rows: Bools
    colour: str
    dash: tuple[float, float] = SOLID


@dataclass(frozen=True)
class Canvas:
    """``points`` on paper per unit of length; ``lower`` and ``upper``: corners (2,) of what is seen."""

    figure: Figure
    axes: Axes
    points: float
    lower: Floats
    upper: Floats


def canvas_of(frame: Frame, window: tuple[Floats, Floats] | None = None) -> Canvas:
    """An empty canvas for the cell of ``frame``, or for what lies between the corners ``window``; `finish` sets its height."""
    lower, upper = (frame.origin, frame.origin + frame.cell) if window is None else window
    extent = upper - lower
    room = 72 * MM * width(PAGE) - 2 * MARGIN
    points = room * min(1.0, HIGHEST * extent[0] / extent[1]) / extent[0]
    figure = Figure(figsize=(72 * MM * width(PAGE) / 72, 1.0))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), xticks=[], yticks=[])
    axes.spines[:].set_visible(True)
    return Canvas(figure, axes, float(points), lower, upper)


def finish(canvas: Canvas, title: str, handles: Sequence[Line2D], bars: Sequence[Bar] = (), below: float = 0.0) -> Text:
    """Set ``title``, which is returned, above the cell; below it ``below`` points of room, the legend of ``handles`` in as few
    rows as fit, and ``bars``."""
    figure = canvas.figure
    wide, dots = 72 * figure.get_figwidth(), 72 / figure.dpi
    inside = canvas.points * (canvas.upper - canvas.lower)
    head = figure.text(0.5, 0, title, ha="center", va="bottom", fontsize=8)
    if (size := head.get_window_extent().width * dots) > wide - 2 * MARGIN:
        head.set_fontsize(8 * (wide - 2 * MARGIN) / size)
    top = head.get_window_extent().height * dots + GAP
    legend = _legend(figure, handles, wide) if handles else None
    rows = legend.get_window_extent().height * dots + GAP if legend else 0.0
    strip = 12.0 + GAP if bars else 0.0
    high = 2 * MARGIN + top + inside[1] + below + rows + strip
    figure.set_figheight(high / 72)
    foot = MARGIN + strip + rows + below
    canvas.axes.set_position(((wide - inside[0]) / 2 / wide, foot / high, inside[0] / wide, inside[1] / high))
    head.set_y((foot + inside[1] + GAP) / high)
    if legend:
        legend.set_bbox_to_anchor((0.5, (MARGIN + strip) / high), transform=figure.transFigure)
    if bars:
        _bars(figure, bars, wide, high)
    return head


def _legend(figure: Figure, handles: Sequence[Line2D], wide: float) -> Any:
    """Legend at the foot of the figure, in as few rows as fit."""
    for columns in range(len(handles), 0, -1):
        legend = figure.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 0), ncols=columns,
                               handlelength=SWATCH / 7, columnspacing=1.4, borderaxespad=0.0, borderpad=0.1)  # fmt: skip
        if legend.get_window_extent().width * 72 / figure.dpi <= wide - MARGIN or columns == 1:
            return legend
        legend.remove()
    return None


def _bars(figure: Figure, bars: Sequence[Bar], wide: float, high: float) -> None:
    """Lines to scale in a row at the foot, each with its words: axes whose unit is the point."""
    axes = figure.add_axes((0, MARGIN / high, 1, 12.0 / high), xlim=(0, wide), ylim=(0, 12.0))
    axes.set_axis_off()
    axes.set_label("scales")
    words: list[Text] = [axes.text(0, 6.0, text, va="center", fontsize=7, color=INK) for _, _, text, _ in bars]
    sizes = [word.get_window_extent().width * 72 / figure.dpi for word in words]
    x = (wide - sum(length + 5 + size for (length, *_), size in zip(bars, sizes, strict=True)) - 18 * (len(bars) - 1)) / 2
    for (length, thick, _, ends), word, size in zip(bars, words, sizes, strict=True):
        axes.plot([x, x + length], [6.0, 6.0], color=INK, linewidth=thick, solid_capstyle="butt", marker="|" if ends else "",
                  markersize=5)  # fmt: skip
        word.set_x(x + length + 5)
        x += length + 5 + size + 18


def rounded(value: float) -> float:
    """The largest of 1, 2, 5, 10, 20, ... that is not above ``value``."""
    ten = 10.0 ** math.floor(math.log10(value))
    return max(m * ten for m in (1, 2, 5) if m * ten <= value * (1 + 1e-12))


def length_bar(canvas: Canvas, symbol: str = "a") -> Bar:
    """A bar of a round length, about a sixth of the figure."""
    length = rounded(72 * canvas.figure.get_figwidth() / 6 / canvas.points)
    return Bar(length * canvas.points, 1.0, rf"${length:g}\,{symbol}$", ends=True)


def force_bar(band: float, symbol: str, largest: float) -> Bar:
    """A line as wide as that of a round force [units], which is ``band`` points wide for one unit; not above ``largest``."""
    force = rounded(min(WIDEST / band, largest))
    return Bar(SWATCH, force * band, rf"$|N| = {force:g}\,{symbol}$")


def in_math(unit: str) -> str:
    """The name of a unit as matplotlib's formulas write it."""
    return unit.translate({ord("₀"): "_0", ord("₁"): "_1", ord("σ"): r"\sigma", ord("√"): r"\surd "})


def wrap(frame: Frame, position: Floats) -> Floats:
    """Positions inside the cell."""
    return frame.origin + np.mod(position - frame.origin, frame.cell)


def _images(frame: Frame) -> list[tuple[int, ...]]:
    """Shifts of the cell to its neighbours in the directions in which it is periodic."""
    return list(product(*((-1, 0, 1) if periodic else (0,) for periodic in frame.periodic)))


def discs(canvas: Canvas, frame: Frame, fill: Sequence[Any]) -> None:
    """All discs in the colours ``fill`` (N,), and the images of those that reach over an edge; axes clip the rest."""
    centre = np.where(frame.periodic, wrap(frame, frame.position), frame.position)
    radius, colours = frame.diameter[:, None] / 2, np.asarray(fill)
    lower, upper = frame.origin, frame.origin + frame.cell
    for image in _images(frame):
        moved = centre + np.array(image) * frame.cell
        inside = ((moved + radius > lower) & (moved - radius < upper)) | ~np.array(frame.periodic)
        seen = inside.all(axis=1)
        size = frame.diameter[seen]
        canvas.axes.add_collection(
            EllipseCollection(
                size, size, np.zeros_like(size), units="xy", offsets=moved[seen], offset_transform=canvas.axes.transData,
                facecolors=colours[seen].tolist(), edgecolors=OUTLINE,
                linewidths=float(np.clip(0.03 * canvas.points, 0.15, 0.6)), zorder=1,
            )
        )  # fmt: skip


def bonds(canvas: Canvas, frame: Frame, kinds: Mapping[str, Kind], widths: Floats) -> list[str]:
    """Lines of ``widths`` (M,) points between centres, those over an edge from both sides; returns the kinds that occur."""
    table, periodic = frame.interactions, np.array(frame.periodic)
    start = np.where(periodic, wrap(frame, frame.position), frame.position)[table.i]
    crossing = np.where(periodic, np.floor((start + table.branch - frame.origin) / frame.cell), 0.0)
    usual = float(np.median(table.distance)) * canvas.points if len(table) else 1.0
    for order, kind in enumerate(kinds.values()):
        for along in product((0, 1), repeat=2):
            rows = kind.rows & ((crossing != 0) | (np.array(along) == 0)).all(axis=1)
            ends = (start - crossing * along * frame.cell)[rows]
            lines = np.stack((ends, ends + table.branch[rows]), axis=1)
            canvas.axes.add_collection(
                LineCollection(
                    list(lines), linewidths=widths[rows], colors=kind.colour, zorder=2 + order,
                    linestyles=[stroke(kind, usual)], capstyle="round" if kind.dash == SOLID else "butt",
                )
            )  # fmt: skip
    return [name for name, kind in kinds.items() if kind.rows.any()]


def stroke(kind: Kind, usual: float) -> Any:
    """The dash of a kind for matplotlib, in points, where lines are ``usual`` points long."""
    on, off = kind.dash
    return (0, (on * usual, off * usual)) if off else "solid"


def swatch(kind: Kind, label: str, usual: float = SWATCH, wide: float = 1.8) -> Line2D:
    """The entry of a kind in the legend."""
    return Line2D([], [], color=kind.colour, linewidth=wide, linestyle=stroke(kind, usual), solid_capstyle="butt",
                  dash_capstyle="butt", label=label)  # fmt: skip


def disc_swatch(fill: str, label: str) -> Line2D:
    """The entry of discs of a colour in the legend."""
    return Line2D([], [], linestyle="", marker="o", markersize=6, markerfacecolor=fill, markeredgecolor=OUTLINE,
                  markeredgewidth=0.5, label=label)  # fmt: skip

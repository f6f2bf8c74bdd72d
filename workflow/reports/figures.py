"""How figures look and how they are written: style, colours, width on paper, files that are whole or absent.

Drawn with matplotlib's object interface (no global state), true to size: a figure is as wide as it is to be printed, so that
its letters have the size that STYLE says.  Files carry no date and are equal for equal input.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.style import context as clean

from workflow.data.files import PathLike, atomic_write
from workflow.errors import InputError
from workflow.reports.paper import COLUMN, DPI, PAPER

Paths = PathLike | Sequence[PathLike]

# Metadata per format that would otherwise hold the date or the library version.
FORMATS = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
# Told apart also by readers who confuse red and green, or blue and yellow, and in grey: see tests/unit/reports.
RED, GREEN, BLUE, ORANGE, INK = "#A80F14", "#4DB86F", "#2C7FB8", "#E69F00", "#333333"
FILL, RATTLER, OUTLINE, SHADE = "#F7F7F7", "#C4C4C4", "#9A9A9A", "#D9D9D9"
LOOKS = tuple(
    zip((BLUE, RED, GREEN, ORANGE, INK), ("-", (0, (5, 1)), "-.", ":", (0, (6, 1, 1, 1, 1, 1))), "os^Dv", strict=True)
)
STYLE: Any = {
    "svg.hashsalt": "workflow", "pdf.fonttype": 42, "font.size": 8, "axes.titlesize": 8, "axes.labelsize": 8,
    "xtick.labelsize": 7, "ytick.labelsize": 7, "legend.fontsize": 7, "legend.frameon": False, "legend.handlelength": 2.6,
    "axes.linewidth": 0.6, "lines.linewidth": 1.0, "lines.scale_dashes": False, "lines.dashed_pattern": (4, 2),
    "xtick.direction": "in", "ytick.direction": "in", "axes.spines.top": False, "axes.spines.right": False,
}  # fmt: skip

MM = 1 / 25.4


def style(more: Any = None) -> Any:
    """The context in which figures are drawn and saved: matplotlib's defaults with STYLE and ``more``, and nothing of the
    user's matplotlibrc."""
    return clean(["default", STYLE, *([more] if more else [])])


def width(meant: float = COLUMN) -> float:
    """Width of the figure [mm]: what was asked for, or what it is meant to have."""
    return PAPER.get().width or meant


def sized(ratio: float, meant: float = COLUMN) -> Figure:
    """An empty figure, ``ratio`` times as high as wide, whose panels make room for their labels."""
    wide = width(meant) * MM
    return Figure(figsize=(wide, ratio * wide), layout="constrained")


def panel(ratio: float = 0.78, meant: float = COLUMN) -> tuple[Figure, Axes]:
    """A figure with one pair of axes."""
    figure = sized(ratio, meant)
    return figure, figure.subplots()


def save(figure: Figure, path: Paths) -> None:
    """Write ``figure`` to one or several files, format by suffix; each appears complete or not at all."""
    targets = [Path(p) for p in ([path] if isinstance(path, str | os.PathLike) else path)]
    for target in targets:
        if target.suffix.lower() not in FORMATS:
            raise InputError(f"figure '{target}': suffix '{target.suffix}' is not known; use {', '.join(FORMATS)}")
    with style():
        for target in targets:
            suffix = target.suffix.lower()
            with atomic_write(target) as draft:
                figure.savefig(draft, format=suffix[1:], dpi=PAPER.get().dpi or DPI, metadata=FORMATS[suffix])

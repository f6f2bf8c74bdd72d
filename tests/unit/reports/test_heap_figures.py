"""The figure of a heap shows the fitted slopes, or says why there are none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from workflow.data.build import make_frame
from workflow.data.frame import Frame
from workflow.measures.heap import Ground, angle_of_repose, in_heap, surface
from workflow.reports import heap
from workflow.reports.paper import Paper, on


def pyramid(rows: int) -> tuple[Frame, Ground]:
    """A pyramid of 60 degrees on a row of touching discs, some grains of its right flank taken away."""
    rise = np.sqrt(0.75)
    places = np.concatenate([
        np.column_stack((np.arange(rows - k) + 0.5 * k, np.full(rows - k, rise * k)))[: rows - k - (k > 0) * (k // 6)]
        for k in range(rows)
    ])  # fmt: skip
    position = places - [0.5 * (rows - 1), 0.0] + 40.0
    frame = make_frame(position, 1.0 + 1e-6, (80.0, 80.0), periodic=(False, False))
    return frame, Ground(rows, 40.0, 40.0)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """The figures that would be saved."""
    caught: list[Figure] = []
    monkeypatch.setattr(heap, "save", lambda figure, path: caught.append(figure))
    return caught


@pytest.mark.parametrize("size", [None, 86.0])
def test_lines_on_the_flanks_have_the_angles_that_are_measured(size: float | None, drawn: Any) -> None:
    frame, ground = pyramid(24)
    own = in_heap(frame, ground)
    angle = angle_of_repose(surface(frame.position[own], frame.diameter[own], ground))
    with on(Paper(size)):
        heap.snapshot(frame, ground, [Path("x.png")])
    axes = drawn[0].axes[0]
    for side in ("left", "right"):
        line = next(line for line in axes.lines if str(line.get_label()).startswith(side))
        (x0, x1), (y0, y1) = line.get_xdata(), line.get_ydata()
        assert np.degrees(np.arctan(abs((y1 - y0) / (x1 - x0)))) == pytest.approx(angle[side])
        assert f"{angle[side]:.1f}" in line.get_label()
    drawn[0].draw_without_rendering()
    page, legend = drawn[0].bbox, drawn[0].legends[0].get_window_extent()
    title = axes.title.get_window_extent()
    for box in (legend, title):
        assert page.x0 <= box.x0 and box.x1 <= page.x1 and page.y0 <= box.y0 and box.y1 <= page.y1


def test_a_heap_without_flanks_says_so(drawn: Any) -> None:
    frame, ground = pyramid(4)
    heap.snapshot(frame, ground, [Path("x.png")])
    assert [text.get_text() for text in drawn[0].legends[0].get_texts()][-1].startswith("no slope: the heap is too low")

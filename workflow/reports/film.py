"""A film of a run: discs and normal forces of every frame, in one window and on one scale."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.animation import FFMpegWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from PIL import Image

from workflow.data.files import atomic_write
from workflow.data.frame import Floats, Frame
from workflow.errors import EnvironmentFault, InputError
from workflow.pipeline.sources import Source
from workflow.reports.canvas import (
    THINNEST,
    Bar,
    bonds,
    canvas_of,
    disc_swatch,
    discs,
    finish,
    force_bar,
    in_math,
    length_bar,
)
from workflow.reports.figures import FILL, INK, OUTLINE, RATTLER, style
from workflow.reports.network import LOOK, SIGNED, legend_of, look
from workflow.reports.paper import PAPER
from workflow.reports.views import VIEWS, PackingView, Sight, View
from workflow.scene.base import Units

FORMATS = (".mp4", ".gif")
SECONDS, RATES = 8.0, (2.0, 25.0)  # how long a film is to last, frames per second at least and at most
DPI = 150
FILLS = {"grey": RATTLER, "edge": OUTLINE}
WIDEST = 0.8  # of a line, in mean diameters
Said = Callable[[int, int], None]


def film(source: Source, path: Path | None = None, folder: Path | None = None, said: Said = lambda done, total: None) -> Path:
    """Film every frame of ``source`` into ``path`` (None: film.mp4 in ``folder``, that of the run if it is
    None; film.gif where ffmpeg is not installed).

    ``said`` is told how many frames of how many are drawn.  The file appears complete or not at all.  Raises InputError for
    a suffix that is none of FORMATS and for fewer than two frames, EnvironmentFault for .mp4 without ffmpeg.
    """
    path = path or (folder or source.folder) / f"film{FORMATS[0] if FFMpegWriter.isAvailable() else FORMATS[1]}"
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"--film {path}: suffix '{path.suffix}' is not known; use {' or '.join(FORMATS)}")
    if path.suffix.lower() == ".mp4" and not FFMpegWriter.isAvailable():
        raise EnvironmentFault(
            f"--film {path}: mp4 needs the program ffmpeg, which is not installed; install it, or end the name in .gif"
        )
    view, first = _view(source)
    with style():
        scene = _Scene(view, first, source.frames)
        rate = float(np.clip(scene.count / SECONDS, *RATES))
        with atomic_write(path) as draft:
            (_mp4 if path.suffix.lower() == ".mp4" else _gif)(scene.canvas.figure, scene.drawn(said), draft, rate)
    return path


def _view(source: Source) -> tuple[View, Sight]:
    """How the frames of ``source`` are shown, and the sight of one of them."""
    if source.run is None:
        frame, law = source.frame()
        frame.need("a film", "normal", "diameter")
        return PackingView(), Sight(frame, law.force_unit, law.tolerance, law.law.cohesive, law.length, None)
    scene = source.run.scene
    sight = Sight(source.one_frame(), scene.force_unit, scene.tolerance, scene.cohesive, 1.0, scene)
    return VIEWS.get(scene.kind, View)(), sight


class _Scene:
    """What all frames share: the window, the width of a force, the legend.  ``frames`` reads them one at a time, twice: what
    they share is known when the last was seen."""

    def __init__(self, view: View, sight: Sight, frames: Callable[[], Iterable[Frame]]) -> None:
        self.view, self.sight, self.frames = view, sight, frames
        self.count, corners, seen, largest = 0, (np.full(2, np.inf), np.full(2, -np.inf)), set[str](), 0.0
        for frame in frames():
            self.count += 1
            corners = np.minimum(corners[0], frame.origin), np.maximum(corners[1], frame.origin + frame.cell)
            last = replace(sight, frame=frame)
            seen |= {name for name, rows in view.kinds(last).items() if name in LOOK and rows.any()}
            largest = max(largest, float(np.abs(frame.interactions.normal_force).max(initial=0.0)) / sight.force_unit)
        if self.count < 2:
            raise InputError(f"a film needs two frames or more, there is {self.count}; run with a shorter --frame-interval")
        self.canvas = canvas_of(last.frame, corners if any(last.frame.periodic) else _heap_of(view, last))
        self.band = view.band(last) * self.canvas.points
        self.title = finish(self.canvas, "frame", *self._legend(seen, largest))

    def _legend(self, seen: set[str], largest: float) -> tuple[list[Line2D], list[Bar]]:
        """Entries of the kinds and marks that occur, and bars to scale."""
        scene, cohesive = self.sight.scene, self.sight.cohesive
        length, force, _ = Units("a", "F₀" if cohesive else "F₁", "T₀") if scene is None else scene.units
        handles = legend_of(look({name: np.ones(1, dtype=bool) for name in seen}))
        handles += [disc_swatch(FILLS[mark], name) for mark, name in self.view.marks]
        bars = [length_bar(self.canvas, in_math(length))]
        if seen & set(SIGNED) and largest > 0:
            bars.append(force_bar(self.band, in_math(force), largest))
        return handles, bars

    def drawn(self, said: Said) -> Iterator[None]:
        """Draw one frame after the other; each is there when the next is asked for."""
        for number, frame in enumerate(self.frames(), 1):
            self._draw(frame)
            yield
            said(number, self.count)

    def _draw(self, frame: Frame) -> None:
        canvas, sight = self.canvas, replace(self.sight, frame=frame)
        for artist in [*canvas.axes.collections, *canvas.axes.patches]:
            artist.remove()
        fills = [FILL, *(FILLS[look] for look, _ in self.view.marks)]
        discs(canvas, frame, [fills[mark] for mark in self.view.mark(sight).astype(int)])
        widths = np.abs(frame.interactions.normal_force) / sight.force_unit * self.band
        most = WIDEST * float(frame.diameter.mean()) * canvas.points
        rows = dict(self.view.kinds(sight))
        bonds(canvas, frame, look(rows), np.clip(widths, THINNEST, max(most, THINNEST)))
        if any(frame.periodic):
            self._centre(frame)
            cell = Rectangle(tuple(frame.origin), *frame.cell, fill=False, edgecolor=INK, linewidth=0.8, zorder=9)
            canvas.axes.add_patch(cell)
            for artist in canvas.axes.collections:
                artist.set_clip_path(cell)
        self.title.set_text(f"{frame.stage or 'frame'},  $t$ = {frame.time:.5g}")

    def _centre(self, frame: Frame) -> None:
        """Let the middle of a cell that shrinks stand still."""
        middle, half = frame.origin + frame.cell / 2, (self.canvas.upper - self.canvas.lower) / 2
        low, high = (middle - half).tolist(), (middle + half).tolist()
        self.canvas.axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))


def _heap_of(view: View, last: Sight) -> tuple[Floats, Floats]:
    """Corners of what is seen of a box with walls: the grains of the last frame that its view shows."""
    shown = view.shown(last)
    place = last.frame.position[shown] if shown.any() else last.frame.position
    return place.min(axis=0) - 1.0, place.max(axis=0) + 1.0


def _mp4(figure: Figure, frames: Iterator[None], draft: Path, rate: float) -> None:
    writer = FFMpegWriter(
        fps=rate,  # type: ignore[arg-type]  # ffmpeg takes fractions
        codec="h264",
        extra_args=["-pix_fmt", "yuv420p", "-f", "mp4"],
    )
    try:
        with writer.saving(figure, str(draft), PAPER.get().dpi or DPI):
            for _ in frames:
                writer.grab_frame()
    except (subprocess.CalledProcessError, BrokenPipeError) as fault:
        if isinstance(fault.__context__, KeyboardInterrupt):  # ffmpeg got the same signal
            raise fault.__context__ from None
        said = getattr(fault, "stderr", "").strip().splitlines()
        raise EnvironmentFault(
            f"ffmpeg stopped: {said[-1] if said else fault}; end the name in .gif to do without it"
        ) from None


def _gif(figure: Figure, frames: Iterator[None], draft: Path, rate: float) -> None:
    figure.set_dpi(PAPER.get().dpi or DPI)
    agg = FigureCanvasAgg(figure)

    def picture() -> Image.Image:
        agg.draw()
        return Image.fromarray(np.asarray(agg.buffer_rgba())).convert("RGB").quantize(128)

    pictures = (picture() for _ in frames)
    with open(draft, "wb") as file:  # Pillow would leave it open when it is interrupted
        next(pictures).save(file, "GIF", save_all=True, append_images=pictures, duration=1000 / rate, loop=0)

"""Pictures of a heap (as in B97 figs. 1 to 3) and a film of its largest avalanche."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image

from workflow.archive.read import Archive
from workflow.data.files import atomic_write
from workflow.data.frame import Bools, Floats, Frame
from workflow.errors import InputError
from workflow.measures.heap import Avalanche, Ground, Tracks, avalanches, base_forces, fields, flanks, in_heap, smooth, surface
from workflow.pipeline.heap import ground as ground_of
from workflow.reports.canvas import rounded
from workflow.reports.figures import BLUE, FILL, INK, OUTLINE, RED, save, sized, style, width
from workflow.reports.paper import NARROW, PAGE
from workflow.reports.registry import Shown
from workflow.runs.directory import ARCHIVE

WIDEST = 3.0  # points of the line of the largest force
FILM_FRAMES, FILM_PAUSE = 40, 120  # at most; milliseconds


def _shown(runs: Sequence[Shown]) -> tuple[Frame, Ground]:
    """The frame of the run and where its heap stands.  Raises InputError if it holds none."""
    directory, _, number = runs[0]
    with Archive(directory / ARCHIVE) as archive:
        frame = archive.frame(number)
    ground = ground_of(directory.scene)
    if not in_heap(frame, ground).any():
        raise InputError(f"frame {number} of '{directory.path}' holds no heap; choose another with --frame")
    return frame, ground


def draw_snapshot(runs: Sequence[Shown], paths: Sequence[Path]) -> None:
    """`snapshot` of a run."""
    snapshot(*_shown(runs), paths)


def draw_vectors(runs: Sequence[Shown], paths: Sequence[Path]) -> None:
    """`vectors` of a run."""
    vectors(*_shown(runs), paths)


def draw_forces(runs: Sequence[Shown], paths: Sequence[Path]) -> None:
    """`forces` of a run."""
    forces(*_shown(runs), paths)


def draw_maps(runs: Sequence[Shown], paths: Sequence[Path]) -> None:
    """`maps` of a run."""
    maps(*_shown(runs), paths)


def draw_film(runs: Sequence[Shown], paths: Sequence[Path]) -> bool:
    """`film` of the largest avalanche of a run; False if there was none."""
    with Archive(runs[0].directory / ARCHIVE) as archive:
        tracks = archive.tracks
    ground = ground_of(runs[0].directory.scene)
    slides = avalanches(tracks, ground) if tracks is not None else []
    if tracks is None or not slides:
        return False
    film(tracks, ground, max(slides, key=lambda event: event.size), paths[0])
    return True


def _axes(axes: Axes, frame: Frame, ground: Ground) -> None:
    """The heap with its base, equal scales, x from the middle."""
    own = in_heap(frame, ground)
    x = frame.position[own, 0] - ground.middle
    half = max(float(np.abs(x).max(initial=5.0)) + 2.0, 8.0)
    top = float((frame.position[own, 1] - ground.level).max(initial=4.0)) + 2.0
    axes.set(xlim=(-half, half), ylim=(-1.0, top), aspect="equal", ylabel=r"height $y/\sigma$")


def _panels(frame: Frame, ground: Ground, number: int, low: float = 0.0) -> Figure:
    """A figure as high as so many pictures of the heap above each other, and ``low`` millimetres more."""
    probe = Figure().subplots()
    _axes(probe, frame, ground)
    (x0, x1), (y0, y1) = probe.get_xlim(), probe.get_ylim()
    across = 0.82 * width(PAGE)
    figure = sized((number * (across * (y1 - y0) / (x1 - x0) + 11.0) + low) / width(PAGE), PAGE)
    figure.set_layout_engine("compressed")
    return figure


def _discs(axes: Axes, place: Floats, size: Floats, colours: str | list[str]) -> None:
    axes.add_collection(
        EllipseCollection(
            size, size, np.zeros_like(size), units="xy", offsets=place, offset_transform=axes.transData, facecolors=colours,
            edgecolors=OUTLINE, linewidths=0.25,
        )
    )  # fmt: skip


def snapshot(frame: Frame, ground: Ground, path: Sequence[Path]) -> None:
    """The grains (fig. 1a) with the surface profile and the straight lines fitted to both flanks, or why there are none."""
    with style():
        figure = _panels(frame, ground, 1, 11.0 if width(PAGE) >= NARROW else 22.0)
        axes = figure.subplots()
        _axes(axes, frame, ground)
        fixed, own = frame.ids <= ground.base, in_heap(frame, ground)
        colours = np.where(fixed, OUTLINE, FILL).tolist()
        _discs(axes, frame.position - [ground.middle, ground.level], frame.diameter, colours)
        profile = surface(frame.position[own], frame.diameter[own], ground)
        axes.plot(profile.x, profile.height, color=BLUE, linewidth=0.9, label="surface")
        found = flanks(profile)
        for side, flank in zip(("left", "right"), found or (), strict=False):
            x = np.array([flank.foot, flank.top])
            axes.plot(x, flank.slope * x + flank.intercept, color=RED, linewidth=1.4,
                      linestyle=(0, (4, 2)) if side == "left" else "-",
                      label=rf"{side} flank: {flank.degrees:.1f} $\pm$ {flank.uncertainty:.1f} degrees")  # fmt: skip
        if found is None:
            axes.plot([], [], " ", label="no slope: the heap is too low to have flanks")
        axes.set(xlabel=r"$x/\sigma$", title=f"{own.sum()} grains, $t$ = {frame.time:.5g}")
        figure.legend(loc="outside lower center", ncols=3 if width(PAGE) >= NARROW else 1)
        save(figure, path)


def vectors(frame: Frame, ground: Ground, path: Sequence[Path], range_: float = 1.2) -> None:
    """Centre-to-centre vectors of pairs closer than ``range_`` (figs. 2, 5, 6, 8): light regions are loosely packed."""
    with style():
        figure = _panels(frame, ground, 1)
        axes = figure.subplots()
        _axes(axes, frame, ground)
        table = frame.interactions.select(frame.interactions.distance < range_)
        start = frame.position[table.i] - [ground.middle, ground.level]
        axes.add_collection(LineCollection(list(np.stack((start, start + table.branch), axis=1)), colors=INK, linewidths=0.5))
        axes.set(xlabel=r"$x/\sigma$", title=f"centre-to-centre vectors, $t$ = {frame.time:.5g}")
        save(figure, path)


def forces(frame: Frame, ground: Ground, path: Sequence[Path]) -> None:
    """Normal forces as lines whose width is the force (fig. 3a), and the base force profile below (fig. 3b)."""
    with style():
        figure = _panels(frame, ground, 1, 42.0)
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(2.0, 1.0))
        _axes(top, frame, ground)
        table = frame.interactions
        largest = max(float(table.normal_force.max(initial=0.0)), 1e-12)
        size = table.normal_force / largest
        start = frame.position[table.i] - [ground.middle, ground.level]
        lines = list(np.stack((start, start + table.branch), axis=1))
        top.add_collection(LineCollection(lines, colors=RED, linewidths=WIDEST * np.maximum(size, 0.0)))
        force_key = rounded(largest)
        key = [
            Line2D(
                [],
                [],
                color=RED,
                linewidth=WIDEST * force_key / largest,
                solid_capstyle="butt",
                label=f"$N = {force_key:g}\\,mg$",
            )
        ]
        top.legend(handles=key, loc="upper right", title="normal forces")
        x, force = base_forces(frame, ground)
        bottom.bar(x, force, width=0.8, color=FILL, edgecolor=OUTLINE, linewidth=0.4, label="each base disc")
        bottom.plot(x, smooth(x, x, force, 2.0), color=BLUE, label=r"smoothed over 2 $\sigma$")
        bottom.set(xlabel=r"$x/\sigma$", ylabel="force $F_B/mg$",
                   ylim=(0, 1.45 * max(float(force.max(initial=1.0)), 1e-12)))  # fmt: skip
        bottom.legend(loc="upper right", ncols=2)
        save(figure, path)


def maps(frame: Frame, ground: Ground, path: Sequence[Path]) -> None:
    """Voidage, and lines along the largest compression coloured by its size."""
    grid = fields(frame, ground)
    with style():
        figure = _panels(frame, ground, 2)
        top, bottom = figure.subplots(2, 1, sharex=True)
        for axes in (top, bottom):
            _axes(axes, frame, ground)
        image = top.pcolormesh(grid.x, grid.y, grid.voidage, cmap="viridis", shading="nearest")
        figure.colorbar(image, ax=top, label="voidage", aspect=12)
        size = np.linalg.eigvalsh(np.nan_to_num(grid.stress))[..., 1]
        along = grid.major
        # a line has no sense of direction: let all point downwards, so that neighbours agree
        along = np.where(along[..., 1:] > 0.0, -along, along)
        along[np.isnan(grid.voidage)] = np.nan
        lines = bottom.streamplot(
            grid.x, grid.y, along[..., 0], along[..., 1], color=size, cmap="magma_r", linewidth=0.9, arrowstyle="-", density=1.6
        )
        figure.colorbar(lines.lines, ax=bottom, label=r"largest stress [$mg/\sigma$]", aspect=12)
        bottom.set(xlabel=r"$x/\sigma$")
        save(figure, path)


def film(tracks: Tracks, ground: Ground, event: Avalanche, path: Path) -> None:
    """Animated GIF of one avalanche, from a little before to a little after; grains that moved since the frame before red."""
    chosen = np.flatnonzero((tracks.time >= event.begin - 8.0) & (tracks.time <= event.end + 8.0))[:FILM_FRAMES]
    if len(chosen) < 2:
        raise InputError(f"film: no records between t = {event.begin} and {event.end}; use a shorter --track-interval")
    moved = np.zeros(len(tracks.ids), dtype=bool)
    pictures = []
    for k in chosen:
        if k > chosen[0]:
            moved = np.nan_to_num(np.hypot(*(tracks.position[k] - tracks.position[k - 1]).T)) > 0.25
        pictures.append(_picture(tracks, k, ground, moved))
    with atomic_write(path) as draft:
        pictures[0].save(draft, "GIF", save_all=True, append_images=pictures[1:], duration=FILM_PAUSE, loop=0)


def _picture(tracks: Tracks, k: int, ground: Ground, moved: Bools) -> Image.Image:
    present = ~np.isnan(tracks.position[k, :, 0])
    place = tracks.position[k, present] - [ground.middle, ground.level]
    with style():
        figure = Figure(figsize=(6.0, 3.0), dpi=100, layout="compressed")
        FigureCanvasAgg(figure)
        axes = figure.subplots()
        last = tracks.position[-1, tracks.ids > ground.base] - [ground.middle, ground.level]
        half, top = np.nanquantile(np.abs(last[:, 0]), 0.98) + 3.0, np.nanquantile(last[:, 1], 0.99) + 4.0
        axes.set(xlim=(-half, half), ylim=(-1.0, top), aspect="equal", xlabel=r"$x/\sigma$", ylabel=r"height $y/\sigma$",
                 title=f"$t$ = {tracks.time[k]:.1f}; dark: moved since the picture before")  # fmt: skip
        fixed = tracks.ids[present] <= ground.base
        colours = np.where(fixed, OUTLINE, np.where(moved[present], RED, FILL)).tolist()
        _discs(axes, place, np.ones(len(place)), colours)
        buffer = BytesIO()
        figure.savefig(buffer, format="png")
    return Image.open(buffer).convert("P", palette=Image.Palette.ADAPTIVE)

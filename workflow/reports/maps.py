"""Maps of a packing: holes, hyperstatic clusters, floppy modes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter
from scipy.linalg import svd
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from workflow.data.frame import Floats, Frame
from workflow.measures.holes import hole_triangles
from workflow.measures.modes import FloppyModes, Mobility, SelfStress
from workflow.reports.figures import (
    FILL,
    INK,
    OUTLINE,
    RATTLER,
    STYLE,
    PathLike,
    below,
    bonds,
    discs,
    save,
    sheet,
    wrap,
)

CLUSTERS = ("#1B3A5C", "#D1702B", "#5A9BD4", "#7A1E48", "#6FB07F", "#B8902F", "#3F7F7F", "#C76D8E")  # dark, light by turns
SIZES, MOTION = "viridis_r", "Blues"  # light to dark: also in grey
BELOW = 0.62  # inches for a colour bar and its label
ENDLESS = "#D0D0D0"  # a hole that percolates
MOBILE = 1e-2  # mean square motion above which a grain takes part in a mechanism


def hole_map(frame: Frame, path: PathLike | Sequence[PathLike], *, length: float = 1.0) -> None:
    """Holes coloured by their equivalent radius R_H (G07 eq. 29), light to dark; a percolating one, which has none, grey."""
    with mpl.rc_context(STYLE):
        figure, axes, points = sheet(frame, BELOW)
        found, corners, hole = hole_triangles(frame)
        sized = found.radius[~np.isnan(found.radius)]
        colours = LogNorm(0.05 * length, max(float(sized.max(initial=0.0)), 0.5 * length))
        inside = hole >= 0
        radius = np.full(len(hole), np.nan)
        radius[inside] = found.radius[hole[inside]]
        closed = inside & ~np.isnan(radius)
        _triangles(axes, frame, corners[closed], ScalarMappable(colours, SIZES).to_rgba(radius[closed]))
        _triangles(axes, frame, corners[inside & np.isnan(radius)], ENDLESS)
        discs(axes, frame, ["white"] * frame.grains, points)
        _bar(figure, axes, ScalarMappable(colours, SIZES), r"equivalent radius $R_H/a$")
        mean = found.weighted_radius
        what = "one percolates (grey)" if mean is None else rf"$\langle R\rangle_w$ = {mean:.3f} $a$"
        axes.set_title(rf"holes: {len(found.area)}   {what}   $N$ = {frame.grains}", fontsize=10)
        save(figure, path)


def _triangles(axes: Axes, frame: Frame, corners: Floats, colours: Any) -> None:
    """Triangles (T, 3, 2) in one colour or in ``colours`` (T, 4), with their images."""
    lower, upper = frame.origin, frame.origin + frame.cell
    for image in product((-1, 0, 1), repeat=2):
        moved = corners + image * frame.cell
        seen = ((moved.max(axis=1) > lower) & (moved.min(axis=1) < upper)).all(axis=1)
        fill = colours if isinstance(colours, str) else colours[seen]
        # the edge in the colour of the face closes the hairlines between triangles
        axes.add_collection(PolyCollection(list(moved[seen]), facecolors=fill, edgecolors=fill, linewidths=0.6, zorder=0.5))


def _bar(figure: Figure, axes: Axes, scale: ScalarMappable, label: str) -> None:
    """Colour bar under the cell."""
    place = axes.get_position()
    height = 0.12 / figure.get_figheight()
    bar = figure.add_axes((place.x0 + 0.2 * place.width, place.y0 - 2.0 * height, 0.6 * place.width, height))
    figure.colorbar(scale, cax=bar, orientation="horizontal")
    bar.xaxis.set_minor_formatter(NullFormatter())
    bar.set_xlabel(label, fontsize=8, labelpad=1)
    bar.tick_params(labelsize=7, length=2, pad=1)


def self_stress_map(frame: Frame, found: SelfStress, path: PathLike | Sequence[PathLike]) -> None:
    """Hyperstatic clusters, each in one colour: interactions through which a self-balanced system of forces can pass.

    Line width: root of the sum of the squared forces of the systems, each normalised, on a common scale; grey thin lines
    carry none.
    """
    with mpl.rc_context(STYLE):
        figure, axes, points = sheet(frame)
        number = int(found.clusters.max(initial=-1)) + 1
        members = found.clusters >= 0
        loaded = np.zeros(frame.grains, dtype=bool)
        loaded[frame.interactions.i[members]] = loaded[frame.interactions.j[members]] = True
        discs(axes, frame, np.where(loaded, FILL, RATTLER).tolist(), points)
        kinds: dict[str, Any] = {"none": (~members, INK)}
        for k, colour in enumerate(CLUSTERS):
            kinds[colour] = (members & (found.clusters % len(CLUSTERS) == k), colour)
        share = _participation(found)
        widths = np.where(members, points * (0.06 + 0.24 * share), 0.4)
        bonds(axes, frame, kinds, np.maximum(widths, 0.4))
        clusters = f"{number} hyperstatic cluster{'' if number == 1 else 's'}"
        axes.set_title(
            rf"$H$ = {found.normal.shape[0]} in {clusters}   $N$ = {frame.grains}   $M$ = {len(members)}", fontsize=10
        )
        below(axes, [
            Line2D([], [], color=CLUSTERS[0], linewidth=3, label="hyperstatic clusters (one colour each)"),
            Line2D([], [], color=INK, linewidth=0.5, label="isostatic or floppy"),
            Line2D([], [], linestyle="", marker="o", markersize=7, markerfacecolor=RATTLER, markeredgecolor=OUTLINE,
                   label="grain without self-stress"),
        ])  # fmt: skip
        save(figure, path)


def _participation(found: SelfStress) -> Floats:
    """Share of each interaction in the self-stress, 0 to 1: root of the summed squares of the normalised systems."""
    square = found.normal.multiply(found.normal) + found.tangential.multiply(found.tangential)
    norm = np.asarray(square.sum(axis=1)).ravel()
    share = square.T @ np.divide(1.0, norm, out=np.zeros_like(norm), where=norm > 0)  # a system may be of moments alone
    return np.sqrt(share / max(float(share.max(initial=0.0)), 1e-300))


def floppy_map(frame: Frame, moving: Mobility, modes: FloppyModes, loose: int, path: PathLike | Sequence[PathLike]) -> None:
    """Mechanisms: grains shaded by their share in all of them, arrows for how they move.

    ``frame`` and its ``moving`` and ``modes`` without the ``loose`` grains (those that touch none).  Each connected set of
    mobile grains shows the motion that is most its own, its largest displacement two diameters long.
    """
    with mpl.rc_context(STYLE):
        figure, axes, points = sheet(frame, BELOW)
        colours = LogNorm(1e-3, 3.0)
        shades = ScalarMappable(colours, MOTION).to_rgba(np.maximum(moving.grains, 1e-3))
        discs(axes, frame, shades.tolist(), points)
        bonds(axes, frame, {"all": (np.ones(len(frame.interactions), bool), "white")}, np.full(len(frame.interactions), 1.0))
        bonds(axes, frame, {"all": (np.ones(len(frame.interactions), bool), INK)}, np.full(len(frame.interactions), 0.4))
        if len(modes.grains):
            _arrows(axes, frame, own_motions(frame, moving, modes))
        _bar(figure, axes, ScalarMappable(colours, MOTION), "mean square motion of a grain in all mechanisms")
        axes.set_title(
            rf"{moving.mechanisms} mechanisms (besides {loose} loose grains)   $N$ = {frame.grains + loose}", fontsize=10
        )
        save(figure, path)


def own_motions(frame: Frame, moving: Mobility, modes: FloppyModes) -> Floats:
    """Displacements (N, 2), largest 1, of each connected set of grains more mobile than MOBILE.

    Of all combinations of modes the one with the most motion inside the set: its leading singular vector.
    """
    table, motion = frame.interactions, np.zeros((frame.grains, 2))
    mobile = moving.grains > MOBILE
    joined = mobile[table.i] & mobile[table.j]
    pairs = (np.ones(int(joined.sum())), (table.i[joined], table.j[joined]))
    label = connected_components(coo_array(pairs, shape=(frame.grains, frame.grains)), directed=False)[1]
    for cluster in np.unique(label[mobile]):
        members = np.flatnonzero(label == cluster)
        own = svd(modes.grains[:, members, :2].reshape(len(modes.grains), -1), full_matrices=False)[2][0].reshape(-1, 2)
        motion[members] = own / max(float(np.hypot(*own.T).max()), 1e-300)
    return motion


def _arrows(axes: Axes, frame: Frame, motion: Floats) -> None:
    """Displacements, 1 being two diameters; those too short to be seen are left out."""
    rows = np.hypot(*motion.T) > 0.1
    scale = 2.0 * float(np.median(frame.diameter))
    axes.quiver(*wrap(frame, frame.position)[rows].T, *(motion[rows] * scale).T, angles="xy", scale_units="xy", scale=1.0,
                width=0.0028, headwidth=3.5, headlength=4.0, color="#C2410C", edgecolor="white", linewidth=0.3,
                zorder=5)  # fmt: skip

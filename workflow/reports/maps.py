"""Maps of a packing: holes, hyperstatic clusters, floppy modes."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.ticker import NullFormatter
from scipy.linalg import svd
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from workflow.data.frame import Floats, Frame
from workflow.measures.holes import hole_triangles
from workflow.measures.modes import FloppyModes, Mobility, SelfStress
from workflow.reports.canvas import (
    SWATCH,
    Bar,
    Canvas,
    Kind,
    bonds,
    canvas_of,
    disc_swatch,
    discs,
    finish,
    length_bar,
    swatch,
    wrap,
)
from workflow.reports.figures import FILL, INK, RATTLER, Paths, save, style

CLUSTERS = ("#1B3A5C", "#D1702B", "#5A9BD4", "#7A1E48", "#6FB07F", "#B8902F", "#3F7F7F", "#C76D8E")  # dark, light by turns
SIZES, MOTION = "viridis_r", "Blues"  # light to dark: also in grey
BELOW = 38.0  # points for a colour bar and its label
ENDLESS = "#D0D0D0"  # a hole that percolates
MOBILE = 1e-2  # mean square motion above which a grain takes part in a mechanism


def hole_map(frame: Frame, path: Paths, *, length: float = 1.0) -> None:
    """Holes coloured by their equivalent radius R_H (G07 eq. 29), light to dark; a percolating one, which has none, grey."""
    with style():
        canvas = canvas_of(frame)
        found, corners, hole = hole_triangles(frame)
        sized = found.radius[~np.isnan(found.radius)]
        colours = LogNorm(0.05 * length, max(float(sized.max(initial=0.0)), 0.5 * length))
        inside = hole >= 0
        radius = np.full(len(hole), np.nan)
        radius[inside] = found.radius[hole[inside]]
        closed = inside & ~np.isnan(radius)
        _triangles(canvas, frame, corners[closed], ScalarMappable(colours, SIZES).to_rgba(radius[closed]))
        _triangles(canvas, frame, corners[inside & np.isnan(radius)], ENDLESS)
        discs(canvas, frame, ["white"] * frame.grains)
        mean = found.weighted_radius
        what = "one percolates (grey)" if mean is None else rf"$\langle R\rangle_w$ = {mean:.3f} $a$"
        finish(canvas, rf"{len(found.area)} holes   {what}   $N$ = {frame.grains}", [], [length_bar(canvas)], BELOW)
        _bar(canvas, ScalarMappable(colours, SIZES), r"equivalent radius $R_H/a$")
        save(canvas.figure, path)


def _triangles(canvas: Canvas, frame: Frame, corners: Floats, colours: Any) -> None:
    """Triangles (T, 3, 2) in one colour or in ``colours`` (T, 4), with their images."""
    lower, upper = frame.origin, frame.origin + frame.cell
    for image in product((-1, 0, 1), repeat=2):
        moved = corners + image * frame.cell
        seen = ((moved.max(axis=1) > lower) & (moved.min(axis=1) < upper)).all(axis=1)
        fill = colours if isinstance(colours, str) else colours[seen]
        # the edge in the colour of the face closes the hairlines between triangles
        canvas.axes.add_collection(
            PolyCollection(list(moved[seen]), facecolors=fill, edgecolors=fill, linewidths=0.6, zorder=0.5)
        )


def _bar(canvas: Canvas, scale: ScalarMappable, label: str) -> None:
    """Colour bar in the room under the cell."""
    place, high = canvas.axes.get_position(), 72 * canvas.figure.get_figheight()
    bar = canvas.figure.add_axes((place.x0 + 0.2 * place.width, place.y0 - 13.0 / high, 0.6 * place.width, 8.0 / high))
    canvas.figure.colorbar(scale, cax=bar, orientation="horizontal")
    bar.xaxis.set_minor_formatter(NullFormatter())
    bar.set_xlabel(label, fontsize=7, labelpad=1)
    bar.tick_params(labelsize=6.5, length=2, pad=1.5)


def self_stress_map(frame: Frame, found: SelfStress, path: Paths) -> None:
    """Hyperstatic clusters, each in one colour: interactions through which a self-balanced system of forces can pass.

    Line width: root of the sum of the squared forces of the systems, each normalised, on a common scale; grey thin lines
    carry none.
    """
    with style():
        canvas = canvas_of(frame)
        number = int(found.clusters.max(initial=-1)) + 1
        members = found.clusters >= 0
        loaded = np.zeros(frame.grains, dtype=bool)
        loaded[frame.interactions.i[members]] = loaded[frame.interactions.j[members]] = True
        discs(canvas, frame, np.where(loaded, FILL, RATTLER).tolist())
        kinds = {"none": Kind(~members, INK)}
        for k, colour in enumerate(CLUSTERS):
            kinds[colour] = Kind(members & (found.clusters % len(CLUSTERS) == k), colour)
        share = _participation(found)
        widths = np.where(members, canvas.points * _wide(share), 0.4)
        bonds(canvas, frame, kinds, np.maximum(widths, 0.4))
        clusters = f"{number} hyperstatic cluster{'' if number == 1 else 's'}"
        handles = [
            swatch(Kind(members, CLUSTERS[0]), "hyperstatic, a colour for each cluster"),
            swatch(Kind(members, INK), "isostatic or floppy", wide=0.5),
            disc_swatch(RATTLER, "grain without self-stress"),
        ]
        title = rf"$H$ = {found.normal.shape[0]} in {clusters}   $N$ = {frame.grains}   $M$ = {len(members)}"
        half = Bar(SWATCH, canvas.points * _wide(0.5), "half of the largest share in the self-stress")
        finish(canvas, title, handles, [length_bar(canvas), *([half] if members.any() else [])])
        save(canvas.figure, path)


def _wide(share: Any) -> Any:
    """Width [a] of the line of an interaction with this share in the self-stress."""
    return 0.06 + 0.24 * share


def _participation(found: SelfStress) -> Floats:
    """Share of each interaction in the self-stress, 0 to 1: root of the summed squares of the normalised systems."""
    square = found.normal.multiply(found.normal) + found.tangential.multiply(found.tangential)
    norm = np.asarray(square.sum(axis=1)).ravel()
    share = square.T @ np.divide(1.0, norm, out=np.zeros_like(norm), where=norm > 0)  # a system may be of moments alone
    return np.sqrt(share / max(float(share.max(initial=0.0)), 1e-300))


def floppy_map(frame: Frame, moving: Mobility, modes: FloppyModes, loose: int, path: Paths) -> None:
    """Mechanisms: grains shaded by their share in all of them, arrows for how they move.

    ``frame`` and its ``moving`` and ``modes`` without the ``loose`` grains (those that touch none).  Each connected set of
    mobile grains shows the motion that is most its own, its largest displacement two diameters long.
    """
    with style():
        canvas = canvas_of(frame)
        colours = LogNorm(1e-3, 3.0)
        shades = ScalarMappable(colours, MOTION).to_rgba(np.maximum(moving.grains, 1e-3))
        discs(canvas, frame, shades.tolist())
        every, wide = np.ones(len(frame.interactions), dtype=bool), np.ones(len(frame.interactions))
        for colour, thick in (("white", 1.0), (INK, 0.4)):
            bonds(canvas, frame, {"all": Kind(every, colour)}, thick * wide)
        if len(modes.grains):
            _arrows(canvas, frame, own_motions(frame, moving, modes))
        title = rf"{moving.mechanisms} mechanisms besides {loose} loose grains   $N$ = {frame.grains + loose}"
        finish(canvas, title, [], [length_bar(canvas)], BELOW)
        _bar(canvas, ScalarMappable(colours, MOTION), "mean square motion of a grain in all mechanisms")
        save(canvas.figure, path)


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


def _arrows(canvas: Canvas, frame: Frame, motion: Floats) -> None:
    """Displacements, 1 being two diameters; those too short to be seen are left out."""
    rows = np.hypot(*motion.T) > 0.1
    scale = 2.0 * float(np.median(frame.diameter))
    canvas.axes.quiver(*wrap(frame, frame.position)[rows].T, *(motion[rows] * scale).T, angles="xy", scale_units="xy",
                scale=1.0, width=0.0028, headwidth=3.5, headlength=4.0, color="#C2410C", edgecolor="white", linewidth=0.3,
                zorder=5)  # fmt: skip

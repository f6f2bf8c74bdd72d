"""Pictures of a frame: its force network, as in G07 fig. 2 and figs. 11, 12, 19-22."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.lines import Line2D

from workflow.data.balance import solid_fraction
from workflow.data.frame import Bools, Frame
from workflow.errors import InputError
from workflow.measures.packing import coordination
from workflow.measures.percolation import force_magnitude
from workflow.reports.canvas import (
    DASHED,
    DOTTED,
    SOLID,
    THINNEST,
    Kind,
    bonds,
    canvas_of,
    disc_swatch,
    discs,
    finish,
    force_bar,
    length_bar,
    swatch,
)
from workflow.reports.figures import BLUE, FILL, INK, ORANGE, RATTLER, RED, Paths, save, style

BAND = 0.12  # width of the line of one force unit, in length units a
WORDS = {
    "compressive": "compressive, $N>0$", "tensile": "tensile, $N<0$", "distant": "distant pair, $N<0$",
    "no force": "contact without force", "unstressed": "contact without stress",
}  # fmt: skip


def force_network(
    frame: Frame,
    path: Paths,
    *,
    force_unit: float = 1.0,
    symbol: str = "F_0",
    tolerance: float = 1e-4,
    threshold: float | None = None,
    band: float = BAND,
) -> None:
    """Draw the discs and the normal forces of ``frame`` to ``path`` (one or several; .png, .svg or .pdf).

    Line width proportional to |N|, ``band`` wide for N = ``force_unit`` (F0, or a P without cohesion; ``symbol`` is its
    name in the legend), and THINNEST where that is less; compressive forces red and solid, tensile ones blue and dashed,
    those of distant pairs orange and dotted, thin and dark where |N| < tolerance force_unit; rattlers grey.  With a
    ``threshold`` [force] as G07 figs. 11, 12, 19-22: thin and dark where the total force is below it, and grey the grains
    that have only such contacts.  The cell is drawn with the periodic images that reach into it.  Raises InputError
    (suffix, force_unit).
    """
    if not force_unit > 0:
        raise InputError(f"force_unit is {force_unit}; it must be positive: give F0, or P a without cohesion")
    with style():
        canvas = canvas_of(frame)
        network = coordination(frame, threshold=tolerance * force_unit)
        kinds, grey = kinds_of_fig2(frame, force_unit, tolerance), network.rattlers
        if threshold is not None:
            kinds, grey = kinds_of_fig11(frame, threshold), np.ones(frame.grains, dtype=bool)
            for kind in list(kinds.values())[1:]:
                grey[frame.interactions.i[kind.rows]] = grey[frame.interactions.j[kind.rows]] = False
        discs(canvas, frame, np.where(grey, RATTLER, FILL).tolist())
        size = np.abs(frame.interactions.normal_force) / force_unit
        seen = bonds(canvas, frame, kinds, np.maximum(size * band * canvas.points, THINNEST))
        handles = legend_of({name: kinds[name] for name in seen})
        if grey.any():
            handles.append(disc_swatch(RATTLER, "rattler" if threshold is None else "unstressed grain"))
        bars = [length_bar(canvas)]
        if set(seen) & set(SIGNED):
            bars.append(force_bar(band * canvas.points, symbol, float(size.max())))
        state = rf"$\Phi$ = {solid_fraction(frame):.4f}   $z$ = {network.z:.3f}   $N$ = {frame.grains}   $t$ = {frame.time:.6g}"
        finish(canvas, state, handles, bars)
        save(canvas.figure, path)


SIGNED = ("compressive", "tensile", "distant")
LOOK = {"no force": (INK, SOLID), "distant": (ORANGE, DOTTED), "tensile": (BLUE, DASHED), "compressive": (RED, SOLID)}


def look(rows: Mapping[str, Bools]) -> dict[str, Kind]:
    """Interactions of each kind as they are drawn, from the lowest to the highest."""
    return {name: Kind(rows[name], *LOOK[name]) for name in LOOK if name in rows}


def kinds_of_fig2(frame: Frame, unit: float, tolerance: float) -> Mapping[str, Kind]:
    """G07 fig. 2: by sign of N, distant pairs apart; in the order in which they are drawn."""
    table = frame.interactions
    idle = table.in_contact & (np.abs(table.normal_force) < tolerance * unit)
    pressed, pulled = table.normal_force > 0, table.normal_force < 0
    return look({
        "no force": idle, "distant": ~table.in_contact, "tensile": table.in_contact & ~idle & pulled,
        "compressive": table.in_contact & ~idle & pressed,
    })  # fmt: skip


def kinds_of_fig11(frame: Frame, threshold: float) -> Mapping[str, Kind]:
    """G07 figs. 11, 12, 19-22: apart where the total force is below ``threshold``, the others by sign of N."""
    idle, normal = force_magnitude(frame) < threshold, frame.interactions.normal_force
    return {"unstressed": Kind(idle, *LOOK["no force"])} | look(
        {"tensile": ~idle & (normal < 0), "compressive": ~idle & (normal >= 0)}
    )


def legend_of(kinds: Mapping[str, Kind]) -> list[Line2D]:
    """The entries of ``kinds`` in the legend."""
    return [swatch(kinds[name], text, wide=1.8 if name in SIGNED else 0.5) for name, text in WORDS.items() if name in kinds]

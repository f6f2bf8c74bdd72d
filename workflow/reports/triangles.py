"""Self-balanced forces in triangles of discs, true to scale, from a sample (G07 figs. 16 and 18)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from workflow.data.frame import Floats, Frame, Ints
from workflow.errors import InputError
from workflow.measures.forces import corners
from workflow.reports.figures import BLUE, FILL, INK, OUTLINE, RED, Paths, panel, save, style

BAR = 0.45  # length of the largest force, in the largest diameter
DOTTED = (0, (2, 2))
REPULSIVE: Any = {"color": RED, "linestyle": "-"}
TENSILE: Any = {"color": BLUE, "linestyle": (0, (3, 1.5))}


def triangle(frame: Frame, path: Paths, *, tolerance: float) -> None:
    """The disc that two touching discs hold with the largest forces (G07 fig. 16), the line that these must follow, and
    |T/N| beside eq. 20.  ``tolerance``: smaller forces [force] count as none.  Raises InputError if there is no such disc.
    """
    found = corners(frame, tolerance=tolerance)
    if not len(found.grains):
        raise InputError("triangle: no disc is held by two touching discs alone; choose another frame")
    apex, *base = found.grains[0].tolist()
    cluster = _Cluster(frame, (*base, apex))
    rows = [cluster.contact(apex, other) for other in base]
    measured = np.abs(frame.interactions.tangential[rows] / frame.interactions.normal_force[rows])
    title = rf"$|T/N|$ = {measured[0]:.3f}, {measured[1]:.3f}; eq. 20: {found.ratio[0]:.3f}"
    _draw(cluster, [(apex, base)], dict(zip((*base, apex), "12D", strict=True)), title, path)


def double_triangle(frame: Frame, path: Paths, *, tolerance: float) -> None:
    """Two discs that the same two touching discs hold (G07 fig. 18), with the largest forces of the sample; the force
    between the two must follow the full line if nothing else acts on them.  Arguments and errors as `triangle`."""
    found = corners(frame, tolerance=tolerance)
    seen: dict[tuple[int, int], int] = {}
    for apex, one, two in found.grains.tolist():
        pair = (min(one, two), max(one, two))
        if pair in seen:
            break
        seen[pair] = apex
    else:
        raise InputError("double_triangle: no two discs are held by the same two alone; choose another frame")
    cluster = _Cluster(frame, (*pair, seen[pair], apex))
    row = cluster.contact(*pair)
    force = frame.interactions
    title = rf"between 1 and 2: $N$ = {force.normal_force[row]:.3g}, $T$ = {force.tangential[row]:.2g}"
    names = dict(zip((*pair, seen[pair], apex), ("1", "2", "D", "D'"), strict=True))
    _draw(cluster, [(seen[pair], list(pair)), (apex, list(pair))], names, title, path)


class _Cluster:
    """Centres of discs that hang together, relative to the first, and their contacts."""

    def __init__(self, frame: Frame, grains: Sequence[int]) -> None:
        self.frame, self.grains = frame, list(grains)
        table = frame.interactions
        inside = np.isin(table.i, self.grains) & np.isin(table.j, self.grains) & table.in_contact
        self.rows: Ints = np.flatnonzero(inside)
        self.place: dict[int, Floats] = {self.grains[0]: np.zeros(2)}
        while len(self.place) < len(self.grains):
            for row in self.rows:
                i, j, branch = int(table.i[row]), int(table.j[row]), table.branch[row]
                if i in self.place:
                    self.place.setdefault(j, self.place[i] + branch)
                elif j in self.place:
                    self.place[i] = self.place[j] - branch

    def contact(self, one: int, two: int) -> int:
        """Row of the contact of two of the discs."""
        table = self.frame.interactions
        return int(next(row for row in self.rows if {int(table.i[row]), int(table.j[row])} == {one, two}))

    def point(self, row: int) -> Floats:
        """Where the discs of a contact touch."""
        table = self.frame.interactions
        i = int(table.i[row])
        return np.asarray(self.place[i] + 0.5 * self.frame.diameter[i] * table.branch[row] / table.distance[row])


def _draw(
    cluster: _Cluster, held: Sequence[tuple[int, list[int]]], names: dict[int, str], title: str,
    path: Paths,
) -> None:  # fmt: skip
    """Discs, forces as bars through the contacts, dotted the line through the two contacts of each held disc; with two of
    these the full line from the base contact to where the dotted lines meet."""
    frame, table = cluster.frame, cluster.frame.interactions
    with style():
        figure, axes = panel(1.05)
        for grain, name in names.items():
            centre, radius = cluster.place[grain], 0.5 * frame.diameter[grain]
            axes.add_patch(Circle((centre[0], centre[1]), radius, facecolor=FILL, edgecolor=OUTLINE, linewidth=0.8))
            axes.text(centre[0], centre[1], name, ha="center", va="center", fontsize=9)
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.autoscale(enable=False)  # the lines go on beyond the discs
        lines = [np.array([cluster.point(cluster.contact(apex, other)) for other in base]) for apex, base in held]
        for ends in lines:
            axes.axline(*_two(ends), color=INK, linestyle=DOTTED, linewidth=0.9)
        if len(lines) == 2:
            start = cluster.point(cluster.contact(*held[0][1]))
            axes.axline(*_two(np.array([start, _meeting(*lines)])), color=INK, linewidth=0.7)
        force = table.force[cluster.rows]
        bars = force * BAR * frame.diameter[cluster.grains].max() / np.hypot(*force.T).max()
        for row, bar in zip(cluster.rows, bars, strict=True):
            ends = cluster.point(row) + np.outer((-0.5, 0.5), bar)
            axes.plot(*ends.T, linewidth=2.5, solid_capstyle="butt", dash_capstyle="butt",
                      **(REPULSIVE if table.normal_force[row] > 0 else TENSILE))  # fmt: skip
        axes.set_axis_off()
        axes.set_title(title)
        handles = [Line2D([], [], **REPULSIVE, linewidth=2.5, label="repulsive"),
                   Line2D([], [], **TENSILE, linewidth=2.5, label="tensile"),
                   Line2D([], [], color=INK, linestyle=DOTTED, linewidth=0.9, label="line of two forces")]  # fmt: skip
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
        save(figure, path)


def _two(ends: Floats) -> tuple[tuple[float, float], tuple[float, float]]:
    (x1, y1), (x2, y2) = ends.tolist()
    return (x1, y1), (x2, y2)


def _meeting(one: Floats, two: Floats) -> Floats:
    """Where the lines through two points each cross; of (nearly) parallel ones a point far along the first."""
    along, other = one[1] - one[0], two[1] - two[0]
    cross = along[0] * other[1] - along[1] * other[0]
    apart = two[0] - one[0]
    far = (apart[0] * other[1] - apart[1] * other[0]) / (cross if abs(cross) > 1e-9 else 1e-9)
    return np.asarray(one[0] + far * along)

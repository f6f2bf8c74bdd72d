"""Holes of a packing: connected parts of the space outside the discs (G07 section V), exactly and on the paper's mesh.

The exact route cuts the cell into the triangles of the regular (weighted Delaunay) triangulation of the discs.  Space
leaks from one triangle to the next across an edge unless the two discs of that edge touch, so holes are the connected
sets of triangles (for discs that is exact: alpha complex, Edelsbrunner 1995), islands of grains inside a hole
included.  Area and second moment are those of the triangles less the disc sectors in their corners.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy import ndimage
from scipy.spatial import ConvexHull, QhullError

from workflow.data.frame import Bools, Floats, Frame, Ints
from workflow.errors import InputError, WorkflowError
from workflow.measures.clusters import wrapped
from workflow.measures.density import indicator
from workflow.measures.percolation import components


@dataclass(frozen=True)
class Holes:
    """Holes, largest area first: ``area`` (n,), ``radius`` (n,) R_H [length], ``wraps`` (n, 2) around axis 1, axis 2.

    R_H is the radius of the disc with the same radius of gyration (eq. 29), R_H = sqrt(2 <|r - r_c|^2>); NaN for a
    hole that wraps around the cell, which has no centre.
    """

    area: Floats
    radius: Floats
    wraps: Bools

    @property
    def weighted_radius(self) -> float | None:
        """<R>_w = sum area R_H / sum area (eq. 30); None when a hole percolates (winds) or there is none."""
        if len(self.area) == 0 or self.wraps.any():
            return None
        return float(np.average(self.radius, weights=self.area))

    def distribution(self, edges: Floats) -> Floats:
        """Number density of R_H: share of all holes per unit length in each bin of ``edges`` (B + 1,), (B,).

        Percolating holes count among all, but fall in no bin.
        """
        edges = np.asarray(edges, dtype=np.float64)
        if len(edges) < 2 or not (np.diff(edges) > 0).all():
            raise InputError(f"edges = {edges} must be at least two ascending lengths; try numpy.geomspace")
        sized = self.radius[~np.isnan(self.radius)]
        return np.histogram(sized, edges)[0] / (max(len(self.area), 1) * np.diff(edges))


@dataclass(frozen=True)
class _Mesh:
    """Triangles of a periodic triangulation: ``grain`` (T, 3) counter-clockwise, ``point`` (T, 3, 2) unwrapped corners.

    ``side`` (T, 3): number of the edge opposite to each corner, the same in both triangles that share it; ``base``
    (T, 3, 2): cells by which this copy of the edge is shifted from its reference copy; ``closed`` (T, 3): its discs
    touch.
    """

    grain: Ints
    point: Floats
    side: Ints
    base: Ints
    closed: Bools


def holes(frame: Frame) -> Holes:
    """Holes between touching discs (gap < 0; distant pairs do not close a hole), without a mesh.

    Raises InputError without grains or for positions that are not finite, WorkflowError when the triangulation fails.
    """
    return hole_triangles(frame)[0]


def hole_triangles(frame: Frame) -> tuple[Holes, Floats, Ints]:
    """`holes`, and what they are made of: triangles (T, 3, 2) between disc centres, and the hole of each, (T,) int64.

    A triangle less its three discs is part of its hole; -1 where nothing is left.  Corners may lie outside the cell.
    """
    if frame.grains == 0:
        raise InputError("frame has 0 grains; holes need at least one grain")
    mesh = _triangulate(frame)
    i, j, offset = _open_neighbours(mesh)
    parts = components(len(mesh.grain), i, j, offset)
    corners = mesh.point + (parts.image * frame.cell)[:, None, :]
    moments = _void_moments(corners, 0.5 * frame.diameter[mesh.grain], mesh.closed)
    found, rank = _collect(parts.label, parts.wraps, *moments, smallest=1e-12 * frame.area / frame.grains)
    return found, frame.origin + mesh.point, rank[parts.label]


def grid_holes(frame: Frame, *, spacing: float) -> Holes:
    """Holes as in the paper: mesh nodes outside all discs, joined to their four neighbours (spacing about a/100).

    At a mesh of finite spacing a contact can leak and a gap narrower than the spacing can close; ``holes`` is free of
    that. Memory: about 8 bytes per mesh node, A / spacing^2 nodes.
    """
    void = ~indicator(frame, spacing)
    label, count = ndimage.label(void)
    i, j, offset = _across_the_edges(label)
    parts = components(count, i, j, offset)
    run, low, high = _runs(label)
    part = label[run, low] - 1
    step = frame.cell / label.shape
    length = (high - low).astype(np.float64)
    centre = np.column_stack((run + 0.5, 0.5 * (low + high))) * step + parts.image[part] * frame.cell
    within = (length**2 - 1.0) / 12.0 * step[1] ** 2  # variance of evenly spaced nodes about the middle of the run
    second = length * ((centre**2).sum(axis=1) + within)
    pixel = step.prod()
    return _collect(
        parts.label[part], parts.wraps, length * pixel, centre * (length * pixel)[:, None], second * pixel, smallest=0.0
    )[0]


def _collect(label: Ints, wraps: Bools, area: Floats, first: Floats, second: Floats, smallest: float) -> tuple[Holes, Ints]:
    """Sum the moments of the pieces of each hole; pieces of rounding size are no holes.  Also the rank of each label."""
    count = len(wraps)
    total: Floats = np.bincount(label, area, minlength=count).astype(np.float64)
    moment = np.column_stack([np.bincount(label, first[:, a], minlength=count) for a in (0, 1)])
    square = np.bincount(label, second, minlength=count)
    kept = total > smallest
    total, moment, square, wraps = total[kept], moment[kept], square[kept], wraps[kept]
    gyration = square / total - ((moment / total[:, None]) ** 2).sum(axis=1)
    radius = np.sqrt(2.0 * np.maximum(gyration, 0.0))
    radius[wraps.any(axis=1)] = np.nan
    order = np.lexsort((radius, -total))
    rank = np.full(count, -1, dtype=np.int64)
    rank[np.flatnonzero(kept)[order]] = np.arange(len(order))
    return Holes(total[order], radius[order], wraps[order]), rank


def _void_moments(p: Floats, r: Floats, closed: Bools) -> tuple[Floats, Floats, Floats]:
    """Area, integral of (x, y) and of x^2 + y^2 over each triangle outside its discs; p (T, 3, 2), r (T, 3)."""
    ahead, behind = np.roll(p, -1, axis=1) - p, np.roll(p, 1, axis=1) - p
    area = 0.5 * _cross(ahead[:, 0], behind[:, 0])
    middle = p.mean(axis=1)
    first = area[:, None] * middle
    second = area / 12.0 * ((p**2).sum(axis=(1, 2)) + 9.0 * (middle**2).sum(axis=1))

    angle = np.abs(np.arctan2(_cross(ahead, behind), (ahead * behind).sum(axis=2)))
    bisector = np.arctan2(ahead[..., 1], ahead[..., 0]) + 0.5 * angle
    sector = 0.5 * angle * r**2
    # sector: centroid at (2 r/3) sin(angle/2)/(angle/2) on the bisector, second moment about the corner angle r^4/4
    arm = 2.0 / 3.0 * r * np.sinc(angle / (2.0 * np.pi))
    reach = p + arm[..., None] * np.stack((np.cos(bisector), np.sin(bisector)), axis=-1)
    area = area - sector.sum(axis=1)
    first = first - (sector[..., None] * reach).sum(axis=1)
    about = (p**2).sum(axis=2) + 2.0 * (p * (reach - p)).sum(axis=2) + 0.5 * r**2
    second = second - (sector * about).sum(axis=1)

    # two sectors of touching discs both hold their half lens: give one back, as a point in its middle
    lens, point = _half_lenses(p, r, closed)
    return (
        area + lens.sum(axis=1),
        first + (lens[..., None] * point).sum(axis=1),
        second + (lens * (point**2).sum(axis=2)).sum(axis=1),
    )


def _half_lenses(p: Floats, r: Floats, closed: Bools) -> tuple[Floats, Floats]:
    """Half the overlap of the two discs at each side (opposite to corner c), and the point between them."""
    a, b = np.roll(p, -1, axis=1), np.roll(p, -2, axis=1)
    ra, rb = np.roll(r, -1, axis=1), np.roll(r, -2, axis=1)
    d = np.hypot(*np.moveaxis(b - a, -1, 0))
    depth = (d**2 + ra**2 - rb**2) / (2.0 * d)  # from a to the common chord
    ca, cb = np.clip(depth / ra, -1.0, 1.0), np.clip((d - depth) / rb, -1.0, 1.0)
    segments = ra**2 * (np.arccos(ca) - ca * np.sqrt(1 - ca**2)) + rb**2 * (np.arccos(cb) - cb * np.sqrt(1 - cb**2))
    return np.where(closed, 0.5 * segments, 0.0), a + (depth / d)[..., None] * (b - a)


def _cross(u: Floats, v: Floats) -> Floats:
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def _open_neighbours(mesh: _Mesh) -> tuple[Ints, Ints, Ints]:
    """Pairs of triangles joined by an open edge, with the cells crossed from the first to the second."""
    order = np.argsort(mesh.side.ravel(), kind="stable")
    base, closed = mesh.base.reshape(-1, 2)[order], mesh.closed.ravel()[order]
    triangle = order // 3
    one, two = np.flatnonzero(~closed)[0::2], np.flatnonzero(~closed)[1::2]
    return triangle[one], triangle[two], base[one] - base[two]


def _triangulate(frame: Frame) -> _Mesh:
    """Periodic regular triangulation: that of the cell with a margin of images, wide enough for the pieces to fit."""
    # a nudge, the same for all images of a grain, and a shear settle lattices where several triangulations are regular
    nudge = 1e-7 * frame.diameter.min() * np.random.default_rng(0).uniform(-1.0, 1.0, (frame.grains, 2))
    position = wrapped(frame)
    margin = 20.0 * np.sqrt(frame.area / frame.grains) / frame.cell  # holes of usual size fit in
    while True:
        mesh = _fold(frame, position, *_cover(frame, position + nudge, np.minimum(margin, 2.0)))
        if mesh is not None:
            return mesh
        if margin.min() >= 2.0:  # two cells all round always hold the largest empty circle
            raise WorkflowError("discs cannot be triangulated periodically; check diameters, positions and cell")
        margin = 2.0 * margin


def _cover(frame: Frame, position: Floats, margin: Floats) -> tuple[Ints, Ints]:
    """Regular triangulation of the cell plus margin: grain (T, 3) and image (T, 3, 2) of the corners."""
    reach = np.ceil(margin).astype(int)
    grain, image = [], []
    for shift in product(*(range(-n, n + 1) for n in reach)):
        place = position / frame.cell + shift
        inside = np.flatnonzero(((place >= -margin) & (place <= 1.0 + margin)).all(axis=1))
        grain.append(inside)
        image.append(np.tile(shift, (len(inside), 1)))
    who, where = np.concatenate(grain), np.concatenate(image)
    x = position[who] + where * frame.cell - 0.5 * frame.cell
    x[:, 0] += 1e-7 * x[:, 1]
    # the lower hull of (x, |x|^2 - R^2) is the regular triangulation
    lifted = np.column_stack((x, (x**2).sum(axis=1) - 0.25 * frame.diameter[who] ** 2))
    try:
        hull = ConvexHull(lifted)
    except (QhullError, ValueError) as error:
        cause = str(error).splitlines()[0]
        raise WorkflowError(f"discs cannot be triangulated ({cause}); check the positions") from error
    lower = hull.simplices[hull.equations[:, 2] < 0.0]
    return who[lower], where[lower]


def _fold(frame: Frame, position: Floats, grain: Ints, image: Ints) -> _Mesh | None:
    """One copy of each triangle, joined across the cell's edges; None when the copies do not fit together."""
    grain, image = grain.astype(np.int64), image.astype(np.int64)
    lead = _lowest(grain, image)
    mine = (np.take_along_axis(image, lead[:, None, None], axis=1)[:, 0] == 0).all(axis=1)
    grain, image = grain[mine], image[mine]
    if len(grain) == 0:
        return None
    point = position[grain] + image * frame.cell
    clockwise = _cross(point[:, 1] - point[:, 0], point[:, 2] - point[:, 0]) < 0.0
    for array in (grain, image, point):
        array[clockwise] = array[clockwise][:, ::-1]
    key, base = _edge_keys(frame.grains, grain, image)
    _, side, uses = np.unique(key, return_inverse=True, return_counts=True)
    covered = 0.5 * np.abs(_cross(point[:, 1] - point[:, 0], point[:, 2] - point[:, 0])).sum()
    if (uses != 2).any() or not np.isclose(covered, frame.area, rtol=1e-9):
        return None
    return _Mesh(grain, point, side.reshape(key.shape), base, np.isin(key, _contact_keys(frame, position)))


def _lowest(grain: Ints, image: Ints) -> Ints:
    """Corner with the lowest (grain, image), (T,): the same corner in every copy of a triangle or an edge."""
    rank = (grain * 16 + image[..., 0] + 8) * 16 + image[..., 1] + 8
    return rank.argmin(axis=1)


def _edge_keys(grains: int, grain: Ints, image: Ints) -> tuple[Ints, Ints]:
    """Key of the edge opposite to each corner, (T, 3), the same for all its copies; cells of this copy, (T, 3, 2)."""
    ends = np.stack((np.roll(grain, -1, axis=1), np.roll(grain, -2, axis=1)), axis=2).reshape(-1, 2)
    cells = np.stack((np.roll(image, -1, axis=1), np.roll(image, -2, axis=1)), axis=2).reshape(-1, 2, 2)
    rows, lead = np.arange(len(ends)), _lowest(ends, cells)
    base = cells[rows, lead]
    key = _key(grains, ends[rows, lead], ends[rows, 1 - lead], cells[rows, 1 - lead] - base)
    return key.reshape(grain.shape), base.reshape(image.shape)


def _contact_keys(frame: Frame, position: Floats) -> Ints:
    """Keys of the touching pairs."""
    c = frame.interactions.select(frame.interactions.in_contact)
    crossed = np.rint((c.branch - (position[c.j] - position[c.i])) / frame.cell).astype(np.int64)
    ends = np.column_stack((c.i, c.j))
    cells = np.stack((np.zeros_like(crossed), crossed), axis=1)
    rows, lead = np.arange(len(ends)), _lowest(ends, cells)
    return _key(frame.grains, ends[rows, lead], ends[rows, 1 - lead], cells[rows, 1 - lead] - cells[rows, lead])


def _key(grains: int, low: Ints, high: Ints, step: Ints) -> Ints:
    return ((low * grains + high) * 16 + step[:, 0] + 8) * 16 + step[:, 1] + 8


def _runs(label: np.ndarray) -> tuple[Ints, Ints, Ints]:
    """Stretches of one non-zero label within a row: (row, first column, column behind the last)."""
    change = np.ones((label.shape[0], label.shape[1] + 1), dtype=bool)
    np.not_equal(label[:, 1:], label[:, :-1], out=change[:, 1:-1])
    row, column = np.nonzero(change)
    same = row[1:] == row[:-1]
    row, low, high = row[:-1][same], column[:-1][same], column[1:][same]
    inside = label[row, low] > 0
    return row[inside], low[inside], high[inside]


def _across_the_edges(label: np.ndarray) -> tuple[Ints, Ints, Ints]:
    """Labels that meet across the edges of the cell, with the cells crossed."""
    found = []
    for last, first, step in ((label[-1], label[0], (1, 0)), (label[:, -1], label[:, 0], (0, 1))):
        both = (last > 0) & (first > 0)
        pairs = np.unique(np.column_stack((last[both], first[both])), axis=0).astype(np.int64) - 1
        found.append(np.column_stack((pairs, np.tile(step, (len(pairs), 1)))))
    i, j, one, two = np.concatenate(found).T
    return i, j, np.column_stack((one, two))

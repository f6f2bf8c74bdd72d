"""Measures of poured heaps (B97): surface, angle of repose, base forces, voidage, stress, defects, avalanches.

Lengths in sigma, forces in m g.  x counts from the middle of the base, heights from the line of the base discs' centres.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from workflow.data.frame import Bools, Floats, Frame, Ints, Tracks
from workflow.errors import InputError

COLUMN = 1.0  # width of the columns of the surface profile
FLANK = (0.15, 0.85)  # part of the height over which the flanks are fitted
NEIGHBOUR = 1.3  # distance of neighbours in a triangular order, in mean diameters
MOVED = 0.5  # a grain that goes further than this between two records moves
LEAST_MOVING = 10  # grains that must move together to be an avalanche


@dataclass(frozen=True)
class Ground:
    """Where a heap stands: ``base`` number of fixed discs (ids 1 to base), ``middle`` x, ``level`` height of their centres."""

    base: int
    middle: float
    level: float


@dataclass(frozen=True)
class Surface:
    """Highest point of the heap in columns: ``x`` (K,) their centres, ``height`` (K,) >= 0."""

    x: Floats
    height: Floats


def in_heap(frame: Frame, ground: Ground) -> Bools:
    """Poured grains that a chain of interactions ties to the base, (N,); grains in flight are not."""
    fixed = frame.ids <= ground.base
    i, j = frame.interactions.i, frame.interactions.j
    # all base discs as one node: the last
    node = np.where(fixed, frame.grains, np.arange(frame.grains))
    links = coo_array((np.ones(len(i)), (node[i], node[j])), shape=(frame.grains + 1,) * 2)
    label = connected_components(links, directed=False)[1]
    return ~fixed & (label[:-1] == label[-1])


def surface(position: Floats, diameter: Floats, ground: Ground) -> Surface:
    """Profile of the grains at ``position`` (N, 2): top of the highest grain with its centre in each column."""
    if not len(position):
        return Surface(np.empty(0), np.empty(0))
    x = position[:, 0] - ground.middle
    column = np.floor(x / COLUMN + 0.5).astype(int)
    first, last = column.min(), column.max()
    height = np.zeros(last - first + 1)
    np.maximum.at(height, column - first, position[:, 1] + 0.5 * diameter - ground.level)
    return Surface(COLUMN * np.arange(first, last + 1), np.maximum(height, 0.0))


@dataclass(frozen=True)
class Flank:
    """The straight line ``slope`` x + ``intercept`` through the columns of one flank from ``foot`` to ``top`` (their x);
    ``error``: standard error of the slope, from the scatter about the line."""

    slope: float
    intercept: float
    error: float
    foot: float
    top: float

    @property
    def degrees(self) -> float:
        """Angle of the flank."""
        return float(np.degrees(np.arctan(abs(self.slope))))

    @property
    def uncertainty(self) -> float:
        """Standard error of the angle in degrees."""
        return float(np.degrees(self.error / (1.0 + self.slope * self.slope)))


def flanks(profile: Surface) -> tuple[Flank, Flank] | None:
    """Left and right flank: the straight line through the columns whose height is between 15 and 85 % of the highest, from
    the flank's foot to the first column above that on its way to the top.  None for a heap too low to have flanks."""
    if not len(profile.x) or profile.height.max() < 4.0:
        return None
    top = int(np.argmax(profile.height))
    sides = (slice(top, None, -1), slice(top, None))
    left, right = (_flank(profile.x[rows], profile.height[rows], profile.height[top]) for rows in sides)
    return None if left is None or right is None else (left, right)


def angle_of_repose(profile: Surface) -> dict[str, Any]:
    """Angles of the `flanks` in degrees.

    ``uncertainty`` of the mean: the standard errors of both slopes (from the scatter about the lines) and half the
    difference of the two sides, added in squares.  None for a heap too low to have flanks.
    """
    found = flanks(profile)
    if found is None:
        return {"left": None, "right": None, "mean": None, "uncertainty": None}
    left, right = found[0].degrees, found[1].degrees
    spread = np.hypot(0.5 * np.hypot(found[0].uncertainty, found[1].uncertainty), 0.5 * (left - right))
    return {"left": left, "right": right, "mean": 0.5 * (left + right), "uncertainty": float(spread)}


def _flank(x: Floats, height: Floats, top: float) -> Flank | None:
    """One flank, given from the top outwards."""
    below = np.flatnonzero(height < FLANK[1] * top)
    foot = np.flatnonzero(height > FLANK[0] * top)
    rows = slice(below[0], foot[-1] + 1) if len(below) else slice(0, 0)
    x, height = x[rows], height[rows]
    if len(x) < 4:
        return None
    (slope, intercept), covariance = np.polyfit(x, height, 1, cov=True)
    return Flank(float(slope), float(intercept), float(np.sqrt(covariance[0, 0])), float(x[-1]), float(x[0]))


def base_forces(frame: Frame, ground: Ground) -> tuple[Floats, Floats]:
    """x (B,) and downward force (B,) on each base disc from its contacts."""
    table, force = frame.interactions, frame.interactions.force
    down = np.zeros(frame.grains)
    np.add.at(down, table.j, -force[:, 1])
    np.add.at(down, table.i, force[:, 1])
    fixed = frame.ids <= ground.base
    return frame.position[fixed, 0] - ground.middle, down[fixed]


@dataclass(frozen=True)
class Profile:
    """Base force profile in ``x`` bins: ``force`` per base disc, ``error`` standard error over heaps and both sides."""

    x: Floats
    force: Floats
    error: Floats


def mean_profile(heaps: list[tuple[Floats, Floats]], width: float = 3.3) -> Profile:
    """Mean of base forces (x, force) over heaps in bins of ``width``, and its standard error over the heaps."""
    if not heaps:
        raise InputError("base force profile: no heaps given; measure at least one")
    edge = max(float(np.abs(x).max()) for x, _ in heaps)
    half = int(np.ceil(edge / width - 0.5))
    edges = width * (np.arange(-half, half + 2) - 0.5)
    sums = np.array([np.histogram(x, edges, weights=force)[0] for x, force in heaps])
    counts = np.array([np.histogram(x, edges)[0] for x, _ in heaps])
    each = sums / np.maximum(counts, 1)
    error = each.std(axis=0, ddof=1) / np.sqrt(len(heaps)) if len(heaps) > 1 else np.full(len(edges) - 1, np.nan)
    return Profile(0.5 * (edges[1:] + edges[:-1]), each.mean(axis=0), error)


def dip(x: Floats, force: Floats, half_width: float) -> float:
    """How far the centre (|x| < 0.15 half_width) lies below the mean of the largest bins of the two sides (0.15 to 0.7
    half_width): 1 - centre/maxima; positive for an M profile.  ``half_width`` of the heap's foot."""
    inner = np.abs(x) < 0.15 * half_width
    sides = [(sign * x >= 0.15 * half_width) & (sign * x < 0.7 * half_width) for sign in (-1, 1)]
    if not inner.any() or not all(side.any() for side in sides):
        return float("nan")
    return float(1.0 - force[inner].mean() / np.mean([force[side].max() for side in sides]))


def equivalent_stiffness(index: float, cutoff: float, closest: float) -> float:
    """k of the Hooke law that does the same work up to ``closest`` r_i < 1 [sigma] (B97 eq. 14):
    2 (r_i^-n - r0^-n)/n / (1 - r_i)^2, in m g/sigma."""
    if not 0.0 < closest < 1.0:
        raise InputError(
            f"equivalent stiffness: r_i = {closest} must lie between 0 and 1 sigma; take the closest pair of a run"
        )
    return 2.0 * (closest**-index - cutoff**-index) / index / (1.0 - closest) ** 2


def smooth(x: Floats, at: Floats, values: Floats, width: float) -> Floats:
    """Means of ``values`` at ``x`` weighted with a Gaussian of standard deviation ``width``, (len(at),)."""
    weight = np.exp(-0.5 * ((at[:, None] - x) / width) ** 2)
    return weight @ values / np.maximum(weight.sum(axis=1), 1e-300)


@dataclass(frozen=True)
class Field:
    """Fields on a grid: ``x`` (W,), ``y`` (H,), ``voidage`` (H, W), ``stress`` (H, W, 2, 2), compression positive; NaN
    outside the heap."""

    x: Floats
    y: Floats
    voidage: Floats
    stress: Floats

    @property
    def major(self) -> Floats:
        """Direction of the largest compression, (H, W, 2)."""
        clean = np.nan_to_num(self.stress)
        return np.linalg.eigh(clean)[1][..., 1]


def fields(frame: Frame, ground: Ground, width: float = 1.5, spacing: float = 0.75) -> Field:
    """Voidage and stress averaged with a Gaussian of standard deviation ``width`` on a grid of ``spacing``.

    Stress: -(1/A) sum over contacts of F r at the contact's middle (static part).  At the rim the average reaches outside:
    points farther than one diameter below no grain are left out.
    """
    own = in_heap(frame, ground)
    place = frame.position[own] - [ground.middle, ground.level]
    if not len(place):
        raise InputError("fields: the heap has no grains; choose a later frame")
    low, high = place.min(axis=0) - 1.0, place.max(axis=0) + 1.0
    x, y = (np.arange(a, b, spacing) for a, b in zip(low, high, strict=True))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    inside = cKDTree(place).query(grid, distance_upper_bound=0.9)[0] < np.inf
    area = np.pi / 4.0 * frame.diameter[own] ** 2
    kernel = _kernel(grid, place, width)
    # the kernel's own weight inside the heap, so that the rim is not taken for void
    covered = np.asarray(_kernel(grid, grid[inside], width).sum(axis=1)).ravel() * spacing**2
    voidage = 1.0 - kernel @ area / np.maximum(covered, 1e-12)
    table = frame.interactions
    middle = frame.position[table.i] + 0.5 * table.branch - [ground.middle, ground.level]
    product = table.force[:, :, None] * table.branch[:, None, :]
    stress = (_kernel(grid, middle, width) @ product.reshape(-1, 4)) / np.maximum(covered, 1e-12)[:, None]
    stress = 0.5 * (stress.reshape(-1, 2, 2) + stress.reshape(-1, 2, 2).transpose(0, 2, 1))
    voidage[~inside], stress[~inside] = np.nan, np.nan
    shape = (len(y), len(x))
    return Field(x, y, voidage.reshape(shape), stress.reshape(*shape, 2, 2))


def _kernel(grid: Floats, points: Floats, width: float) -> Any:
    near = cKDTree(grid).sparse_distance_matrix(cKDTree(points), 3.0 * width, output_type="coo_matrix").tocsr()
    near.data = np.exp(-0.5 * (near.data / width) ** 2) / (2.0 * np.pi * width**2)
    return near


def defects(frame: Frame, ground: Ground) -> dict[str, float]:
    """Triangular order: share of inner grains with six neighbours within 1.3 mean diameters, mean |psi_6|, and
    ``vacancies``: inner grains with five neighbours, over six, as a count of missing grains."""
    own = np.flatnonzero(in_heap(frame, ground))
    place = frame.position[own]
    if len(own) < 7:
        return {"sixfold": 0.0, "psi6": 0.0, "vacancies": 0.0}
    reach = NEIGHBOUR * float(frame.diameter[own].mean())
    pairs = cKDTree(place).query_pairs(reach, output_type="ndarray")
    i, j = np.concatenate((pairs, pairs[:, ::-1])).T
    count = np.bincount(i, minlength=len(own))
    angle = np.arctan2(*(place[j] - place[i]).T[::-1])
    order = np.bincount(i, np.cos(6.0 * angle), len(own)) + 1j * np.bincount(i, np.sin(6.0 * angle), len(own))
    depth = np.interp(place[:, 0] - ground.middle, *_profile_of(frame, ground)) - (place[:, 1] - ground.level)
    inner = (depth > 2.0) & (place[:, 1] - ground.level > 1.5)
    if not inner.any():
        return {"sixfold": 0.0, "psi6": 0.0, "vacancies": 0.0}
    psi = np.abs(order) / np.maximum(count, 1)
    return {
        "sixfold": float((count[inner] == 6).mean()),
        "psi6": float(psi[inner].mean()),
        "vacancies": float((count[inner] == 5).sum() / 6.0),
    }


def _profile_of(frame: Frame, ground: Ground) -> tuple[Floats, Floats]:
    own = in_heap(frame, ground)
    profile = surface(frame.position[own], frame.diameter[own], ground)
    return profile.x, profile.height


@dataclass(frozen=True)
class Avalanche:
    """``begin``, ``end`` time; ``size`` grains that moved; ``depth`` of the moving layer in diameters (nine tenths of the
    moved grains lie less deep below the surface, measured across the flank); ``side`` -1 left, 1 right."""

    begin: float
    end: float
    size: int
    depth: float
    side: int


def avalanches(tracks: Tracks, ground: Ground) -> list[Avalanche]:
    """Bursts in which at least 10 grains of one flank move by more than MOVED between two records.

    Grains that fall or have just been poured do not count: a grain belongs to the heap while it was within 1.5 diameters
    of another poured or fixed grain in both records, and from two records after its first on.
    """
    poured = tracks.ids > ground.base
    found: list[Avalanche] = []
    for side in (-1, 1):
        moving: list[tuple[float, float, Ints, Floats]] = []
        for k in range(2, len(tracks.time) - 1):
            rows, depth = _moving(tracks, k, poured, ground, side)
            if len(rows) >= LEAST_MOVING:
                moving.append((float(tracks.time[k]), float(tracks.time[k + 1]), rows, depth))
                continue
            found += _close(moving, side)
            moving = []
        found += _close(moving, side)
    return sorted(found, key=lambda event: event.begin)


def _moving(tracks: Tracks, k: int, poured: Bools, ground: Ground, side: int) -> tuple[Ints, Floats]:
    """Rows of the grains of one flank that move between records k and k + 1, and their depths below the surface."""
    before, after = tracks.position[k], tracks.position[k + 1]
    there = poured & ~np.isnan(tracks.position[k - 2 : k + 2, :, 0]).any(axis=0)
    goes = there & (np.hypot(*(np.nan_to_num(after - before)).T) > MOVED) & (side * (before[:, 0] - ground.middle) > 0.0)
    rows = np.flatnonzero(goes)
    if not len(rows):
        return rows, np.empty(0)
    present = np.flatnonzero(~np.isnan(before[:, 0]))
    near = cKDTree(before[present]).query(before[rows], k=2)[0][:, 1] < 1.5
    rows = rows[near]
    if not len(rows):
        return rows, np.empty(0)
    settled = before[there & ~goes]
    profile = surface(before[rows] if not len(settled) else np.concatenate((settled, before[rows])),
                      np.ones(len(settled) + len(rows)), ground)  # fmt: skip
    slope = np.degrees(0.0) if len(profile.x) < 2 else np.arctan2(profile.height.max(), 0.5 * np.ptp(profile.x))
    top = np.interp(before[rows, 0] - ground.middle, profile.x, profile.height)
    return rows, (top - (before[rows, 1] - ground.level)) * np.cos(slope)


def _close(moving: list[tuple[float, float, Ints, Floats]], side: int) -> list[Avalanche]:
    if not moving:
        return []
    rows = np.unique(np.concatenate([part[2] for part in moving]))
    depth = float(np.quantile(np.concatenate([part[3] for part in moving]), 0.9))
    return [Avalanche(moving[0][0], moving[-1][1], len(rows), depth, side)]


def measure(frame: Frame, ground: Ground, tracks: Tracks | None) -> dict[str, Any]:
    """The numbers of a heap for JSON."""
    own = in_heap(frame, ground)
    profile = surface(frame.position[own], frame.diameter[own], ground)
    x, force = base_forces(frame, ground)
    weight = float(frame.mass[own].sum())
    foot = 0.5 * float(np.ptp(x[force > 1e-3])) if (force > 1e-3).any() else 0.0
    grid = fields(frame, ground) if own.any() else None
    smoothed = smooth(x, x, force, 2.0)
    return {
        "grains_in_heap": int(own.sum()),
        "height": float(profile.height.max(initial=0.0)),
        "half_width": foot,
        "angle_of_repose_deg": angle_of_repose(profile),
        "surface": {"x": profile.x.tolist(), "height": profile.height.tolist()},
        "base_force_profile": {
            "x": x.tolist(), "force": force.tolist(), "smoothed": smoothed.tolist(),
            "dip": dip(x, smoothed, foot) if foot else None,
            "sum_over_weight": float(force.sum()) / weight if weight else None,
        },
        "solid_fraction": None if grid is None else float(1.0 - np.nanmean(grid.voidage)),
        "defects": defects(frame, ground),
        "closest_pair": float((frame.interactions.gap).min(initial=0.0)),
        "avalanches": [vars(event) for event in avalanches(tracks, ground)] if tracks is not None else None,
    }  # fmt: skip

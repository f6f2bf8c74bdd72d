"""Statistics of interaction forces (G07 section IV): distributions, populations, orientations, fabric and stress."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from workflow.data.frame import Bools, Floats, Frame, Ints
from workflow.errors import InputError
from workflow.measures.percolation import force_magnitude, image_offsets


@dataclass(frozen=True)
class Histogram:
    """Probability density per unit of the variable: ``edges`` (B + 1,), ``density`` (B,).

    The integral over all values is 1; where the edges leave values out it is the share inside.
    """

    edges: Floats
    density: Floats


@dataclass(frozen=True)
class Population:
    """One row of G07 table VI for one sign of N.

    ``coordination`` = 2 n / N_grains; ``share`` of all interactions; ``mean`` = <|N|>; ``quadratic`` = sqrt(<N^2>)
    [F0]. Without members: zeros.
    """

    coordination: float
    share: float
    mean: float
    quadratic: float


@dataclass(frozen=True)
class Populations:
    """Interactions by sign of the normal force (G07 table VI and sec. IV A).

    ``repulsive`` N >= tol, ``tensile`` N <= -tol, ``vanishing`` |N| < tol: their coordination numbers z+, z-, z0 add
    up to z. ``unstressed``: share with vanishing total force, ||F|| < tol (no tangential part either).  ``strong``:
    share with |N| above the strong threshold (F0/10 in the paper).
    """

    repulsive: Population
    tensile: Population
    vanishing: Population
    unstressed: float
    strong: float


@dataclass(frozen=True)
class NTScatter:
    """The N-T plane of G07 figs. 14 and 17, forces in units of F0.

    ``normal_edges`` (B + 1,), ``tangential_edges`` (C + 1,), ``density`` (B, C).  ``cone`` (3, 2): the Coulomb limit
    |T| = mu (N + f0) as a polyline (N, T), tip at N = -f0 (f0 = 1, or 0 without cohesion); ``sqrt3_lines`` (2, 2, 2): the two
    lines T = +-sqrt(3) N by their end points (N, T).
    """

    normal_edges: Floats
    tangential_edges: Floats
    density: Floats
    cone: Floats
    sqrt3_lines: Floats


@dataclass(frozen=True)
class Triangles:
    """Triples of mutually interacting discs: ``grains`` (K, 3) rows, ascending; ``ratio`` (K, 3).

    ``ratio[:, c]`` = |T/N| of eq. 20 on disc c when its two forces balance: sqrt(R (R + R1 + R2) / (R1 R2)), R its
    radius.
    """

    grains: Ints
    ratio: Floats


@dataclass(frozen=True)
class Corners:
    """Discs held by two touching discs alone: ``grains`` (K, 3) rows of the disc D and of the two (G07 fig. 16);
    ``force`` (K,) the smaller of its two forces, largest first; ``ratio`` (K,) = |T/N| of eq. 20."""

    grains: Ints
    force: Floats
    ratio: Floats


def normal_force_distribution(frame: Frame, edges: Floats, *, unit: float | None) -> Histogram:
    """Probability density of N / unit over all interactions (G07 figs. 9, 10).

    ``unit`` [force]: F0; None takes the mean elastic part of the contacts, <N_e>, as in fig. 9(a): without cohesion
    that is the mean force, with cohesion at low pressure it is close to F0 (the mean of N itself is then near zero).
    """
    if unit is None:
        unit = (
            float(frame.interactions.elastic[frame.interactions.in_contact].mean())
            if frame.interactions.in_contact.any()
            else 0.0
        )
    return _histogram(frame.interactions.normal_force / _positive("unit", unit), edges)


def force_populations(frame: Frame, *, unit: float, tolerance: float = 1e-4, strong: float = 0.1) -> Populations:
    """Populations of table VI; ``unit`` [force] is F0, ``tolerance`` and ``strong`` are in units of it."""
    normal = frame.interactions.normal_force / _positive("unit", unit)
    magnitude = force_magnitude(frame) / unit

    def population(rows: Bools) -> Population:
        members = np.abs(normal[rows])
        mean = float(members.mean()) if len(members) else 0.0
        quadratic = float(np.sqrt((members**2).mean())) if len(members) else 0.0
        return Population(2.0 * len(members) / frame.grains, _share(rows), mean, quadratic)

    return Populations(
        repulsive=population(normal >= tolerance),
        tensile=population(normal <= -tolerance),
        vanishing=population(np.abs(normal) < tolerance),
        unstressed=_share(magnitude < tolerance),
        strong=_share(np.abs(normal) > strong),
    )


def nt_scatter(
    frame: Frame, normal_edges: Floats, tangential_edges: Floats, *, unit: float, friction: float, cohesive: bool = True
) -> NTScatter:
    """Density of the interactions in the plane (N, T)/unit, Coulomb cone of ``friction`` = mu (figs. 14, 17)."""
    scale, rows = _positive("unit", unit), len(frame.interactions)
    x, y = np.asarray(normal_edges, dtype=np.float64), np.asarray(tangential_edges, dtype=np.float64)
    counts = np.histogram2d(frame.interactions.normal_force / scale, frame.interactions.tangential / scale, (x, y))[0]
    density = counts / (max(rows, 1) * np.outer(np.diff(x), np.diff(y)))
    tip = -1.0 if cohesive else 0.0
    limit = friction * (x[-1] - tip)
    cone = np.array([[x[-1], limit], [tip, 0.0], [x[-1], -limit]])
    cross = np.array([[[x[0], s * x[0]], [x[-1], s * x[-1]]] for s in (np.sqrt(3.0), -np.sqrt(3.0))])
    return NTScatter(x, y, density, cone, cross)


def force_angles(frame: Frame, edges: Floats, *, tolerance: float) -> Histogram:
    """Probability density of the angle between the force and n in degrees, theta = atan2(|T|, N) in 0..180 (fig. 15).

    0: repulsive, 180: tensile, both with T = 0.  Interactions with ||F|| <= ``tolerance`` [force] have no direction
    and are left out.
    """
    contacts, rows = frame.interactions, force_magnitude(frame) > tolerance
    return _histogram(np.degrees(np.arctan2(np.abs(contacts.tangential), contacts.normal_force))[rows], edges)


def triangles(frame: Frame) -> Triangles:
    """All triples of mutually interacting discs with the force ratio that eq. 20 predicts on each of them."""
    contacts, size = frame.interactions, frame.grains
    low, high = np.minimum(contacts.i, contacts.j), np.maximum(contacts.i, contacts.j)
    offset = image_offsets(frame) * np.where(contacts.i < contacts.j, 1, -1)[:, None]
    order = np.lexsort((high, low))
    low, high, offset = low[order], high[order], offset[order]
    upper = coo_array((np.ones(len(low), dtype=np.int8), (low, high)), shape=(size, size)).tocsr()
    side, third = upper[low].multiply(upper[high]).nonzero()  # third is beyond both ends: each triple once
    key = low * size + high
    long, last = np.searchsorted(key, low[side] * size + third), np.searchsorted(key, high[side] * size + third)
    closed = (offset[side] + offset[last] == offset[long]).all(axis=1)  # and does not wind around a small cell
    grains = np.column_stack((low[side], high[side], third))[closed].astype(np.int64)
    radius = 0.5 * frame.diameter[grains]
    ratio = np.sqrt(radius**2 * radius.sum(axis=1, keepdims=True) / radius.prod(axis=1, keepdims=True))
    found = np.lexsort(grains.T[::-1])
    return Triangles(grains[found], ratio[found])


def corners(frame: Frame, *, tolerance: float) -> Corners:
    """Corners of `triangles` at which the two forces of the triangle, ||F|| > ``tolerance`` [force], are all that the disc
    feels, so that they balance along the line through its two contacts (G07 sec. IV B 3)."""
    found, size, table = triangles(frame), force_magnitude(frame), frame.interactions
    strong = size > tolerance
    number = np.bincount(np.concatenate((table.i[strong], table.j[strong])), minlength=frame.grains)
    pair = np.minimum(table.i, table.j) * frame.grains + np.maximum(table.i, table.j)
    order = np.argsort(pair)

    def between(one: Ints, two: Ints) -> Floats:
        key = np.minimum(one, two) * frame.grains + np.maximum(one, two)
        return np.asarray(size[order[np.searchsorted(pair[order], key)]])

    turned = [np.roll(found.grains, -k, axis=1) for k in range(3)]
    grains, ratio = np.concatenate(turned), np.concatenate([found.ratio[:, k] for k in range(3)])
    force = np.minimum(between(grains[:, 0], grains[:, 1]), between(grains[:, 0], grains[:, 2]))
    kept = np.flatnonzero((number[grains[:, 0]] == 2) & (force > tolerance))
    kept = kept[np.argsort(-force[kept], kind="stable")]
    return Corners(grains[kept], force[kept], ratio[kept])


def fabric(frame: Frame, rows: NDArray | None = None) -> Floats:
    """Fabric tensor <n_a n_b> over the interactions in ``rows`` (None: all), (2, 2), trace 1; zeros without any."""
    normal = frame.interactions.normal if rows is None else frame.interactions.select(rows).normal
    return normal.T @ normal / max(len(normal), 1)


def _histogram(values: Floats, edges: Floats) -> Histogram:
    edges = np.asarray(edges, dtype=np.float64)
    if edges.ndim != 1 or len(edges) < 2 or not (np.diff(edges) > 0).all():
        raise InputError(f"edges = {edges} must be at least two ascending numbers; try numpy.linspace")
    counts = np.histogram(values, edges)[0]
    return Histogram(edges, counts / (max(len(values), 1) * np.diff(edges)))


def _share(rows: Bools) -> float:
    return float(rows.mean()) if len(rows) else 0.0


def _positive(name: str, value: float) -> float:
    if not (np.isfinite(value) and value > 0.0):
        raise InputError(f"{name} = {value} must be a finite force above 0; give F0, or a P without cohesion")
    return value

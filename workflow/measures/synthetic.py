"""Aggregates made by geometry alone, as test objects of known fractal dimension."""

from __future__ import annotations

import numpy as np

from workflow.data.frame import Floats, Ints
from workflow.errors import InputError

TRIES = 64  # pairs drawn at a time, of which the first that passes is shot


def ballistic_aggregate(grains: int, rng: np.random.Generator, *, equal: bool = False) -> Floats:
    """Centres (n, 2) of an aggregate of ``grains`` touching unit discs about the origin.

    Ballistic cluster-cluster aggregation: clusters, turned at random, meet on straight lines with random impact parameters
    and stick at the first touch, without rearranging.  Loop-free, so z = 2 - 2/n.  Which two meet next:

    * free flight (default): those that would in a dilute gas, at a rate proportional to their relative speed, sqrt(1/m_1 +
      1/m_2) as in equipartition, and to their cross-section (a shot that misses is no meeting).  Clusters of all sizes
      meet; published d_F = 1.55 +- 0.02 in two dimensions (G07 refs. 39, 89).
    * ``equal``: clusters of equal size only (n a power of two), the hierarchical model, which is less dense.

    What both give here stands in validation/fractals.
    """
    if grains < 1 or (equal and grains & (grains - 1)):
        raise InputError(f"grains = {grains} is not allowed; give 1 or more, with equal=True a power of two")
    clusters = [np.zeros((1, 2)) for _ in range(grains)]
    if not equal:
        return _free_flight(clusters, rng)
    while len(clusters) > 1:
        clusters = [_collide(one, two, rng) for one, two in zip(clusters[::2], clusters[1::2], strict=True)]
    return clusters[0]


def _free_flight(clusters: list[Floats], rng: np.random.Generator) -> Floats:
    """The aggregate of all ``clusters``, which meet at the rates of free flight."""
    reach, lightness = (np.array([of(cluster) for cluster in clusters]) for of in (_reach, _lightness))
    for left in range(len(clusters), 1, -1):
        first, second, met = _meeting(clusters, reach[:left], lightness[:left], rng)
        clusters[first], reach[first], lightness[first] = met, _reach(met), _lightness(met)
        clusters[second], reach[second], lightness[second] = clusters[left - 1], reach[left - 1], lightness[left - 1]
    return clusters[0]


def _meeting(clusters: list[Floats], reach: Floats, lightness: Floats, rng: np.random.Generator) -> tuple[int, int, Floats]:
    """The next two that meet, the first before the second, and what they become: drawn by a bound of their rate, then shot."""
    fastest = 2.0 * reach.max() * np.sqrt(2.0 * lightness.max())
    while True:
        i, j = rng.integers(len(reach), size=(2, TRIES))
        rate = (reach[i] + reach[j]) * np.sqrt(lightness[i] + lightness[j])
        passed = np.flatnonzero((i != j) & (rng.uniform(size=TRIES) * fastest < rate))
        if len(passed):
            first, second = sorted((int(i[passed[0]]), int(j[passed[0]])))
            width = reach[first] + reach[second]
            met = _shoot(_turned(clusters[first], rng), _turned(clusters[second], rng), rng.uniform(-width, width))
            if met is not None:
                return first, second, met


def _lightness(cluster: Floats) -> float:
    """1/m, the mean square speed in equipartition."""
    return 1.0 / len(cluster)


def _reach(cluster: Floats) -> float:
    """Radius of the circle about the centre of mass that holds all discs."""
    return float(np.sqrt((cluster**2).sum(axis=1).max())) + 0.5


def _collide(one: Floats, two: Floats, rng: np.random.Generator) -> Floats:
    """Two clusters that do meet; misses are shot again."""
    width = _reach(one) + _reach(two)
    while True:
        met = _shoot(_turned(one, rng), _turned(two, rng), rng.uniform(-width, width))
        if met is not None:
            return met


def _shoot(target: Floats, bullet: Floats, height: float) -> Floats | None:
    """``bullet`` flies along -x at ``target`` until a pair of discs touches, both about their centres; None if it misses."""
    target = target[np.argsort(target[:, 1])]
    shot = bullet + np.array([0.0, height])
    a, b = _same_height(target[:, 1], shot[:, 1])
    if not len(a):
        return None
    stop = target[a, 0] + np.sqrt(1.0 - (target[a, 1] - shot[b, 1]) ** 2) - shot[b, 0]
    met = np.vstack((target, shot + np.array([stop.max(), 0.0])))
    return met - met.mean(axis=0)


def _same_height(ascending: Floats, heights: Floats) -> tuple[Ints, Ints]:
    """Pairs (row of ``ascending``, row of ``heights``) less than 1 apart."""
    first = np.searchsorted(ascending, heights - 1.0, "right")
    count = np.searchsorted(ascending, heights + 1.0, "left") - first
    b = np.repeat(np.arange(len(heights)), count)
    return np.arange(len(b)) - np.repeat(np.cumsum(count) - count, count) + first[b], b


def _turned(points: Floats, rng: np.random.Generator) -> Floats:
    c, s = np.cos(t := rng.uniform(0.0, 2.0 * np.pi)), np.sin(t)
    return points @ np.array([[c, -s], [s, c]])

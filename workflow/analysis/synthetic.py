"""Aggregates made by geometry alone, as test objects of known fractal dimension."""

from __future__ import annotations

import numpy as np

from workflow.analysis.frame import Floats, Ints
from workflow.errors import InputError


def ballistic_aggregate(grains: int, rng: np.random.Generator) -> Floats:
    """Centres (n, 2) of an aggregate of touching unit discs, n = ``grains`` a power of two, about the origin.

    Ballistic cluster-cluster aggregation: clusters of equal size, turned at random, meet on straight lines with random
    impact parameters and stick at the first touch, without rearranging.  Loop-free, so z = 2 - 2/n.  Published: d_F =
    1.55 +- 0.02 in two dimensions (G07 refs. 39, 89); measured here from R_g of 16 to 4096 discs: 1.51 +- 0.02.
    """
    if grains < 1 or grains & (grains - 1):
        raise InputError(f"grains = {grains} is no power of two; give 1, 2, 4, ...")
    clusters = [np.zeros((1, 2)) for _ in range(grains)]
    while len(clusters) > 1:
        clusters = [_collide(one, two, rng) for one, two in zip(clusters[::2], clusters[1::2], strict=True)]
    return clusters[0] - clusters[0].mean(axis=0)


def _collide(target: Floats, bullet: Floats, rng: np.random.Generator) -> Floats:
    """Shoot ``bullet`` along -x at ``target`` until a pair of discs touches; misses are shot again."""
    target, bullet = _turned(target, rng), _turned(bullet, rng)
    target = target[np.argsort(target[:, 1])]
    low, high = target[0, 1] - bullet[:, 1].max() - 1.0, target[-1, 1] - bullet[:, 1].min() + 1.0
    while True:
        shot = bullet + np.array([0.0, rng.uniform(low, high)])
        a, b = _same_height(target[:, 1], shot[:, 1])
        if len(a):
            stop = target[a, 0] + np.sqrt(1.0 - (target[a, 1] - shot[b, 1]) ** 2) - shot[b, 0]
            return np.vstack((target, shot + np.array([stop.max(), 0.0])))


def _same_height(ascending: Floats, heights: Floats) -> tuple[Ints, Ints]:
    """Pairs (row of ``ascending``, row of ``heights``) less than 1 apart."""
    first = np.searchsorted(ascending, heights - 1.0, "right")
    count = np.searchsorted(ascending, heights + 1.0, "left") - first
    b = np.repeat(np.arange(len(heights)), count)
    return np.arange(len(b)) - np.repeat(np.cumsum(count) - count, count) + first[b], b


def _turned(points: Floats, rng: np.random.Generator) -> Floats:
    c, s = np.cos(t := rng.uniform(0.0, 2.0 * np.pi)), np.sin(t)
    return (points - points.mean(axis=0)) @ np.array([[c, -s], [s, c]])

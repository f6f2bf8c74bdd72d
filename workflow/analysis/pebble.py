"""Rigid clusters of frictional discs by a (3,3) pebble game: counting only, no coordinates.

Every grain has three degrees of freedom; a sticking contact is two bars, a sliding contact or a distant pair one, a
contact with rolling resistance three.  A set of n grains is rigid if it holds 3n - 3 independent bars.  Counting is
exact for generic networks (Tay's theorem on bodies and bars; Henkes, Quint, Fily, Schwarz, PRL 116, 028001, 2016).
It knows neither the geometry (aligned chains, networks whose loops are all even and counter-rotate) nor the wrapping
of the cell: a cluster that winds around it counts as free to rotate.  The matrix rank in ``rigidity`` has none of
these limits.

Rigid sets that share a grain merge, so they form a partition of the grains: a set found rigid is contracted into one
body with three free pebbles, and no failed search ever looks at it again (total failed work is linear).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workflow.analysis.frame import Frame, Ints
from workflow.errors import InputError

PEBBLES = 3  # degrees of freedom of a body, and of a rigid motion


@dataclass(frozen=True)
class RigidClusters:
    """Partition of the grains into rigid clusters, largest first (ties: smallest grain row first).

    ``grains`` (N,) int64: cluster of every grain (a cluster may be a single grain); ``contacts`` (interactions,)
    int64: cluster of an interaction whose grains belong to the same one, else -1 (a hinge); ``redundant`` (clusters,)
    int64: bars beyond those that make the cluster rigid, its count of H; ``independent``: number of independent bars,
    the rank.
    """

    grains: Ints
    contacts: Ints
    redundant: Ints
    independent: int

    @property
    def sizes(self) -> Ints:
        """Grains per cluster, (clusters,) int64."""
        return np.bincount(self.grains, minlength=len(self.redundant))


def rigid_clusters(frame: Frame, *, rolling: bool = False) -> RigidClusters:
    """Rigid clusters of ``frame`` with friction: see ``RigidClusters``; ``rolling`` adds rolling resistance.

    Sliding contacts (``contacts.sliding``) keep the normal bar only, contacts at the rolling limit lose the rolling
    bar. Raises InputError for a frame without grains.
    """
    if not frame.grains:
        raise InputError("frame: 0 grains; rigid clusters need at least one, choose another frame")
    pairs = frame.contacts
    bars = 1 + (pairs.touching & ~pairs.sliding) + (rolling & pairs.touching & ~pairs.rolling)
    game = _Game(frame.grains)
    ends = list(zip(pairs.i.tolist(), pairs.j.tolist(), bars.tolist(), strict=True))
    over = np.zeros(frame.grains, dtype=np.int64)
    for first, second, count in ends:
        for _ in range(count):
            over[first] += not game.insert(first, second)
    for first, second, _ in ends:  # a set that became rigid through bars elsewhere has not been looked at yet
        game.is_rigid(first, second)
    bodies = np.array([game.body(grain) for grain in range(frame.grains)])
    roots, seen, label, size = np.unique(bodies, return_index=True, return_inverse=True, return_counts=True)
    rank = np.empty(len(roots), dtype=np.int64)
    rank[np.lexsort((seen, -size))] = np.arange(len(roots))
    grains = rank[label]
    redundant = np.bincount(grains, weights=over, minlength=len(roots)).astype(np.int64)
    inside = grains[pairs.i] == grains[pairs.j]
    return RigidClusters(grains, np.where(inside, grains[pairs.i], -1), redundant, int(bars.sum() - over.sum()))


class _Game:
    """Bodies, their free pebbles, and the bars their other pebbles lie on (directed away from the body)."""

    def __init__(self, grains: int) -> None:
        self.parent = list(range(grains))
        self.free = [PEBBLES] * grains
        self.covers: list[list[int]] = [[] for _ in range(grains)]

    def body(self, grain: int) -> int:
        """Representative of the rigid body of ``grain``."""
        parent = self.parent
        while parent[grain] != grain:
            parent[grain] = grain = parent[parent[grain]]
        return grain

    def insert(self, first: int, second: int) -> bool:
        """Cover a bar with a pebble; False if it is redundant."""
        if self.is_rigid(first, second):
            return False
        a, b = self.body(first), self.body(second)
        giver, taker = (a, b) if self.free[a] else (b, a)
        self.free[giver] -= 1
        self.covers[giver].append(taker)
        return True

    def is_rigid(self, first: int, second: int) -> bool:
        """Whether two grains belong to one rigid body; contracts the body if that is news."""
        a, b = self.body(first), self.body(second)
        while a != b and self.free[a] + self.free[b] <= PEBBLES:
            reached = self._fetch(a, b)
            if reached:
                self._contract(a, reached)
                return True
        return a == b

    def _fetch(self, a: int, b: int) -> list[int]:
        """Bring a free pebble to ``a`` or ``b`` by turning bars around; if there is none, the bodies searched."""
        came_from = {a: -1, b: -1}
        stack = [a, b]
        while stack:
            at = stack.pop()
            for end in self.covers[at]:
                to = self.body(end)
                if to in came_from:
                    continue
                came_from[to] = at
                if self.free[to]:
                    self._reverse(to, came_from)
                    return []
                stack.append(to)
        return list(came_from)

    def _reverse(self, to: int, came_from: dict[int, int]) -> None:
        self.free[to] -= 1
        while came_from[to] >= 0:
            at = came_from[to]
            self.covers[to].append(at)
            self.covers[at] = self._without(self.covers[at], to)
            to = at
        self.free[to] += 1

    def _without(self, ends: list[int], body: int) -> list[int]:
        """``ends`` less one bar that leads to ``body``."""
        index = next(k for k, end in enumerate(ends) if self.body(end) == body)
        return ends[:index] + ends[index + 1 :]

    def _contract(self, a: int, bodies: list[int]) -> None:
        """Merge a rigid set: no bar leaves it, and its three free pebbles are those of a body."""
        for body in bodies:
            self.parent[body] = a
            self.covers[body] = []
        self.free[a] = PEBBLES

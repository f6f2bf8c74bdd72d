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

from array import array
from dataclasses import dataclass

import numpy as np

from workflow.data.frame import Frame, Ints, plain_rows
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
    pairs = frame.interactions
    bars = 1 + (pairs.in_contact & ~pairs.sliding) + (rolling & pairs.in_contact & ~pairs.rolling)
    game = _Game(frame.grains)
    over = np.zeros(frame.grains, dtype=np.int64)
    for first, second, count in plain_rows(pairs.i, pairs.j, bars):
        over[first] += sum(not game.insert(first, second) for _ in range(count))
    for first, second in plain_rows(pairs.i, pairs.j):  # what became rigid through bars elsewhere has not been looked at yet
        game.is_rigid(first, second)
    bodies = game.bodies()
    roots, seen, label, size = np.unique(bodies, return_index=True, return_inverse=True, return_counts=True)
    rank = np.empty(len(roots), dtype=np.int64)
    rank[np.lexsort((seen, -size))] = np.arange(len(roots))
    grains = rank[label]
    redundant = np.bincount(grains, weights=over, minlength=len(roots)).astype(np.int64)
    inside = grains[pairs.i] == grains[pairs.j]
    return RigidClusters(grains, np.where(inside, grains[pairs.i], -1), redundant, int(bars.sum() - over.sum()))


class _Game:
    """Bodies, their free pebbles, and the bars their other pebbles lie on (directed away from the body).

    ``bars`` has three places a body, of which the first ``PEBBLES - free`` hold the bodies at the other ends.  Arrays of the
    standard library: their single elements are read ten times as fast as NumPy's.
    """

    def __init__(self, grains: int) -> None:
        self.parent = array("i", range(grains))
        self.free = array("b", [PEBBLES]) * grains
        self.bars = array("i", [-1]) * (PEBBLES * grains)
        self.came_from = array("i", [-1]) * grains  # in a search: the body before; -1 outside of it

    def body(self, grain: int) -> int:
        """Representative of the rigid body of ``grain``."""
        parent = self.parent
        while parent[grain] != grain:
            parent[grain] = grain = parent[parent[grain]]
        return grain

    def bodies(self) -> Ints:
        """Representatives of the bodies of all grains."""
        parent = np.array(self.parent)
        while np.any(parent != parent[parent]):
            parent = parent[parent]
        return parent

    def insert(self, first: int, second: int) -> bool:
        """Cover a bar with a pebble; False if it is redundant."""
        if self.is_rigid(first, second):
            return False
        a, b = self.body(first), self.body(second)
        giver, taker = (a, b) if self.free[a] else (b, a)
        self.bars[self._end(giver)] = taker
        self.free[giver] -= 1
        return True

    def is_rigid(self, first: int, second: int) -> bool:
        """Whether two grains belong to one rigid body; contracts the body if that is news."""
        a, b = self.body(first), self.body(second)
        while a != b and self.free[a] + self.free[b] <= PEBBLES:
            reached = array("i", [a, b])
            fetched = self._fetch(reached)
            for body in reached:
                self.came_from[body] = -1
            if not fetched:
                self._contract(a, reached)
                return True
        return a == b

    def _end(self, body: int) -> int:
        """Place behind the bars of ``body``."""
        return PEBBLES * (body + 1) - self.free[body]

    def _fetch(self, reached: array[int]) -> bool:
        """Bring a free pebble to one of two bodies, ``reached``, by turning bars around, if possible; adds those searched."""
        came_from = self.came_from
        for at in reached:
            came_from[at] = at
        for at in reached:  # grows
            for end in self.bars[PEBBLES * at : self._end(at)]:
                to = self.body(end)
                if came_from[to] < 0:
                    came_from[to] = at
                    reached.append(to)
                    if self.free[to]:
                        self._reverse(to)
                        return True
        return False

    def _reverse(self, to: int) -> None:
        """Turn the bars on the way to ``to``, whose free pebble becomes one of the body where the search began."""
        place = self._end(to)
        self.free[to] -= 1
        while (at := self.came_from[to]) != to:
            self.bars[place] = at
            place = next(k for k in range(PEBBLES * at, self._end(at)) if self.body(self.bars[k]) == to)
            to = at
        self.free[to] += 1
        self.bars[place] = self.bars[self._end(to)]  # no gap

    def _contract(self, a: int, bodies: array[int]) -> None:
        """Merge a rigid set: no bar leaves it, and its three free pebbles are those of a body."""
        for body in bodies:
            self.parent[body] = a
        self.free[a] = PEBBLES

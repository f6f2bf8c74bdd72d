"""Percolation means winding around the periodic cell; clusters and loops of known networks come out exactly."""

from dataclasses import replace

import numpy as np
import pytest
from networks import network

from workflow.data.frame import Frame
from workflow.errors import InputError
from workflow.measures.percolation import network_clusters, percolation, stressed_clusters


def square(side: int, force=None) -> Frame:
    """Square lattice side x side, grain row = side * x + y; bonds along axis 1 first, then along axis 2."""
    x, y = (a.ravel() for a in np.mgrid[:side, :side])
    row = side * x + y
    pairs = np.vstack((np.column_stack((row, side * ((x + 1) % side) + y)), np.column_stack((row, side * x + (y + 1) % side))))
    return network(np.column_stack((x, y)), (side, side), pairs, np.ones(len(pairs)) if force is None else force)


def moved(frame: Frame, shift) -> Frame:
    """The same frame, all grains shifted and wrapped into the cell."""
    return replace(frame, position=(frame.position + shift) % frame.cell)


def twin(frame: Frame) -> list[float | None]:
    """Thresholds by adding interactions in decreasing force to breadth-first searches from scratch (slow, obvious)."""
    c = frame.interactions
    magnitude = np.hypot(c.normal_force, c.tangential)
    found: list[float | None] = [None, None]
    for value in np.sort(np.unique(magnitude))[::-1]:
        bonds: dict[int, list] = {g: [] for g in range(frame.grains)}
        for k in np.flatnonzero(magnitude >= value):
            bonds[c.i[k]].append((c.j[k], c.branch[k]))
            bonds[c.j[k]].append((c.i[k], -c.branch[k]))
        place: dict[int, np.ndarray] = {}
        for start in range(frame.grains):
            if start in place:
                continue
            place[start], todo = np.zeros(2), [start]
            while todo:
                here = todo.pop()
                for there, branch in bonds[here]:
                    reached = place[here] + branch
                    if there not in place:
                        place[there] = reached
                        todo.append(there)
                    for axis in np.flatnonzero(np.abs(reached - place[there]) > 0.5):
                        found[axis] = value if found[axis] is None else found[axis]
    return found


def random_network(seed: int) -> Frame:
    rng = np.random.default_rng(seed)
    position, cell = rng.uniform(0, 5, (40, 2)), np.array([5.0, 5.0])
    i, j = np.triu_indices(40, 1)
    branch = position[j] - position[i]
    branch -= cell * np.rint(branch / cell)
    near = np.hypot(*branch.T) < 1.1
    return network(position, cell, np.column_stack((i, j))[near], rng.permutation(near.sum()) + 1.0)


def test_threshold_is_the_best_bottleneck_of_the_rows():
    """Rows along axis 1 only, weakest bond of row y is w[y]: the best row decides, axis 2 never winds."""
    side, weakest = 5, np.array([0.3, 0.7, 0.1, 0.6, 0.2])
    rng = np.random.default_rng(0)
    force = np.concatenate((rng.uniform(1, 2, side * side), np.zeros(side * side)))
    force[: side * side].reshape(side, side)[2] = weakest
    lattice = square(side, force)
    rows = network(
        lattice.position,
        lattice.cell,
        np.column_stack((lattice.interactions.i, lattice.interactions.j))[: side * side],
        force[: side * side],
    )
    assert percolation(rows).axis == (0.7, None)
    assert percolation(rows).any == 0.7


def test_spanning_chain_does_not_percolate():
    """A chain that reaches from edge to edge but leaves one gap does not wind; closing the gap makes it."""
    x = np.arange(6.0)
    pairs = np.column_stack((np.arange(6), (np.arange(6) + 1) % 6))
    place = np.column_stack((x, np.full(6, 2.0)))
    assert percolation(network(place, (6, 6), pairs[:-1], np.ones(5))).any is None
    assert percolation(network(place, (6, 6), pairs, np.ones(6))).axis == (1.0, None)


def test_diagonal_chain_winds_around_both_axes():
    x = np.arange(6.0)
    pairs = np.column_stack((np.arange(6), (np.arange(6) + 1) % 6))
    assert percolation(network(np.column_stack((x, x)), (6, 6), pairs, np.arange(6) + 1.0)).axis == (1.0, 1.0)


def test_total_force_counts_not_the_normal_part():
    frame = square(3)
    sheared = replace(frame, interactions=replace(frame.interactions, tangential=np.full(18, np.sqrt(3.0))))
    assert percolation(sheared).any == pytest.approx(2.0, rel=1e-15)  # rounding of one square root


@pytest.mark.parametrize("seed", range(6))
def test_random_networks_agree_with_the_search_from_scratch(seed):
    frame = random_network(seed)
    assert list(percolation(frame).axis) == twin(frame)


def test_translation_relabelling_and_direction_change_nothing():
    frame = random_network(3)
    rng = np.random.default_rng(1)
    order, c = rng.permutation(frame.grains), frame.interactions
    inverse = np.argsort(order)
    relabelled = network(
        frame.position[order], frame.cell, np.column_stack((inverse[c.j], inverse[c.i]))[::-1], c.elastic[::-1]
    )
    expected = percolation(frame)
    assert percolation(moved(frame, (1.7, 4.1))) == expected
    assert percolation(relabelled) == expected
    quarter = network(
        frame.position[:, ::-1] * [-1, 1], frame.cell[::-1], np.column_stack((c.i, c.j)), c.elastic
    )  # rotated by 90 degrees
    assert percolation(quarter).axis == expected.axis[::-1]


def test_empty_network_never_percolates():
    frame = network([[0.5, 0.5]], (3, 3), [], [])
    assert percolation(frame).axis == (None, None)
    assert len(network_clusters(frame).grains) == 0
    assert network_clusters(frame, singles=True).grains.tolist() == [1]


def test_loops_of_the_periodic_square_lattice():
    """V = n^2, E = 2 n^2: n^2 + 1 independent loops, two of them around the cell."""
    clusters = network_clusters(square(7))
    assert (clusters.grains.tolist(), clusters.interactions.tolist(), clusters.loops.tolist()) == ([49], [98], [50])
    assert clusters.wraps.tolist() == [[True, True]]


def test_stressed_clusters_are_ordered_and_hold_their_loops():
    """A double triangle (4 grains, 5 bonds, 2 loops) and a stressed pair in a wide cell; the rest carries nothing."""
    h = np.sqrt(0.75)
    place = [[5, 5], [5.9, 5], [0.0, 0.0], [1, 0], [0.5, h], [0.5, -h], [3, 3], [4, 3]]
    pairs = [[0, 1], [2, 3], [2, 4], [3, 4], [2, 5], [3, 5], [6, 7]]
    frame = network(place, (9, 9), pairs, [-2, 1, 1, -1, 1, 1, 1e-6])
    clusters = stressed_clusters(frame, 1e-4)
    assert clusters.label.tolist() == [1, 1, 0, 0, 0, 0, -1, -1]
    assert clusters.loops.tolist() == [2, 0]
    assert not clusters.wraps.any()
    unwrapped = frame.position + clusters.image * frame.cell
    assert np.ptp(unwrapped[2:6, 1]) == pytest.approx(2 * h)  # in one piece although it crosses the edge


def test_branch_that_does_not_fit_the_positions_is_refused():
    frame = square(3)
    frame.interactions.branch[4] += 0.25
    with pytest.raises(InputError, match="differs from their separation"):
        percolation(frame)

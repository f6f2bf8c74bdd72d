"""Aggregates in one piece across the cell's edge, rattler-free coordination, g(r) of lattices and by brute force."""

import numpy as np
import pytest
from networks import network

from workflow.data.frame import Frame
from workflow.errors import InputError
from workflow.measures.clusters import aggregates, local_coordination, pair_correlation


def triangular(side: int) -> Frame:
    x, y = (a.ravel() for a in np.mgrid[:side, :side])
    place = np.column_stack((x + 0.5 * (y % 2), y * np.sqrt(0.75)))
    return network(place, (side, side * np.sqrt(0.75)), [])


def test_aggregate_across_the_edge_keeps_its_shape():
    """Masses 3 and 1 at distance 1 across the edge: centre 1/4 from the heavy one, gyration sqrt(3)/4."""
    frame = network([[-0.9, 3], [8.9 + 0.2 - 0.2 - 0.8, 3], [4, 4]], (10, 10), [[0, 1]], mass=[3.0, 1.0, 1.0])
    found = aggregates(frame)
    assert found.clusters.grains.tolist() == [2, 1]
    assert found.clusters.label.tolist() == [0, 0, 1]
    assert found.gyration == pytest.approx([np.sqrt(3.0) / 4.0, 0.0], abs=1e-12)  # rounding of coordinates of order 10
    assert found.centre[0] == pytest.approx([-0.9 - 0.25 + 10.0, 3.0], abs=1e-12)  # wrapped into [-1, 9) x [2, 12)
    assert found.mass.tolist() == [4.0, 1.0]


def test_endless_aggregate_has_no_centre():
    frame = network([[x, 3.0] for x in range(5)], (5, 9), [[k, (k + 1) % 5] for k in range(5)])
    found = aggregates(frame)
    assert found.clusters.wraps.tolist() == [[True, False]]
    assert np.isnan(found.gyration).all()
    assert np.isnan(found.centre).all()


@pytest.mark.parametrize("direction", [1, -1])
def test_rattlers_are_peeled_off_one_after_the_other(direction):
    """A triangle with a tail of three: cohesionless, the tail falls off grain by grain; cohesive, it holds."""
    pairs = np.array([[0, 1], [1, 2], [2, 0], [2, 3], [3, 4], [4, 5]])[:, ::direction]
    frame = network(np.random.default_rng(0).uniform(0, 3, (7, 2)), (9, 9), pairs)
    assert local_coordination(frame, least=2).tolist() == [2, 2, 2, 0, 0, 0, 0]
    assert local_coordination(frame, least=1).tolist() == [2, 2, 3, 2, 2, 1, 0]


def test_contacts_without_force_do_not_support_a_grain():
    pairs, force = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3]], [1.0, 1.0, 1.0, 1.0, 1e-6]
    frame = network(np.random.default_rng(0).uniform(0, 3, (4, 2)), (9, 9), pairs, force)
    assert local_coordination(frame, least=2, tolerance=1e-4).tolist() == [2, 2, 2, 0]
    assert local_coordination(frame, least=2).tolist() == [3, 3, 2, 2]


def test_pair_correlation_of_the_triangular_lattice_counts_its_shells():
    """Neighbours at 1 (6), sqrt 3 (6), 2 (6), sqrt 7 (12) and none between; g x ring area x density is their number."""
    frame = triangular(20)
    edges = np.array([0.0, 0.9, 1.1, 1.6, 1.8, 1.9, 2.1, 2.6, 2.7])
    g = pair_correlation(frame, edges).g
    number = g * np.pi * np.diff(edges**2) * frame.grains / frame.area
    assert number == pytest.approx([0, 6, 0, 6, 0, 6, 0, 12], abs=1e-9)  # whole numbers up to rounding of the division


def test_pair_correlation_agrees_with_all_pairs_and_with_no_correlation():
    rng = np.random.default_rng(2)
    frame = network(rng.uniform(-30, 30, (800, 2)), (12.0, 17.0), [])
    edges = np.linspace(0, 6, 13)
    d = frame.position[:, None] - frame.position[None]
    d -= frame.cell * np.rint(d / frame.cell)
    counts = np.histogram(np.hypot(*np.moveaxis(d, -1, 0))[~np.eye(800, dtype=bool)], edges)[0]
    g = pair_correlation(frame, edges).g
    assert g == pytest.approx(counts * frame.area / (800**2 * np.pi * np.diff(edges**2)), rel=1e-12)  # same counts
    # counts of independent pairs are Poisson: each bin holds 2 n pairs, so 5 standard errors of g
    assert (np.abs(g - 1.0) < 5.0 * np.sqrt(2.0 / counts)).all()


def test_pair_correlation_refuses_more_than_half_the_cell():
    with pytest.raises(InputError, match="half the cell"):
        pair_correlation(triangular(6), np.linspace(0, 4, 5))

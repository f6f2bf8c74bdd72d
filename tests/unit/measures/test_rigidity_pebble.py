"""The pebble game against matrix ranks on generic networks, and by inspection on small clusters."""

from dataclasses import replace

import numpy as np
import pytest
from networks import double_triangle, frame_of, packing, row, square, strip, together

from workflow.data.contact_law import ContactLaw
from workflow.errors import InputError
from workflow.measures.network import degrees, rigidity_matrix
from workflow.measures.pebble import rigid_clusters
from workflow.measures.rigidity import rigidity


@pytest.mark.parametrize("seed", range(12))
def test_independent_bars_are_the_rank_of_generic_networks(seed):
    frame = packing(20 + 10 * seed, [0.45, 0.6, 0.7, 0.84][seed % 4], seed, open_cell=True)
    for rolling in (False, True):
        book = degrees(frame, friction=True, rolling=rolling)
        # Singular values of these networks are above 1e-5 or below 1e-14.
        rank = np.linalg.matrix_rank(rigidity_matrix(frame, book).toarray(), tol=1e-9)
        clusters = rigid_clusters(frame, rolling=rolling)
        assert clusters.independent == rank
        assert clusters.redundant.sum() == book.rows - rank


@pytest.mark.parametrize("seed", range(4))
def test_sliding_contacts_count_once(seed):
    """Against the rank without the tangential rows of the sliding contacts, a tenth of all."""
    frame = packing(60, 0.84, seed, open_cell=True)
    sliding = np.random.default_rng(seed).random(len(frame.interactions)) < 0.1
    frame = replace(frame, interactions=replace(frame.interactions, sliding=sliding))
    kept = np.concatenate((np.ones(len(sliding), dtype=bool), ~sliding))
    matrix = rigidity_matrix(frame, degrees(frame, friction=True)).toarray()[kept]
    assert rigid_clusters(frame).independent == np.linalg.matrix_rank(matrix, tol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_clusters_are_the_largest_sets_that_move_as_one(seed):
    """Two grains are in one cluster exactly if all floppy modes move them as one rigid body (dense null space)."""
    frame = packing(40, 0.6, seed, open_cell=True)
    matrix = rigidity_matrix(frame, degrees(frame, friction=True)).toarray()
    rank = np.linalg.matrix_rank(matrix, tol=1e-9)
    motions = np.linalg.svd(matrix)[2][rank:].reshape(-1, frame.grains, 3)
    offset = frame.position[:, None] - frame.position[None, :]
    turned = np.stack((-offset[..., 1], offset[..., 0]), axis=-1)
    relative = motions[:, :, None, :2] - motions[:, None, :, :2] - motions[:, None, :, 2:] * turned
    omega = motions[:, :, None, 2] - motions[:, None, :, 2]
    together = (np.abs(relative).max(axis=(0, 3)) < 1e-8) & (np.abs(omega).max(axis=0) < 1e-8)  # else of order 1e-2
    label = rigid_clusters(frame).grains
    np.testing.assert_array_equal(label[:, None] == label[None, :], together)


def test_small_clusters_are_those_known():
    clusters = rigid_clusters(together(row(3), double_triangle(), strip(30)))
    np.testing.assert_array_equal(clusters.sizes, [30, 4, 1, 1, 1])
    np.testing.assert_array_equal(clusters.redundant, [2 * 57 - 87, 1, 0, 0, 0])
    np.testing.assert_array_equal(clusters.grains[:7], [2, 3, 4, 1, 1, 1, 1])
    np.testing.assert_array_equal(clusters.contacts[:3], [-1, -1, 1])


def test_two_triangles_joined_by_one_contact_hinge_there():
    position = np.array([(0, 0), (1, 0), (0.5, 0.75**0.5), (2, 0), (3, 0), (2.5, 0.75**0.5)])
    i, j = np.array([(0, 1), (0, 2), (1, 2), (1, 3), (3, 4), (3, 5), (4, 5)]).T
    frame = frame_of(position, 1.0, 50.0, i, j, position[j] - position[i])
    clusters = rigid_clusters(frame)
    np.testing.assert_array_equal(clusters.contacts, [0, 0, 0, -1, 1, 1, 1])
    assert rigid_clusters(frame, rolling=True).sizes.tolist() == [6]


def test_counting_overlooks_the_counter_rotation_of_even_loops():
    """The documented limit: on a square lattice the matrix finds a mechanism that no count of bars can see."""
    frame = square(6)
    result = rigidity(frame, law=ContactLaw(1.0, 1.0))
    assert rigid_clusters(frame).sizes[0] == frame.grains
    assert result.mechanisms == 1


def test_sample_of_the_paper_in_a_blink():
    """1400 grains near the rigidity transition take 0.04 s; a quadratic search would take seconds."""
    frame = packing(1400, 0.66, 1)
    assert rigid_clusters(frame).redundant.sum() == rigidity(frame, law=ContactLaw(1.0, 1.0)).hyperstaticity


def test_a_frame_without_grains_is_refused():
    with pytest.raises(InputError, match="0 grains"):
        rigid_clusters(frame_of(np.zeros((0, 2)), 1.0, 1.0, [], [], []))

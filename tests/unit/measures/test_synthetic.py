import numpy as np
import pytest
from networks import aggregate

from workflow.data.build import make_frame, pairs_in_contact
from workflow.errors import InputError
from workflow.measures.percolation import network_clusters
from workflow.measures.synthetic import _meeting, ballistic_aggregate


@pytest.mark.parametrize("equal", [False, True])
@pytest.mark.parametrize("grains", [1, 2, 64, 512])
def test_a_ballistic_aggregate_is_one_tree_of_discs_that_touch(grains, equal):
    centre = ballistic_aggregate(grains, np.random.default_rng(grains), equal=equal)
    assert centre.mean(axis=0) == pytest.approx([0.0, 0.0], abs=1e-10)
    cell = np.array([2000.0, 2000.0])
    overlaps, _ = pairs_in_contact(centre, np.full(grains, 1.0 - 1e-9), cell)
    assert len(overlaps) == 0
    i, j = pairs_in_contact(centre, np.full(grains, 1.0 + 1e-9), cell)
    clusters = network_clusters(make_frame(centre, 1.0, cell, {"i": i, "j": j}), singles=True)
    assert clusters.grains.tolist() == [grains]
    assert clusters.loops.tolist() == [0]


def test_who_meets_in_free_flight():
    """Two single discs and a row of 11: the discs find each other at the rate 2 sqrt(2), each finds the row at the rate
    (2 + 10 <|sin|>) sqrt(1 + 1/11), cross-section times relative speed."""
    row = np.column_stack((np.arange(11.0) - 5.0, np.zeros(11)))
    rng, draws = np.random.default_rng(5), 2000
    reach, lightness = np.array([0.5, 0.5, 5.5]), np.array([1.0, 1.0, 1 / 11])
    pairs = [_meeting([np.zeros((1, 2)), np.zeros((1, 2)), row], reach, lightness, rng)[:2] for _ in range(draws)]
    alone, found = 2 * np.sqrt(2), 2 * (2 + 10 * 2 / np.pi) * np.sqrt(12 / 11)
    expected = alone / (alone + found)
    # four standard errors of a share
    assert pairs.count((0, 1)) / draws == pytest.approx(expected, abs=4 * np.sqrt(expected * (1 - expected) / draws))


def test_size_grows_with_mass_as_published():
    """N ~ R_g^d_F between 64 and 1024 discs; published d_F = 1.55 +- 0.02 (G07 refs. 39, 89).

    R_g scatters by 15 %, so 4 % per point of 14 and 0.04 on the slope: 0.12 is three of those.  With 200 aggregates of each
    size: validation/fractals.
    """
    mass = 2 ** np.arange(6, 11)
    radii = [np.mean([0.5 * np.log((aggregate(int(n), seed) ** 2).sum(axis=1).mean()) for seed in range(14)]) for n in mass]
    assert 1 / np.polyfit(np.log(mass), radii, 1)[0] == pytest.approx(1.55, abs=0.12)


def test_only_powers_of_two_where_equal_ones_meet():
    assert len(ballistic_aggregate(12, np.random.default_rng(0))) == 12
    with pytest.raises(InputError, match="power of two"):
        ballistic_aggregate(12, np.random.default_rng(0), equal=True)
    with pytest.raises(InputError, match="1 or more"):
        ballistic_aggregate(0, np.random.default_rng(0))

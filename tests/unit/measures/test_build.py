"""Frames from arrays, pairs by geometry, periodic repetition."""

import numpy as np
import pytest
from networks import packing

from workflow.data.balance import solid_fraction
from workflow.data.build import make_frame, pairs_in_contact, repeat
from workflow.errors import InputError
from workflow.measures.forces import fabric, triangles
from workflow.measures.holes import holes
from workflow.measures.packing import coordination, stress
from workflow.measures.percolation import network_clusters, percolation


def stressed_packing(seed: int = 3):
    """A random packing whose contacts carry random forces."""
    frame, rng = packing(60, 0.8, seed), np.random.default_rng(seed)
    table = frame.interactions
    pairs = {"i": table.i, "j": table.j, "branch": table.branch, "gap": table.gap,
             "normal": rng.normal(size=len(table)), "tangential": rng.normal(size=len(table))}  # fmt: skip
    return make_frame(frame.position, frame.diameter, frame.cell, pairs, origin=(-1.0, 2.0))


def test_touching_pairs_are_all_pairs_of_negative_gap():
    rng = np.random.default_rng(0)
    position, diameter, cell = rng.uniform(-9, 9, (150, 2)), rng.uniform(0.3, 1.0, 150), np.array([7.0, 9.0])
    apart = position[:, None] - position
    apart -= cell * np.round(apart / cell)
    gap = np.hypot(*np.moveaxis(apart, 2, 0)) - (diameter[:, None] + diameter) / 2
    for reach in (0.0, 0.2):
        i, j = pairs_in_contact(position, diameter, cell, reach)
        assert np.column_stack((i, j)).tolist() == np.argwhere(np.triu(gap < reach, 1)).tolist()
    with pytest.raises(InputError, match="two images"):
        pairs_in_contact(position, diameter, np.array([1.9, 9.0]))


def test_arrays_alone_make_a_frame():
    frame = make_frame([[0.1, 0.0, 0.0], [9.3, 0.0, 0.0], [5.0, 5.0, 0.0]], 1.0, (10.0, 8.0))
    assert (frame.interactions.i.tolist(), frame.interactions.j.tolist()) == ([0], [1])
    assert frame.interactions.branch[0] == pytest.approx([-0.8, 0.0])
    assert frame.interactions.gap[0] == pytest.approx(-0.2)
    assert frame.ids.tolist() == [1, 2, 3]
    assert frame.mass.tolist() == [1.0, 1.0, 1.0]


def test_a_whole_normal_force_keeps_its_sign():
    pairs = {"i": [0, 1], "j": [1, 2], "normal": [2.0, -0.5]}
    table = make_frame([[0.0, 0], [1, 0], [2, 0]], 1.0, (9, 9), pairs).interactions
    assert table.normal_force.tolist() == [2.0, -0.5]
    assert table.attraction.tolist() == [0.0, -0.5]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"position": np.zeros(3)}, "shape"),
        ({"position": [[np.nan, 0.0], [1.0, 1.0]]}, "not finite"),
        ({"cell": (1.0, -1.0)}, "two lengths"),
        ({"diameter": [1.0, 1.0, 1.0]}, "2 positive numbers"),
        ({"pairs": {"i": [0]}}, "'j' is missing"),
        ({"pairs": {"i": [0], "j": [5]}}, "from 0 to 1"),
        ({"pairs": {"i": [0], "j": [1], "force": [1.0]}}, "'force' is no column"),
        ({"pairs": {"i": [0], "j": [1], "gap": [1.0, 2.0]}}, "'gap' has 2 rows"),
        ({"colour": 1}, "'colour' is no field"),
    ],
)
def test_bad_arrays_are_named(change, message):
    given = {"position": [[0.0, 0.0], [1.0, 0.0]], "diameter": 1.0, "cell": (9.0, 9.0)} | change
    with pytest.raises(InputError, match=message):
        make_frame(**given)


def test_repetition_is_the_same_packing_larger():
    """Every intensive measure stays; what winds, winds; holes and triangles multiply."""
    frame = stressed_packing()
    large = repeat(frame, (2, 3))
    assert large.grains == 6 * frame.grains
    assert solid_fraction(large) == pytest.approx(solid_fraction(frame), rel=1e-12)  # rounding of sums
    assert coordination(large, threshold=0.0).z == pytest.approx(coordination(frame, threshold=0.0).z)
    assert stress(large)[1] == pytest.approx(stress(frame)[1], rel=1e-10)  # sums of terms of both signs
    assert fabric(large) == pytest.approx(fabric(frame), rel=1e-12)
    assert percolation(large).axis == percolation(frame).axis
    assert len(triangles(large).grains) == 6 * len(triangles(frame).grains)
    assert (network_clusters(large).wraps.any(axis=0) == network_clusters(frame).wraps.any(axis=0)).all()
    assert holes(large).area.sum() == pytest.approx(6 * holes(frame).area.sum(), rel=1e-6)  # the nudge of degenerate cases
    # and its contacts join the centres they name
    straight = large.position[large.interactions.j] - large.position[large.interactions.i] - large.interactions.branch
    assert np.abs(straight / large.cell - np.round(straight / large.cell)).max() < 1e-12
    with pytest.raises(InputError, match="at least 1"):
        repeat(frame, (0, 1))

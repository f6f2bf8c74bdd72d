"""Force populations, orientations and tensors against closed forms of lattices and of touching triples."""

import numpy as np
import pytest

from workflow.data.build import make_frame
from workflow.data.frame import Frame, Interactions
from workflow.errors import InputError
from workflow.measures.forces import (
    corners,
    fabric,
    force_angles,
    force_populations,
    normal_force_distribution,
    nt_scatter,
    triangles,
)
from workflow.measures.packing import stress


def network(position, cell, pairs, normal=0.0, tangential=0.0, diameter=1.0, adhesion=0.0) -> Frame:
    """Discs with interactions ``pairs`` (i, j), each to the nearest image; N = elastic part - ``adhesion``."""
    position, cell = np.asarray(position, dtype=float), np.asarray(cell, dtype=float)
    i, j = np.asarray(pairs, dtype=np.int64).reshape(-1, 2).T
    branch = position[j] - position[i]
    branch -= cell * np.rint(branch / cell)
    zero, n = np.zeros(len(i)), len(position)
    d = np.zeros(n) + diameter
    gap = np.hypot(*branch.T) - 0.5 * (d[i] + d[j])
    contacts = Interactions(
        i, j, branch, gap, zero + normal + adhesion, zero, zero - adhesion, zero + tangential, zero, zero, zero,
        zero > 0, zero > 0,
    )  # fmt: skip
    grain = np.zeros(n)
    return Frame(
        0, 0.0, "", np.zeros(2), cell, np.arange(n), d, d**2, position, np.zeros((n, 2)), grain, np.zeros((n,
        2)), grain, contacts,
    )  # fmt: skip


def triangular(side: int, normal: float = 1.0, spacing: float = 1.0) -> Frame:
    """side x side (side even) triangular lattice, every grain linked to its 6 neighbours with force ``normal``."""
    x, y = (a.ravel() for a in np.mgrid[:side, :side])
    row, up, shift = side * x + y, (y + 1) % side, y % 2
    ahead = (side * ((x + 1) % side) + y, side * ((x + shift) % side) + up, side * ((x + shift - 1) % side) + up)
    place = spacing * np.column_stack((x + 0.5 * shift, y * np.sqrt(0.75)))
    pairs = np.vstack([np.column_stack((row, other)) for other in ahead])
    return network(place, (spacing * side, spacing * side * np.sqrt(0.75)), pairs, normal)


def list_of(normal, tangential=0.0, adhesion=0.0) -> Frame:
    """A star of interactions with the given forces (their geometry does not matter)."""
    n = len(normal)
    place = np.random.default_rng(0).uniform(0, 0.7, (n + 1, 2))
    return network(place, (9, 9), [[0, k] for k in range(1, n + 1)], normal, tangential, adhesion=adhesion)


def test_populations_of_a_hand_made_list():
    frame = list_of(np.array([3.0, 4.0, -0.05, -0.07, 1e-5, -1e-5, 0.0, 0.0]), [0, 0, 0, 0, 0, 0.2, 0, 0])
    p = force_populations(frame, unit=1.0)
    assert (p.repulsive.share, p.tensile.share, p.vanishing.share) == (0.25, 0.25, 0.5)
    assert p.repulsive.mean == 3.5
    assert p.repulsive.quadratic == pytest.approx(np.sqrt(12.5), rel=1e-15)  # rounding of the root
    assert p.tensile.mean == pytest.approx(0.06, rel=1e-12)  # the magnitude, as printed in table VI
    assert p.unstressed == 3 / 8  # the interaction with T = 0.2 has no normal part, yet it is stressed
    assert p.strong == 0.25
    total = p.repulsive.coordination + p.tensile.coordination + p.vanishing.coordination
    assert total == pytest.approx(2 * 8 / 9, rel=1e-12)  # z of 8 interactions among 9 grains


def test_populations_scale_with_the_unit_and_take_empty_networks():
    big, small = (force_populations(list_of(u * np.array([3.0, -2.0, 1e-5])), unit=u) for u in (50.0, 1.0))
    assert big.repulsive.mean == pytest.approx(small.repulsive.mean, rel=1e-14)  # rounding of the division
    assert big.vanishing.share == small.vanishing.share
    empty = force_populations(network([[1.0, 1.0]], (5, 5), []), unit=1.0)
    assert (empty.repulsive.mean, empty.vanishing.coordination, empty.strong) == (0.0, 0.0, 0.0)


def test_distribution_is_a_density_and_normalises_by_the_elastic_mean():
    """Exponential forces of mean 7: in units of the mean the density is exp(-x)."""
    force = np.random.default_rng(3).exponential(7.0, 20000)
    edges = np.linspace(0, 5, 11)
    found = normal_force_distribution(list_of(force), edges, unit=None)
    share = np.exp(-edges[:-1]) - np.exp(-edges[1:])
    # counts are binomial: 5 standard errors per bin
    assert (np.abs(found.density * 0.5 - share) < 5.0 * np.sqrt(share / 20000)).all()
    assert (found.density * 0.5).sum() == pytest.approx(np.mean(force / force.mean() < 5.0), abs=1e-12)


def test_unit_must_be_a_force():
    with pytest.raises(InputError, match="unit = 0"):
        normal_force_distribution(list_of([0.0, 0.0]), np.linspace(0, 1, 3), unit=None)
    with pytest.raises(InputError, match="ascending"):
        normal_force_distribution(list_of([1.0]), np.array([1.0]), unit=1.0)


def test_angles_of_known_forces():
    """Repulsive 0, tensile 180, T = sqrt(3) N of either sign 60 or 120 degrees; forces without direction left out."""
    root = np.sqrt(3.0)
    frame = list_of([1.0, -1.0, 1.0, 1.0, -1.0, 1e-9], [0, 0, root, -root, root, 0])
    found = force_angles(frame, np.array([0.0, 1.0, 59.0, 61.0, 119.0, 121.0, 179.0, 180.0]), tolerance=1e-4)
    assert found.density * np.diff(found.edges) * 5 == pytest.approx([1, 0, 2, 0, 1, 0, 1], abs=1e-12)  # whole counts


def test_sliding_contacts_lie_on_the_cone_and_balanced_ones_on_the_cross():
    """With |T| = mu N_e and N = N_e - F0 the force is on the cone, whose tip lies at N = -F0."""
    edges = np.linspace(-2, 3, 6)
    cloud = nt_scatter(list_of([0.5, 1.0], [0.75, -1.0], 1.0), edges, edges, unit=1.0, friction=0.5)
    outer, tip, _ = cloud.cone
    slope = (outer[1] - tip[1]) / (outer[0] - tip[0])
    assert tip.tolist() == [-1.0, 0.0]
    assert slope * (0.5 - tip[0]) == pytest.approx(0.5 * 1.5)  # N = 0.5 has N_e = 1.5
    assert cloud.density.sum() == pytest.approx(1.0)  # bins of area 1, all interactions inside
    assert cloud.density[2, 2] == 0.5
    assert cloud.density[3, 1] == 0.5
    assert np.degrees(np.arctan2(cloud.sqrt3_lines[0, 1, 1], cloud.sqrt3_lines[0, 1, 0])) == pytest.approx(60.0)


def test_triangle_ratio_points_along_the_line_of_the_two_contact_points():
    """Touching discs of radii 1/4, 0.4, 1/2: the two balanced forces on a disc lie on the line through its contacts."""
    r = np.array([0.25, 0.4, 0.5])
    a, b, c = r[0] + r[1], r[0] + r[2], r[1] + r[2]
    x = (a**2 + b**2 - c**2) / (2 * a)
    place = np.array([[0.0, 0.0], [a, 0.0], [x, np.sqrt(b**2 - x**2)]]) + 3.0
    frame = network(place, (9, 9), [[1, 0], [2, 1], [0, 2]], diameter=2 * r)
    found = triangles(frame)
    assert found.grains.tolist() == [[0, 1, 2]]
    for disc in range(3):
        one, two = (place[k] - place[disc] for k in range(3) if k != disc)
        one, two = one / np.linalg.norm(one), two / np.linalg.norm(two)
        along = one - two  # from one contact point to the other
        ratio = abs(along @ [-one[1], one[0]]) / abs(along @ one)
        assert found.ratio[0, disc] == pytest.approx(ratio, rel=1e-12)  # rounding


def test_equal_discs_have_ratio_sqrt_3_and_every_lattice_triangle_counts_once():
    found = triangles(triangular(8))
    assert len(found.grains) == 2 * 64  # two triangles per grain
    assert len(np.unique(found.grains, axis=0)) == 128
    assert np.abs(found.ratio - np.sqrt(3.0)).max() < 1e-14  # rounding


def test_three_grains_around_the_cell_are_no_triangle():
    assert len(triangles(network([[0, 0], [1, 0], [2, 0]], (3, 9), [[0, 1], [1, 2], [2, 0]])).grains) == 0


def test_triangles_of_a_random_network_agree_with_all_triples():
    rng = np.random.default_rng(5)
    place, n = rng.uniform(0, 8, (60, 2)), 60
    i, j = np.triu_indices(n, 1)
    d = place[j] - place[i]
    near = np.hypot(*(d - 8 * np.rint(d / 8)).T) < 1.4
    frame = network(place, (8, 8), np.column_stack((i, j))[near][::-1])
    linked = np.zeros((n, n), dtype=bool)
    linked[i[near], j[near]] = True
    expected = [
        [a, b, c]
        for a in range(n)
        for b in range(a + 1, n)
        for c in range(b + 1, n)
        if linked[a, b] and linked[b, c] and linked[a, c]
    ]
    assert triangles(frame).grains.tolist() == expected  # 1.4 is below a third of the cell: none can wind


def test_stress_of_the_triangular_lattice_is_the_closed_form_pressure():
    """Every bond carries N: sigma = sqrt(3) N / spacing, isotropic, compression positive."""
    found = sum(stress(triangular(6, normal=0.7, spacing=0.95)))
    assert found == pytest.approx(np.eye(2) * np.sqrt(3.0) * 0.7 / 0.95, abs=1e-12)  # rounding of a sum of 108 terms
    assert fabric(triangular(6)) == pytest.approx(np.eye(2) / 2, abs=1e-14)  # six-fold symmetry is isotropic


def test_kinetic_stress_of_opposite_streams():
    frame = triangular(4, normal=0.0)
    frame.velocity[:, 0] = np.where(np.arange(16) % 2, 2.0, -2.0)
    assert sum(stress(frame)) == pytest.approx(np.diag([16 * 4.0 / frame.area, 0.0]), abs=1e-14)  # rounding


def test_stress_balances_a_pulled_pair_and_turns_with_it():
    """One bond along axis 1, N = -2, T = 3, length 1: sigma = F r / A, F = (-2, 3); turned by 90 degrees likewise."""
    pair = sum(stress(network([[1, 1], [2, 1]], (4, 5), [[0, 1]], -2.0, 3.0)))
    assert pair == pytest.approx(np.array([[-2.0, 0.0], [3.0, 0.0]]) / 20)
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    turned = sum(stress(network([[1, 1], [1, 2]], (5, 4), [[0, 1]], -2.0, 3.0)))
    assert turned == pytest.approx(quarter @ pair @ quarter.T, abs=1e-16)
    swapped = sum(stress(network([[1, 1], [2, 1]], (4, 5), [[1, 0]], -2.0, 3.0)))
    assert swapped == pytest.approx(pair)


def test_fabric_of_selected_interactions():
    frame = network([[0, 0], [1, 0], [0, 1]], (5, 5), [[0, 1], [0, 2]])
    assert fabric(frame, np.array([True, False])).tolist() == [[1.0, 0.0], [0.0, 0.0]]
    assert fabric(frame, np.zeros(2, dtype=bool)).tolist() == [[0.0, 0.0], [0.0, 0.0]]


def test_corners_are_the_discs_that_two_touching_discs_hold() -> None:
    """A rhombus of four: the two outer discs have two contacts each; a force on one of them from a fifth ends that."""
    high = np.sqrt(0.75)
    place = [[0.0, -0.5], [0.0, 0.5], [-high, 0.0], [high, 0.0], [high + 1.0, 0.0]]
    pairs = {"i": [2, 2, 3, 3, 0, 3], "j": [0, 1, 0, 1, 1, 4], "normal": [0.1, 0.1, 0.2, 0.2, -0.6, 0.0]}
    frame = make_frame(np.array(place) + 4.0, 1.0 + 1e-6, (9.0, 9.0), pairs)
    found = corners(frame, tolerance=1e-4)
    assert [(int(d), {int(one), int(two)}) for d, one, two in found.grains] == [(3, {0, 1}), (2, {0, 1})]  # largest force first
    assert found.force == pytest.approx([0.2, 0.1])
    assert found.ratio == pytest.approx(np.sqrt(3.0))
    held = make_frame(frame.position, frame.diameter, frame.cell, pairs | {"normal": [0.1, 0.1, 0.2, 0.2, -0.6, 0.01]})
    assert corners(held, tolerance=1e-4).grains[:, 0].tolist() == [2]
    assert not len(corners(frame, tolerance=0.3).grains)

"""Holes of lattices, necklaces and islands in closed form; both routes against each other on random packings."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from workflow.data.frame import Frame, Interactions
from workflow.errors import InputError
from workflow.measures.holes import Holes, grid_holes, holes


def packing(position, cell, diameter=1.0, reach=1e-3) -> Frame:
    """Discs with a row for every pair closer than ``reach``; touching pairs are those with a negative gap."""
    position, cell = np.asarray(position, dtype=float), np.asarray(cell, dtype=float)
    n = len(position)
    d = np.zeros(n) + diameter
    tree = cKDTree(position % cell, boxsize=cell)
    i, j = tree.query_pairs(d.max() + reach, output_type="ndarray").astype(np.int64).T
    branch = position[j] - position[i]
    branch -= cell * np.rint(branch / cell)
    gap = np.hypot(*branch.T) - 0.5 * (d[i] + d[j])
    near = gap < reach
    zero, grain = np.zeros(near.sum()), np.zeros(n)
    contacts = Interactions(
        i[near], j[near], branch[near], gap[near], zero, zero, zero, zero, zero, zero, zero, zero > 0, zero > 0
    )
    return Frame(
        0, 0.0, "", np.zeros(2), cell, np.arange(n), d, d**2, position, np.zeros((n, 2)), grain, np.zeros((n,
        2)), grain, contacts,
    )  # fmt: skip


def necklace(discs: int, centre=(10.0, 10.0), cell=(20.0, 20.0)) -> Frame:
    """A closed ring of ``discs`` discs of diameter 1, overlapping by 1e-9."""
    angle = 2 * np.pi * np.arange(discs) / discs
    radius = (0.5 - 0.5e-9) / np.sin(np.pi / discs)
    ring = np.asarray(centre) + radius * np.column_stack((np.cos(angle), np.sin(angle)))
    return packing(ring % np.asarray(cell), cell)


def loose_packing(seed: int, side: int = 16, small: float = 0.82) -> Frame:
    """A diluted triangular lattice of large and small discs: overlaps of 0.06 or gaps above 0.02, holes, islands."""
    rng = np.random.default_rng(seed)
    x, y = (a.ravel() for a in np.mgrid[:side, :side])
    place = 0.94 * np.column_stack((x + 0.5 * (y % 2), y * np.sqrt(0.75)))
    kept = rng.uniform(size=len(place)) < 0.75
    diameter = np.where(rng.uniform(size=kept.sum()) < 0.15, small, 1.0)
    return packing(place[kept] + 0.05, 0.94 * side * np.array([1.0, np.sqrt(0.75)]), diameter)


def lens(a: float, b: float, d: float) -> float:
    """Common area of two circles of radii a, b at distance d, by numerical integration over the chord positions."""
    x = np.linspace(d - b, a, 20001)
    return float(np.trapezoid(2 * np.sqrt(np.maximum(np.minimum(a**2 - x**2, b**2 - (x - d) ** 2), 0)), x))


def same(one: Holes, other: Holes) -> None:
    """Equal up to rounding; the tiny nudge that settles degenerate lattices must leave no trace."""
    assert len(one.area) == len(other.area)
    # 1e-9 absolute: cancellation of second moments taken about a corner of a cell some 20 wide
    assert one.area == pytest.approx(other.area, rel=1e-9, abs=1e-9)
    assert np.sort(one.radius[~np.isnan(one.radius)]) == pytest.approx(np.sort(other.radius[~np.isnan(other.radius)]), rel=1e-6)
    assert one.wraps.any(axis=0).tolist() == other.wraps.any(axis=0).tolist()


def test_square_lattice_has_one_hole_per_grain():
    """Area 1 - pi/4; <r^2> from the square (1/6) less four quarter discs at distance 1/sqrt 2 from the centre."""
    x, y = (a.ravel() for a in np.mgrid[:6, :6])
    found = holes(packing(np.column_stack((x, y)) * (1 - 1e-12), np.full(2, 6 * (1 - 1e-12))))
    r = 0.5
    quarter = np.pi * r**4 / 8 + np.pi * r**2 / 4 * 0.5 - 2 * r**3 / 3
    area = 1 - np.pi / 4
    assert len(found.area) == 36
    assert found.area == pytest.approx(np.full(36, area), rel=1e-9)  # the overlap of 1e-12 and rounding
    # 1e-8: the square root amplifies rounding of second moments taken in a cell 6 wide
    assert found.radius == pytest.approx(np.full(36, np.sqrt(2 * (1 / 6 - 4 * quarter) / area)), rel=1e-8)
    assert found.weighted_radius == pytest.approx(found.radius[0], rel=1e-8)
    assert not found.wraps.any()


def test_triangular_lattice_has_two_holes_per_grain():
    side = 6
    x, y = (a.ravel() for a in np.mgrid[:side, :side])
    s = 1 - 1e-12
    place = s * np.column_stack((x + 0.5 * (y % 2), y * np.sqrt(0.75)))
    found = holes(packing(place, (s * side, s * side * np.sqrt(0.75))))
    assert len(found.area) == 2 * side**2
    assert found.area == pytest.approx(np.full(72, np.sqrt(3) / 4 - np.pi / 8), rel=1e-9)  # overlap and rounding


@pytest.mark.parametrize("centre", [(10.0, 10.0), (0.0, 0.0), (19.7, 4.0)])
def test_necklace_encloses_its_polygon_less_the_sectors(centre):
    """Regular n-gon of side 1: area n/4 cot(pi/n), inner angles (1 - 2/n) pi; wherever the ring lies in the cell."""
    n = 24
    found = holes(necklace(n, centre))
    inside = n / 4 / np.tan(np.pi / n) - n * 0.125 * (1 - 2 / n) * np.pi
    assert len(found.area) == 2
    assert found.area[1] == pytest.approx(inside, rel=1e-7)  # the discs overlap by 1e-9
    assert found.area.sum() == pytest.approx(400 - n * np.pi / 4, rel=1e-9)
    assert found.wraps.tolist() == [[True, True], [False, False]]
    assert found.weighted_radius is None
    # a nearly round hole of equivalent radius close to that of its area: the cusps make it larger by under 3 %
    assert 1.0 < found.radius[1] / np.sqrt(inside / np.pi) < 1.03


def test_islands_inside_a_hole_take_their_area_out_of_it():
    ring = necklace(24)
    island = np.array([[10.0, 10.0], [10.0 + 1 - 1e-9, 10.0], [8.5, 9.0]])
    found = holes(packing(np.vstack((ring.position, island)), (20, 20)))
    empty = holes(ring)
    assert len(found.area) == 2
    assert found.area[1] == pytest.approx(empty.area[1] - 3 * np.pi / 4, rel=1e-9)


def test_small_discs_in_the_notches_of_a_large_contact():
    """Radii 0.5 and 0.1: the small centres are nearer to each other than the large ones, yet parted by them."""
    height = np.sqrt(0.6**2 - 0.5**2) - 1e-9
    place = np.array([[4.5, 5], [5.5 - 1e-9, 5], [5, 5 + height], [5, 5 - height]])
    found = holes(packing(place, (9, 9), np.array([1.0, 1.0, 0.2, 0.2])))
    flank = np.arccos(0.5 / 0.6)
    notch = 0.5 * np.sqrt(0.6**2 - 0.5**2) - 0.5**2 * flank - 0.5 * 0.1**2 * (np.pi - 2 * flank)
    assert len(found.area) == 3
    assert found.area[1:] == pytest.approx([notch, notch], rel=1e-6)  # overlaps of 1e-9


def test_distant_pair_does_not_close_a_hole():
    ring = necklace(24)
    apart = 10.0 + (ring.position - 10.0) * (1 + 5e-4)  # gaps of 5e-4: interactions, not contacts
    opened = packing(apart, ring.cell)
    assert len(opened.interactions) == 24
    found = holes(opened)
    assert len(found.area) == 1
    assert found.area[0] == pytest.approx(400 - 6 * np.pi, rel=1e-12)


def test_chain_across_the_cell_leaves_one_hole_that_winds_along_it():
    s = 1 - 1e-9
    found = holes(packing(np.column_stack((s * np.arange(8), np.full(8, 2.0))), (8 * s, 9)))
    assert found.wraps.tolist() == [[True, False]]


def test_single_grain_and_empty_frame():
    found = holes(packing([[0.3, 0.4]], (3, 5)))
    assert found.area == pytest.approx([15 - np.pi / 4])
    assert found.wraps.tolist() == [[True, True]]
    frame = packing([[0.3, 0.4]], (3, 5))
    with pytest.raises(InputError, match="0 grains"):
        holes(replace(frame, ids=np.zeros(0, dtype=np.int64)))


def test_grain_inside_another_is_covered_and_nan_refused():
    """A hidden grain takes no part in the triangulation: the void is that of the visible one."""
    frame = packing([[1.0, 1.0], [1.05, 1.0]], (4, 4), np.array([1.0, 0.1]))
    assert holes(frame).area == pytest.approx([16 - np.pi / 4], rel=1e-12)
    with pytest.raises(InputError, match="finite"):
        holes(replace(frame, position=np.array([[np.nan, 1.0], [2.0, 1.0]])))


@pytest.mark.parametrize(("seed", "small"), [(0, 0.82), (1, 0.82), (2, 0.2)])
def test_holes_fill_the_cell_outside_the_discs(seed, small):
    """Sum of hole areas = A - discs + overlaps of pairs (three discs share no point here)."""
    frame = loose_packing(seed, small=small)
    c, r = frame.interactions, frame.diameter / 2
    overlaps = sum(lens(r[a], r[b], d) for a, b, d in zip(c.i, c.j, c.distance, strict=True) if d < r[a] + r[b])
    expected = frame.area - np.pi * (r**2).sum() + overlaps
    assert holes(frame).area.sum() == pytest.approx(expected, rel=1e-6)  # the trapezoid rule of ``lens``


@pytest.mark.parametrize("seed", [0, 3])
def test_large_holes_agree_with_a_flood_fill_on_a_fine_mesh(seed):
    """Holes wider than a grain; the mesh of 0.01 blurs perimeters: 2 % in area, 2 % in R_H."""
    frame = replace(loose_packing(seed), origin=np.array([3.0, -2.0]))
    exact, mesh = holes(frame), grid_holes(frame, spacing=0.01)
    large = exact.area > 1.0
    assert large.sum() >= 3
    assert mesh.area[: large.sum()] == pytest.approx(exact.area[large], rel=0.02)
    assert mesh.radius[: large.sum()] == pytest.approx(exact.radius[large], rel=0.02, nan_ok=True)
    assert (mesh.wraps[: large.sum()] == exact.wraps[large]).all()
    assert mesh.area.sum() == pytest.approx(exact.area.sum(), rel=1e-3)  # boundary nodes cancel statistically


def test_translation_relabelling_and_rotation_change_nothing():
    frame = loose_packing(4)
    expected = holes(frame)
    moved = packing((frame.position + np.array([3.3, 7.7])) % frame.cell, frame.cell, frame.diameter)
    same(holes(moved), expected)
    order = np.random.default_rng(0).permutation(frame.grains)
    same(holes(packing(frame.position[order], frame.cell, frame.diameter[order])), expected)
    turned = holes(packing(frame.position[:, ::-1] * [-1, 1], frame.cell[::-1], frame.diameter))
    same(replace(turned, wraps=turned.wraps[:, ::-1]), expected)


def test_mesh_necklace_across_the_edge_keeps_its_radius():
    """The hole crosses both edges of the cell and is measured in one piece; mesh error of a 0.02 spacing: 1 %."""
    one, two = grid_holes(necklace(24), spacing=0.02), grid_holes(necklace(24, (0.0, 0.0)), spacing=0.02)
    exact = holes(necklace(24))
    for found in (one, two):
        assert found.radius[1] == pytest.approx(exact.radius[1], rel=0.01)
        assert found.area[1] == pytest.approx(exact.area[1], rel=0.01)
        assert found.weighted_radius is None


def test_weighted_radius_and_distribution_of_a_hand_made_list():
    """Areas 3, 1 and radii 2, 1: <R>_w = 7/4 (eq. 30); a percolating hole leaves it undefined but counts among all."""
    closed = np.zeros((2, 2), dtype=bool)
    found = Holes(np.array([3.0, 1.0]), np.array([2.0, 1.0]), closed)
    assert found.weighted_radius == 1.75
    assert found.distribution(np.array([0.5, 1.5, 3.5])).tolist() == [0.5, 0.25]
    endless = Holes(np.array([3.0, 1.0]), np.array([np.nan, 1.0]), ~closed)
    assert endless.weighted_radius is None
    assert endless.distribution(np.array([0.5, 1.5])).tolist() == [0.5]
    with pytest.raises(InputError, match="ascending"):
        found.distribution(np.array([1.0]))

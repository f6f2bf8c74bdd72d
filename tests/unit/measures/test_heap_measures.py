"""Measures of heaps on heaps that are known: triangles, fields of constant stress, scripted slides."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from workflow.data.frame import Frame, Interactions
from workflow.errors import InputError
from workflow.measures.heap import (
    Ground,
    Surface,
    Tracks,
    angle_of_repose,
    avalanches,
    base_forces,
    defects,
    dip,
    equivalent_stiffness,
    fields,
    in_heap,
    mean_profile,
    surface,
)

RISE = math.sqrt(0.75)


def frame_of(position: np.ndarray, base: int, normal: Any = 1.0, tangential: Any = 0.0) -> Frame:
    """Unit discs with forces between all that touch."""
    pairs = cKDTree(position).query_pairs(1.0 + 1e-6, output_type="ndarray")
    pairs = pairs[np.lexsort(pairs.T[::-1])]
    i, j = pairs.T if len(pairs) else (np.empty(0, int), np.empty(0, int))
    branch, zero = position[j] - position[i], np.zeros(len(i))
    columns = (zero + normal, zero, zero, zero + tangential, zero, zero, zero, zero > 0, zero > 0)
    one, n = np.ones(len(position)), len(position)
    contacts = Interactions(i, j, branch, np.hypot(*branch.T) - 1.0, *columns)
    return Frame(0, 0.0, "pour", np.zeros(2), np.array([80.0, 80.0]), np.arange(1, n + 1), one, one, position,
                 np.zeros((n, 2)), 0 * one, np.zeros((n, 2)), 0 * one, contacts, (False, False))  # fmt: skip


def triangle(rows: int) -> tuple[Frame, Ground]:
    """A pyramid of 60 degrees on a row of touching discs."""
    places = [np.column_stack((np.arange(rows - k) + 0.5 * k, np.full(rows - k, RISE * k))) for k in range(rows)]
    position = np.concatenate(places) - [0.5 * (rows - 1), 0.0]
    return frame_of(position, rows), Ground(rows, 0.0, 0.0)


def test_angle_of_a_triangle() -> None:
    frame, ground = triangle(30)
    own = in_heap(frame, ground)
    assert own.sum() == frame.grains - 30
    angle = angle_of_repose(surface(frame.position[own], frame.diameter[own], ground))
    # the profile has steps of one row in columns of one diameter, 25 of them
    assert angle["left"] == pytest.approx(60.0, abs=1.0) and angle["right"] == pytest.approx(60.0, abs=1.0)
    assert angle["mean"] == pytest.approx(60.0, abs=1.0) and 0.0 < angle["uncertainty"] < 1.0


@pytest.mark.parametrize(("left", "right"), [(20.0, 20.0), (30.0, 40.0)])
def test_angles_of_straight_flanks_are_exact(left: float, right: float) -> None:
    x = np.arange(-60.0, 61.0)
    slope = np.where(x < 0.0, math.tan(math.radians(left)), math.tan(math.radians(right)))
    angle = angle_of_repose(Surface(x, np.maximum(20.0 - slope * np.abs(x), 0.0)))
    assert angle["left"] == pytest.approx(left) and angle["right"] == pytest.approx(right)
    assert angle["uncertainty"] == pytest.approx(0.5 * abs(left - right), abs=1e-6)


def test_a_layer_has_no_angle() -> None:
    assert angle_of_repose(Surface(np.arange(20.0), np.ones(20)))["mean"] is None
    assert angle_of_repose(Surface(np.empty(0), np.empty(0)))["mean"] is None


def test_grains_in_flight_are_not_of_the_heap() -> None:
    frame, ground = triangle(6)
    flying = np.concatenate((frame.position, [[0.0, 30.0], [0.9, 30.0]]))
    assert in_heap(frame_of(flying, 6), ground).tolist() == [*([False] * 6), *([True] * 15), False, False]


def test_base_force_is_the_sum_of_its_contacts() -> None:
    """A grain in the hollow of two: each takes N sin 60 + T cos 60."""
    position = np.array([[-0.5, 0.0], [0.5, 0.0], [0.0, RISE]])
    frame = frame_of(position, 2, normal=np.array([0.0, 2.0, 2.0]), tangential=np.array([0.0, 0.3, -0.3]))
    x, force = base_forces(frame, Ground(2, 0.0, 0.0))
    assert x.tolist() == [-0.5, 0.5]
    assert force == pytest.approx(2.0 * RISE + 0.3 * 0.5)


def test_dip_of_known_profiles() -> None:
    x = np.linspace(-20.0, 20.0, 81)
    flat, peak, double = np.ones(81), 20.0 - np.abs(x), np.minimum(20.0 - np.abs(x), 8.0 + np.abs(x))
    assert dip(x, flat, 20.0) == pytest.approx(0.0)
    assert dip(x, peak, 20.0) < 0.0
    assert dip(x, double, 20.0) == pytest.approx(1.0 - (8.0 + np.abs(x[np.abs(x) < 3.0]).mean()) / 14.0)


def test_equivalent_stiffness_does_the_same_work() -> None:
    r, n = np.linspace(0.9, 1.2, 200_001), 36
    work = float(np.sum(0.5 * (r[1:] ** -(n + 1.0) + r[:-1] ** -(n + 1.0)) * np.diff(r)))
    # the trapezoidal rule with 2e5 intervals
    assert equivalent_stiffness(36, 1.2, 0.9) * 0.1**2 / 2.0 == pytest.approx(work, rel=1e-8)
    with pytest.raises(InputError, match=r"r_i = 1\.1"):
        equivalent_stiffness(36, 1.2, 1.1)


def test_mean_profile_over_heaps() -> None:
    x = np.arange(-9.9, 10.0, 1.1)
    profile = mean_profile([(x, np.full(len(x), 4.0)), (x, np.full(len(x), 6.0))])
    middle = np.abs(profile.x) < 9.0
    assert profile.force[middle] == pytest.approx(5.0) and profile.error[middle] == pytest.approx(1.0)
    assert np.isnan(mean_profile([(x, x)]).error).all()


def test_fields_of_a_crystal() -> None:
    """Unit normal forces in a triangular lattice: stress sqrt(3) on every axis (F r per area: 3/2 / (sqrt(3)/2)), voidage
    1 - pi/sqrt(12)."""
    frame, ground = triangle(40)
    grid = fields(frame, ground)
    x, y = np.meshgrid(grid.x, grid.y)
    deep = (y > 6.0) & (y < 12.0) & (np.abs(x) < 5.0)
    # a Gaussian of 1.5 diameters leaves less than a percent of the lattice
    assert grid.voidage[deep] == pytest.approx(1.0 - math.pi / math.sqrt(12.0), abs=0.01)
    assert grid.stress[deep] == pytest.approx(np.broadcast_to(math.sqrt(3.0) * np.eye(2), (deep.sum(), 2, 2)), abs=0.02)


def test_crystal_has_no_defects_and_a_hole_is_one_vacancy() -> None:
    frame, ground = triangle(30)
    perfect = defects(frame, ground)
    assert perfect == {"sixfold": 1.0, "psi6": pytest.approx(1.0), "vacancies": 0.0}
    inner = int(np.argmin(np.hypot(*(frame.position - [0.0, 8.0]).T)))
    holed = frame_of(np.delete(frame.position, inner, axis=0), 30)
    assert defects(holed, ground)["vacancies"] == pytest.approx(1.0)


def test_slides_are_found_with_time_side_and_size() -> None:
    """Two layers of the right flank go down by a diameter between the fifth and the seventh record."""
    frame, ground = triangle(30)
    position = np.repeat(frame.position[None], 12, axis=0)
    depth = (0.5 * 29 - frame.position[:, 0]) * RISE * 2 - frame.position[:, 1]
    layer = (depth < 2.5) & (frame.position[:, 0] > 3.0) & (frame.ids > 30)
    for k in (5, 6):
        position[k:, layer] += 0.8 * np.array([0.5, -RISE])
    tracks = Tracks(2.0 * np.arange(12), frame.ids, position)
    (found,) = avalanches(tracks, ground)
    assert (found.begin, found.end, found.side, found.size) == (8.0, 12.0, 1, int(layer.sum()))
    assert 0.5 < found.depth < 4.0
    assert not avalanches(Tracks(tracks.time, frame.ids, np.repeat(frame.position[None], 12, axis=0)), ground)

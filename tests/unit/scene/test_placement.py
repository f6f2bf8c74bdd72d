"""Random placement of discs: none overlaps, the density is exact, the points are uniform, the seed decides all."""

from __future__ import annotations

import time

import numpy as np
import pytest
from scipy import stats

from workflow.data.discs import Discs, strips
from workflow.errors import InputError
from workflow.scene import placement
from workflow.scene.method1 import Method1
from workflow.scene.placement import cell_length, diameters, place_randomly


def gaps(discs: Discs) -> np.ndarray:
    """Gap of every pair and of all 9 images, and of each disc with its own images, (9 N^2 - N,)."""
    apart = discs.position[None] - discs.position[:, None]
    reach = (discs.diameter[None] + discs.diameter[:, None]) / 2
    every = []
    for x in (-1, 0, 1):
        for y in (-1, 0, 1):
            gap = np.linalg.norm(apart + discs.cell * [x, y], axis=2) - reach
            every.append(gap[~np.eye(len(gap), dtype=bool)] if x == y == 0 else gap.ravel())
    return np.concatenate(every)


@pytest.mark.parametrize(
    ("count", "solid_fraction", "smallest", "gap"),
    [
        (10, 0.3, 0.5, 1e-3),
        (300, 0.36, 0.5, 1e-3),
        (400, 0.53, 0.5, 1e-3),
        (200, 0.5, 1.0, 0.0),
        (300, 0.3, 0.5, 0.1),
        (400, 0.5, 0.05, 1e-3),
        (400, 0.01, 0.01, 1e-6),
    ],
)
def test_no_overlap_and_exact_density(count: int, solid_fraction: float, smallest: float, gap: float) -> None:
    rng = np.random.default_rng(count)
    discs = place_randomly(diameters(count, smallest, rng), solid_fraction, gap, rng)
    assert gaps(discs).min() >= gap - 1e-12  # differences of coordinates of order ten
    assert np.pi / 4 * np.sum(discs.diameter**2) / np.prod(discs.cell) == pytest.approx(solid_fraction, rel=1e-12)
    assert np.all((discs.position >= 0) & (discs.position < discs.cell))
    assert discs.position.shape == (count, 2)


def one_by_one(diameter: np.ndarray, solid_fraction: float, gap: float, rng: np.random.Generator, *, by_size: bool) -> Discs:
    """What `place_randomly` says it does, disc by disc, each compared with every other."""
    size, length = np.sort(diameter)[::-1] if by_size else rng.permutation(diameter), cell_length(diameter, solid_fraction)
    position = np.full((len(size), 2), np.nan)

    def touches(disc: int, point: np.ndarray, others: np.ndarray) -> bool:
        apart = np.abs(point - position[others])
        apart = np.minimum(apart, length - apart)
        near = np.sqrt(np.sum(apart**2, axis=1)) < 0.5 * (size[disc] + size[others]) + gap
        return bool(near.any())

    while len(left := np.flatnonzero(np.isnan(position[:, 0]))):
        waiting = left[: -(-len(size) // 16)]
        there = np.flatnonzero(~np.isnan(position[:, 0]))
        tries = rng.uniform(0.0, length, (len(waiting), max(1, 40_000 // len(waiting)), 2))
        found = {
            disc: next((p for p in points if not touches(disc, p, there)), None)
            for disc, points in zip(waiting, tries, strict=True)
        }
        found = {disc: point for disc, point in found.items() if point is not None}
        for disc, point in found.items():
            position[disc] = point
        rows = np.array(list(found), dtype=int)
        clashing = [k for k, disc in enumerate(rows) if touches(disc, position[disc], rows[:k])]
        position[rows[clashing]] = np.nan
    order = strips(position, np.array([length, length]))
    return Discs(size[order], position[order], np.array([length, length]))


@pytest.mark.parametrize(
    ("count", "phi", "smallest", "gap", "by_size"),
    [
        (3, 0.15, 0.5, 0.1, True),
        (40, 0.5, 0.5, 1e-3, True),
        (700, 0.45, 0.5, 1e-3, True),
        (150, 0.4, 0.05, 0.0, True),
        (3, 0.15, 0.5, 0.1, False),
        (700, 0.42, 0.5, 1e-3, False),
        (150, 0.35, 0.05, 0.0, False),
    ],
)
def test_cells_change_nothing(
    count: int,
    phi: float,
    smallest: float,
    gap: float,
    by_size: bool,
    product_proposals: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The same bytes as without them: published results name seeds."""
    monkeypatch.setattr(placement, "_PROPOSALS", product_proposals)
    found, expected = (
        method(diameters(count, smallest, rng), phi, gap, rng, by_size=by_size)
        for method in (place_randomly, one_by_one)
        if (rng := np.random.default_rng(count))
    )
    assert found.position.tobytes() == expected.position.tobytes()
    assert found.diameter.tobytes() == expected.diameter.tobytes()


def test_sizes_are_kept() -> None:
    rng = np.random.default_rng(3)
    size = diameters(200, 0.5, rng)
    assert np.array_equal(np.sort(place_randomly(size, 0.4, 1e-3, rng).diameter), np.sort(size))


def test_seed_decides_all() -> None:
    one, same, other = (Method1(n=100, seed=seed).discs() for seed in (5, 5, 6))
    assert one.position.tobytes() == same.position.tobytes()
    assert one.diameter.tobytes() == same.diameter.tobytes()
    assert not np.isin(one.diameter, other.diameter).any()
    assert not np.isin(one.position, other.position).any()


def test_seed_alone_decides_the_grains_of_scenes_that_differ_in_the_law() -> None:
    """Samples with and without friction start from the same grains (G07 compares them pairwise)."""
    one, other = (Method1(n=100, mu=mu).discs() for mu in (0.0, 0.5))
    assert one.position.tobytes() == other.position.tobytes()


def test_positions_are_uniform() -> None:
    """Chi-square of 25 cells, dilute so that points are nearly independent; significance 1e-3 at a fixed seed."""
    rng = np.random.default_rng(11)
    samples = [place_randomly(diameters(2000, 0.5, rng), 0.05, 1e-3, rng) for _ in range(2)]
    points = np.concatenate([sample.position / sample.cell for sample in samples])
    counts, _, _ = np.histogram2d(points[:, 0], points[:, 1], bins=5, range=[[0, 1], [0, 1]])
    assert stats.chisquare(counts.ravel()).pvalue > 1e-3


def test_position_does_not_depend_on_size() -> None:
    """Large discs are placed first, which must not show: rank correlation of size and coordinate, significance 1e-3."""
    rng = np.random.default_rng(12)
    discs = place_randomly(diameters(3000, 0.5, rng), 0.3, 1e-3, rng)
    for axis in (0, 1):
        assert stats.spearmanr(discs.diameter, discs.position[:, axis]).pvalue > 1e-3


@pytest.mark.parametrize("smallest", [0.5, 0.05])
def test_diameters_are_uniform(smallest: float) -> None:
    """Kolmogorov-Smirnov against the uniform law of G07 sec. II A, significance 1e-3."""
    size = diameters(5000, smallest, np.random.default_rng(4))
    assert stats.kstest(size, stats.uniform(smallest, 1 - smallest).cdf).pvalue > 1e-3
    assert smallest <= size.min() <= size.max() <= 1.0


def test_scene_has_gaps_of_the_range_of_attraction() -> None:
    assert gaps(Method1(n=200, d0=0.05).discs()).min() >= 0.05 - 1e-12
    assert gaps(Method1(n=200, cohesion=False).discs()).min() >= -1e-12


def test_twenty_thousand_grains_at_the_highest_density_of_the_paper() -> None:
    begun = time.process_time()
    discs = Method1(n=20_000, phi0=0.53).discs()
    assert time.process_time() - begun < 8.0  # "a few seconds"; 0.4 s where this was written
    assert len(discs.diameter) == 20_000


def test_neighbours_in_space_are_neighbours_in_memory() -> None:
    """Consecutive rows lie within a few diameters (a random order would be half a cell apart)."""
    discs = Method1(n=5000).discs()
    steps = np.abs(np.diff(discs.position, axis=0))
    steps = np.minimum(steps, discs.cell - steps)
    assert np.median(np.hypot(steps[:, 0], steps[:, 1])) < 3.0


def test_disc_that_would_touch_its_own_image_is_refused() -> None:
    with pytest.raises(InputError, match="own image"):
        place_randomly(np.ones(2), 0.5, 0.0, np.random.default_rng(0))

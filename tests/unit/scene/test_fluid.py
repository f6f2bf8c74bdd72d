"""The initial fluid: the pressure of hard discs, the same whatever it began from, no gap below D0, the seed decides all."""

from __future__ import annotations

import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from drawn import examples
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from workflow.data.discs import Discs
from workflow.errors import EnvironmentFault, InputError
from workflow.scene import fluid as module
from workflow.scene.fluid import equilibrate, fluid
from workflow.scene.method1 import Method1
from workflow.scene.method2 import Method2
from workflow.scene.placement import cell_length, diameters, place_randomly

SOURCE = Path(__file__).parents[3] / "monte_carlo" / "hard_discs.cpp"


def pairs(position: np.ndarray, diameter: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows i, j and the gap of pairs whose gap is below 0.2 largest diameters."""
    i, j = cKDTree(position, boxsize=length).query_pairs(1.2 * diameter.max(), output_type="ndarray").T
    apart = np.abs(position[i] - position[j])
    apart = np.minimum(apart, length - apart)
    return i, j, np.hypot(*apart.T) - (diameter[i] + diameter[j]) / 2


def pressure(diameter: np.ndarray, eta: float) -> float:
    """Z = P A/(N kT) from contact values of mixtures and of equal discs.

    Z = 1 + (2 eta/<d^2>) <d_ij^2 g_ij>; g_ij = 1/(1 - eta) + (g - 1/(1 - eta)) (<d>/<d^2>) d_i d_j/d_ij (Santos, Yuste, Lopez
    de Haro, Mol. Phys. 96, 1 (1999); Jenkins and Mancini's with the first term of g); g of Luding, PRE 63, 042201 (2001).
    """
    one, two = np.mean(diameter), np.mean(diameter**2)
    g = (1 - 7 * eta / 16) / (1 - eta) ** 2 - eta**3 / (128 * (1 - eta) ** 4)
    mixed = (two + one**2) / 2 / (1 - eta) + (g - 1 / (1 - eta)) * one**2
    return float(1 + 2 * eta / two * mixed)


def measured_pressure(discs: Discs, gap: float) -> tuple[float, float]:
    """Z of the formula above with the pair density found at distances up to 1.16 d_ij, extrapolated to contact, and its error."""
    reach = discs.diameter + gap
    i, j, apart = pairs(discs.position, reach, float(discs.cell[0]))
    edges = np.linspace(0.0, 0.16, 9)
    xi_t = apart / ((reach[i] + reach[j]) / 2)
    count, middle = np.histogram(xi_t, edges)[0], (edges[1:] + edges[:-1]) / 2
    density = len(reach) / np.prod(discs.cell)
    weight = np.pi * density * len(reach) * (np.mean(reach**2) + np.mean(reach) ** 2) / 2 * (1 + middle) * np.diff(edges)
    fit, spread = np.polyfit(middle, np.log(count / weight), 2, w=np.sqrt(count), cov="unscaled")
    factor = np.pi / 2 * density * (np.mean(reach**2) + np.mean(reach) ** 2) / 2 * np.exp(fit[-1])
    return float(1 + factor), float(factor * np.sqrt(spread[-1, -1]))


@pytest.mark.parametrize(("solid_fraction", "smallest"), [(0.13, 0.5), (0.36, 0.5), (0.5244, 0.5), (0.55, 0.2), (0.5, 1.0)])
def test_pressure_is_that_of_hard_discs(solid_fraction: float, smallest: float) -> None:
    """Within three standard errors (of about 2.5 %) and 1 % for the theories, which are not exact."""
    rng, gap = np.random.default_rng(21), 0.01
    discs = fluid(diameters(10_000, smallest, rng), solid_fraction, gap, rng)
    reach = discs.diameter + gap
    expected = pressure(reach, float(np.pi / 4 * np.sum(reach**2) / np.prod(discs.cell)))
    found, error = measured_pressure(discs, gap)
    assert error < 0.03 * expected
    assert abs(found - expected) < 3 * error + 0.01 * expected


def lattice(count: int, length: float) -> np.ndarray:
    across = int(np.ceil(np.sqrt(count)))
    row = np.arange(count)
    return (np.column_stack([row % across, row // across]) + 0.5) * (length / across)


def neighbours(position: np.ndarray, diameter: np.ndarray, length: float) -> list[float]:
    """Near pairs per disc, their correlation of sizes, and how much larger than the mean their discs are."""
    i, j, gap = pairs(position, diameter, length)
    unit = (diameter - diameter.mean()) / diameter.std()
    one, other = unit[i[gap < 0.1]], unit[j[gap < 0.1]]
    return [len(one) / len(diameter), float(np.mean(one * other)), float(np.mean(one + other)) / 2]


SAMPLES, DISCS = 6, 700  # enough for a start to differ by more than six standard errors, as the test states
START = ["addition by size", "addition in random order", "lattice"]


def begin(how: str, size: np.ndarray, rng: np.random.Generator) -> Discs:
    if how == "lattice":
        length = cell_length(size, 0.45)
        return Discs(size, lattice(len(size), length), np.array([length, length]))
    return place_randomly(size, 0.45, 0.0, rng, by_size=how == "addition by size")


@pytest.fixture(scope="module")
def fluids() -> np.ndarray:
    return np.array([neighbours(d.position, d.diameter, d.cell[0]) for d in (fluid_of(seed) for seed in range(SAMPLES))])


def fluid_of(seed: int) -> Discs:
    rng = np.random.default_rng(seed)
    return fluid(diameters(DISCS, 0.5, rng), 0.45, 0.0, rng)


def apart(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Differences of the means of samples (rows) in combined standard errors."""
    error = np.sqrt(np.var(one, axis=0, ddof=1) / len(one) + np.var(other, axis=0, ddof=1) / len(other))
    return np.abs(np.mean(one, axis=0) - np.mean(other, axis=0)) / error


@pytest.mark.parametrize("how", START)
def test_the_start_is_forgotten(how: str, fluids: np.ndarray) -> None:
    """Six samples of 700: near pairs and the sizes in them within four standard errors; none of the starts is before."""
    before, after = [], []
    for seed in range(SAMPLES):
        rng = np.random.default_rng(100 + seed)
        start = begin(how, diameters(DISCS, 0.5, rng), rng)
        length = float(start.cell[0])
        mixed = equilibrate(start.position, start.diameter, 0.0, length, rng)
        before.append(neighbours(start.position, start.diameter, length))
        after.append(neighbours(mixed, start.diameter, length))
    assert apart(np.array(before), fluids).max() > 6.0
    assert apart(np.array(after), fluids).max() < 4.0


@examples(12)
@given(
    count=st.integers(4, 60),
    fraction=st.floats(1e-3, 0.6),
    smallest=st.floats(0.01, 1.0),
    gap=st.floats(1e-6, 0.1),
    seed=st.integers(0, 99),
)
def test_no_gap_below_the_least_and_sizes_kept(count: int, fraction: float, smallest: float, gap: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = diameters(count, smallest, rng)
    area = np.pi / 4 * np.sum(size**2) / fraction
    assume(2.0 * (1.0 + gap) < np.sqrt(area))  # no disc touches its own image
    assume(np.pi / 4 * np.sum((size + gap) ** 2) < 0.58 * area)  # few discs in a small cell jam from about 0.6 on
    discs = fluid(size, fraction, gap, rng)
    length = float(discs.cell[0])
    images = np.array([[x, y] for x in (-length, 0.0, length) for y in (-length, 0.0, length)])
    far = np.linalg.norm(discs.position[:, None, None] - discs.position[None, :, None] + images, axis=3)
    far -= (discs.diameter[:, None, None] + discs.diameter[None, :, None]) / 2
    far[np.arange(count), np.arange(count), 4] = np.inf
    assert far.min() >= gap
    assert np.array_equal(np.sort(discs.diameter), np.sort(size))
    assert np.pi / 4 * np.sum(size**2) / length**2 == pytest.approx(fraction, rel=1e-12)
    assert np.all((discs.position >= 0) & (discs.position < length))


def test_as_dense_as_any_scene() -> None:
    """Wide and equal sizes; the largest gaps of a scene at its highest density fill 0.80 (sizes from 0.01)."""
    for fraction, smallest, gap in [(0.55, 1.0, 1e-3), (0.6, 0.5, 1e-3), (0.6, 1.0, 0.1), (0.6, 0.01, 0.1)]:
        rng = np.random.default_rng(5)
        discs = fluid(diameters(500, smallest, rng), fraction, gap, rng)
        assert pairs(discs.position, discs.diameter, float(discs.cell[0]))[2].min() >= gap


def test_what_cannot_be_is_refused() -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(InputError, match=r"0\.95 is too high.*--phi0"):
        fluid(diameters(60, 0.5, rng), 0.95, 0.0, rng)
    with pytest.raises(InputError, match="own image"):
        fluid(np.ones(2), 0.5, 0.0, rng)


def test_fourteen_hundred_discs_in_two_seconds() -> None:
    begun = time.process_time()
    Method1(n=1400, phi0=0.55, initial="fluid").discs()
    assert time.process_time() - begun < 2.0  # 0.4 s where this was written


def test_seed_decides_all() -> None:
    one, same, other = (Method1(n=100, seed=seed, initial="fluid").discs() for seed in (5, 5, 6))
    assert one.position.tobytes() == same.position.tobytes() and one.diameter.tobytes() == same.diameter.tobytes()
    assert not np.isin(one.position, other.position).any()


def test_both_methods_start_from_the_same_fluid_of_the_same_sizes() -> None:
    one, two = Method1(n=100, initial="fluid").discs(), Method2(n=100, phi0=0.36, initial="fluid").discs()
    assert one.position.tobytes() == two.position.tobytes()
    for other in ("random_addition", "addition_by_size"):
        assert np.array_equal(np.sort(Method1(n=100, initial=other).discs().diameter), np.sort(one.diameter))


@pytest.mark.engine  # a compiler
@pytest.mark.parametrize("options", [["-O0"], ["-O3", "-march=native"]])
def test_every_build_gives_the_same_bytes(options: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compiler = shutil.which("c++")
    assert compiler, "no C++ compiler: the library could not have been built either"
    built = tmp_path / "hard_discs.so"
    fixed = ["-std=c++17", "-ffp-contract=off", "-shared", "-fPIC", str(SOURCE), "-o", str(built)]
    subprocess.run([compiler, *options, *fixed], check=True, capture_output=True)
    library = module.load(built)
    usual = Method1(n=300, phi0=0.5, initial="fluid").discs()
    monkeypatch.setattr(module, "_library", lambda: library)
    assert Method1(n=300, phi0=0.5, initial="fluid").discs().position.tobytes() == usual.position.tobytes()


def test_a_missing_library_is_named(tmp_path: Path) -> None:
    with pytest.raises(EnvironmentFault, match=r"hard_discs\.so.*pip install"):
        module.load(tmp_path / "hard_discs.so")

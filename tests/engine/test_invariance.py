"""What must not matter: ranks, Newton's third law across ranks, skin, labels, orientation, place, output."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from workflow.data.frame import Frame

LAW = {"kn": 1e4, "kt": 8e3, "zeta": 0.4, "mu": 0.15, "f0": 0.5, "d0": 5e-3, "kr": 2.0, "mur": 1e-2}
COMMON = {"law": LAW, "step": 2e-4, "move": "stress 20 20 rate 0.4"}
STEPS = 1500
# Rounding of positions at 1e-15 times K_N dt enters velocities; the collisions of 1500 steps amplify it, and forces are
# K_N times positions.  Runs that differ by physics instead of rounding differ by more than 0.1 in velocity.
TOLERANCE = 1e-7


@pytest.fixture
def compressed(gas: Callable[..., Any]) -> dict[str, Any]:
    """A gas that is driven together and slides and rolls in contact."""
    return {**gas(50, 0.55, seed=11, speed=1.0), **COMMON}


def same(frame: Frame, other: Frame, tolerance: float = TOLERANCE) -> None:
    """Assert equal states: grains, pairs, contact memory and flags."""
    away = (frame.position - other.position + frame.cell / 2.0) % frame.cell - frame.cell / 2.0
    assert max(np.abs(away).max(), np.abs(frame.cell - other.cell).max()) < tolerance
    for name in ("velocity", "omega"):
        np.testing.assert_allclose(getattr(frame, name), getattr(other, name), rtol=0.0, atol=10.0 * tolerance)
    np.testing.assert_allclose(frame.force, other.force, rtol=0.0, atol=LAW["kn"] * tolerance)
    one, two = frame.interactions, other.interactions
    assert one.i.tolist() == two.i.tolist() and one.j.tolist() == two.j.tolist()
    for name in ("gap", "xi_t", "xi_r"):
        np.testing.assert_allclose(getattr(one, name), getattr(two, name), rtol=0.0, atol=tolerance)
    assert one.sliding.any() and one.rolling.any() and not one.sliding.all()
    assert np.array_equal(one.sliding, two.sliding) and np.array_equal(one.rolling, two.rolling)


def transformed(
    scene: dict[str, Any], order: Any = slice(None), turn: Any = ((1, 0), (0, 1)), shift: Any = (0, 0)
) -> dict[str, Any]:
    """The scene with rows in another order, rotated, shifted across the periodic boundary."""
    position = (scene["position"][order] @ np.transpose(turn) + shift) % scene["cell"][0]
    moved = {"position": position, "velocity": scene["velocity"][order] @ np.transpose(turn)}
    return {**scene, **moved, "omega": scene["omega"][order], "diameter": scene["diameter"][order]}


@pytest.mark.parametrize("change", [{"newton": "off"}, {"skin": 0.02}, {"skin": 0.05}, {"skin": 0.3}], ids=str)
def test_newton_and_skin_do_not_change_the_trajectory(
    discs: Callable[..., Any], compressed: dict[str, Any], change: dict[str, Any]
) -> None:
    plain = discs(**compressed).run(STEPS)
    same(plain.frame(), discs(**{**compressed, **change}).run(STEPS).frame())


@pytest.mark.parametrize("newton", ["on", "off"])
@pytest.mark.parametrize("number", [2, pytest.param(4, marks=pytest.mark.validation)])  # 4 ranks on 2 cores: 40 s
def test_ranks_do_not_change_the_trajectory(
    discs: Callable[..., Any], ranks: Callable[..., Frame], compressed: dict[str, Any], number: int, newton: str
) -> None:
    """A small skin: grains migrate between ranks with their contacts."""
    plain = discs(**compressed).run(STEPS)
    compressed["skin"] = 0.03
    same(plain.frame(), ranks(number, f"run {STEPS}", newton=newton, **compressed))


def test_labels_do_not_change_the_trajectory(discs: Callable[..., Any], compressed: dict[str, Any]) -> None:
    order = np.random.default_rng(1).permutation(50)
    plain = discs(**compressed).run(STEPS).frame()
    other = discs(**compressed, ids=1 + np.argsort(order)).run(STEPS).frame()
    # the grain of row k of the scene now has the label argsort(order)[k] + 1: rows of the frame are permuted by `order`
    back = np.argsort(order)
    np.testing.assert_allclose(other.velocity[back], plain.velocity, rtol=0.0, atol=TOLERANCE)
    np.testing.assert_allclose(other.omega[back], plain.omega, rtol=0.0, atol=10.0 * TOLERANCE)
    pairs = {tuple(sorted((order[i], order[j]))) for i, j in zip(other.interactions.i, other.interactions.j, strict=True)}
    assert pairs == set(zip(plain.interactions.i, plain.interactions.j, strict=True))


def test_rotation_by_90_degrees_rotates_the_trajectory(discs: Callable[..., Any], compressed: dict[str, Any]) -> None:
    turn = np.array([[0, -1], [1, 0]])
    plain = discs(**compressed).run(STEPS).frame()
    other = discs(**transformed(compressed, turn=turn)).run(STEPS).frame()
    same(other, replace(plain, cell=plain.cell[::-1], position=plain.position @ turn.T,
                        velocity=plain.velocity @ turn.T, force=plain.force @ turn.T))  # fmt: skip


def test_shift_across_the_periodic_boundary_shifts_the_trajectory(
    discs: Callable[..., Any], compressed: dict[str, Any]
) -> None:
    """A shift by a fraction of the cell moves with it as the cell shrinks."""
    shift = np.array([0.37, 0.81])
    plain = discs(**compressed).run(STEPS).frame()
    length = compressed["cell"][0]
    other = discs(**transformed(compressed, shift=shift * length)).run(STEPS).frame()
    same(other, replace(plain, position=plain.position + shift * plain.cell))


def test_reflection_reverses_spins(discs: Callable[..., Any], compressed: dict[str, Any]) -> None:
    mirror = np.diag([1, -1])
    plain = discs(**compressed).run(STEPS).frame()
    scene = transformed(compressed, turn=mirror)
    other = discs(**{**scene, "omega": -scene["omega"]}).run(STEPS).frame()
    np.testing.assert_allclose(other.velocity, plain.velocity @ mirror, rtol=0.0, atol=TOLERANCE)
    np.testing.assert_allclose(other.omega, -plain.omega, rtol=0.0, atol=10.0 * TOLERANCE)
    np.testing.assert_allclose(other.interactions.xi_t, -plain.interactions.xi_t, rtol=0.0, atol=TOLERANCE)


def test_output_does_not_change_the_trajectory(discs: Callable[..., Any], compressed: dict[str, Any]) -> None:
    """Bit by bit: grains, contact forces and memory."""
    quiet, watched = discs(**compressed), discs(**compressed)
    watched.record(STEPS, 10)
    one, two = quiet.run(STEPS).frame(), watched.frame()
    for name in ("position", "velocity", "omega", "force", "torque", "cell"):
        assert np.array_equal(getattr(one, name), getattr(two, name)), name
    for name in ("xi_t", "xi_r", "viscous", "gap"):
        assert np.array_equal(getattr(one.interactions, name), getattr(two.interactions, name)), name


@pytest.mark.parametrize("account", ["yes", "no"])
def test_sums_do_not_change_the_trajectory(discs: Callable[..., Any], compressed: dict[str, Any], account: str) -> None:
    """Bit by bit, with and without the energy account; energies at every step or at the last."""
    plain = discs(**compressed).run(STEPS).frame()
    law = " ".join(f"{name} {value}" for name, value in LAW.items())
    first = f"pair_style disc/cohesive account {account}\npair_coeff * * {law}\nthermo 1\nrun 0"
    other = discs(**compressed, first=first).run(STEPS).frame()
    assert np.array_equal(plain.velocity, other.velocity) and np.array_equal(plain.position, other.position)


@pytest.mark.parametrize(
    "pieces", ["run 500\nrun 500 pre no\nrun 500 pre no", f"run 10\nrun {STEPS - 10} pre no every 250 NULL"]
)
def test_a_run_in_pieces_without_setup_is_the_run(discs: Callable[..., Any], compressed: dict[str, Any], pieces: str) -> None:
    """`run ... pre no` goes on with the neighbour list and the memory there is: bit by bit."""
    compressed["skin"] = 0.03
    # `every` sets up its first chunk even so, which evaluates damping at the full step: so does the twin
    whole = discs(**compressed).command(f"run 10\nrun {STEPS - 10}" if "every" in pieces else f"run {STEPS}").frame()
    parts = discs(**compressed).command(pieces).frame()
    assert np.array_equal(parts.velocity, whole.velocity)
    assert np.array_equal(parts.interactions.xi_t, whole.interactions.xi_t)


def test_checkpoints_do_not_change_the_trajectory(discs: Callable[..., Any], compressed: dict[str, Any], tmp_path: Any) -> None:
    """LAMMPS rebuilds its list at every checkpoint, which wraps positions and rounds them anew."""
    compressed["skin"] = 0.03
    plain = discs(**compressed).run(STEPS).frame()
    same(discs(**compressed, first=f"restart 50 {tmp_path / 'a'} {tmp_path / 'b'}\nrun 0").run(STEPS).frame(), plain)


def test_sorting_grains_in_memory_does_not_change_the_trajectory(
    discs: Callable[..., Any], compressed: dict[str, Any], rewrite: Callable[[str, str], None]
) -> None:
    compressed["skin"] = 0.03
    plain = discs(**compressed).run(STEPS).frame()
    rewrite("sort 0 0.0", "sort 1 1.0")
    same(discs(**compressed).run(STEPS).frame(), plain)


def test_neighbour_settings_of_lammps_do_not_change_the_trajectory(
    discs: Callable[..., Any], compressed: dict[str, Any], rewrite: Callable[[str, str], None]
) -> None:
    """Without `once yes` LAMMPS rebuilds at times of its own."""
    plain = discs(**compressed).run(STEPS).frame()
    rewrite("neigh_modify once yes", "neigh_modify delay 0 every 3 check no")
    same(discs(**compressed).run(STEPS).frame(), plain)


@pytest.mark.parametrize("newton", ["on", "off"])
def test_a_rank_without_grains_takes_part(discs: Callable[..., Any], ranks: Callable[..., Frame], newton: str) -> None:
    """Two discs collide near one side of a long cell and fly over to the other rank and back."""
    scene = {"position": np.array([[1.0, 1.5], [2.5, 1.6]]), "diameter": np.ones(2), "cell": (12.0, 3.0), "law": LAW,
             "velocity": np.array([[5.0, 0.0], [-1.0, 0.0]]), "omega": np.array([3.0, 1.0]), "step": 2e-4}  # fmt: skip
    plain = discs(**scene).run(9000).frame()
    other = ranks(2, "run 9000", newton=newton, **scene)
    assert np.abs(plain.velocity - scene["velocity"]).max() > 0.1
    np.testing.assert_allclose(other.velocity, plain.velocity, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(other.omega, plain.omega, rtol=0.0, atol=1e-9)

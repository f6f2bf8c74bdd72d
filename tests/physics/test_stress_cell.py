"""The stress-controlled cell, its conventions and the drag: closed forms of free discs, and a packing under stress."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

LENGTHS, STEP = np.array([12.0, 8.0]), 1e-3


@pytest.fixture
def spread() -> dict[str, Any]:
    """Twelve discs at rest, far apart."""
    position = np.stack(np.meshgrid(np.arange(4) * 3.0 + 1.0, np.arange(3) * 2.6 + 1.0), -1).reshape(-1, 2)
    return {
        "position": position,
        "diameter": np.linspace(0.5, 1.0, 12),
        "cell": LENGTHS,
        "law": {"kn": 1e3},
        "step": STEP,
    }


def inertia(scene: dict[str, Any], factor: float = 0.3) -> float:
    """M = factor sum(m)/L, L = sqrt(L_x L_y), of the equation of the strain."""
    return factor * float(np.sum(scene["diameter"] ** 2)) / math.sqrt(LENGTHS[0] * LENGTHS[1])


def weight(scene: dict[str, Any], factor: float = 0.6) -> float:
    """W = factor sum(m), of the equation of the lengths."""
    return factor * float(np.sum(scene["diameter"] ** 2))


def speeds(sample: Any, start: np.ndarray = LENGTHS) -> np.ndarray:
    """dL/dt of both axes, from d eps/dt, eps = 1 - L/start."""
    return -sample.vector("move", 4)[2:] * start


@pytest.mark.parametrize("factor", [0.3, 2.0])
def test_free_discs_follow_the_parabola(discs: Callable[..., Any], spread: dict[str, Any], factor: float) -> None:
    """G07 eq. 3: eps_a = P_a t^2/(2 M), for velocity Verlet as well; discs move affinely and stay at rest."""
    stress, mass, steps = np.array([0.02, -0.01]), inertia(spread, factor), 900
    sample = discs(**spread, move=f"stress {stress[0]} {stress[1]} cell strain mass {factor}").run(steps)
    frame, time = sample.frame(), steps * STEP
    strain = stress * time**2 / (2.0 * mass)
    # 900 sums of lengths near 10, each rounded at 1e-15
    np.testing.assert_allclose(frame.cell, LENGTHS * (1.0 - strain), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(frame.position, spread["position"] * (1.0 - strain), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(sample.vector("move", 6), [0, 0, *(stress * time / mass), 0, mass], rtol=1e-11, atol=1e-15)
    assert not frame.velocity.any() and not len(frame.interactions)


@pytest.mark.parametrize("options", ["", "mass 2"])
def test_one_free_length_follows_the_parabola(discs: Callable[..., Any], spread: dict[str, Any], options: str) -> None:
    """W d2L_y/dt2 = -L_x S with L_x fixed: L_y = L_y^0 - S L_x t^2/(2 W), W = 0.6 sum(m) where nothing is said."""
    stress, mass, steps = 0.02, weight(spread, 2.0 if options else 0.6), 900
    sample = discs(**spread, move=f"stress NULL {stress} {options}").run(steps)
    frame, time = sample.frame(), steps * STEP
    expected = LENGTHS - [0.0, stress * LENGTHS[0] * time**2 / (2.0 * mass)]
    # 900 sums of lengths near 10, each rounded at 1e-15
    np.testing.assert_allclose(frame.cell, expected, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(frame.position, spread["position"] * expected / LENGTHS, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(speeds(sample), [0.0, -stress * LENGTHS[0] * time / mass], rtol=1e-11)
    assert sample.vector("move", 6)[5] == pytest.approx(mass, rel=1e-14)


def test_two_free_lengths_pull_on_each_other(discs: Callable[..., Any], spread: dict[str, Any]) -> None:
    """W d2L_a/dt2 = -L_b S: L_x + L_y = s cos(w t) and L_x - L_y = d cosh(w t), w^2 = S/W."""
    stress, steps = 0.1, 900
    rate, time = math.sqrt(stress / weight(spread)), steps * STEP
    frame = discs(**spread, move=f"stress {stress} {stress} cell lengths").run(steps).frame()
    total, difference = LENGTHS.sum() * math.cos(rate * time), (LENGTHS[0] - LENGTHS[1]) * math.cosh(rate * time)
    expected = np.array([total + difference, total - difference]) / 2.0
    assert abs(expected - LENGTHS).min() > 0.02
    # velocity Verlet: (w dt)^2/24 of the way in phase, 1e-9 here
    np.testing.assert_allclose(frame.cell, expected, rtol=0.0, atol=1e-8)
    assert not frame.velocity.any()


def test_cell_of_lengths_conserves_the_enthalpy(discs: Callable[..., Any], gas: Callable[..., Any]) -> None:
    """Parrinello and Rahman's equation is that of a Hamiltonian: K + U + S L_x L_y + W (L_x'^2 + L_y'^2)/2 stays, with elastic
    discs and their convention (-1), to second order in the step; and the work of the cell is what K + U gains."""
    stress, scene = 3.0, gas(60, 0.5, seed=4, speed=1.0)
    start = np.asarray(scene["cell"])

    def enthalpy(sample: Any) -> tuple[float, float]:
        frame, move = sample.frame(), sample.vector("move", 6)
        own = frame.mass @ (frame.velocity**2).sum(axis=1) / 2.0 + frame.mass * frame.diameter**2 @ frame.omega**2 / 16.0
        grains = own + sample.energy().sum()
        moving = 0.5 * move[5] * np.sum(speeds(sample, start) ** 2)
        return grains + stress * np.prod(frame.cell) + moving, grains - move[4]

    drift, leak = [], []
    for refinement in (1, 4):
        sample = discs(**scene, law={"kn": 1e3}, step=1e-3 / refinement, move=f"stress {stress} {stress} convention -1")
        before = enthalpy(sample)
        after = enthalpy(sample.run(1500 * refinement))
        assert np.abs(speeds(sample, start)).max() > 0.1
        drift.append(abs(after[0] - before[0]))
        leak.append(abs(after[1] - before[1]))
    # (omega dt)^2/24 of the energy of contacts that begin and end within steps; a sixteenth of that with a quarter of the step
    for error in (drift, leak):
        assert error[0] < 1e-2 and error[1] < error[0] / 6


@pytest.mark.parametrize("cell", ["lengths", "strain"])
def test_wall_speed_is_capped(discs: Callable[..., Any], spread: dict[str, Any], cell: str) -> None:
    """|dL/dt| <= u on both axes whatever their lengths, also where the cell grows, and after a new stage."""
    cap = 0.3
    sample = discs(**spread, move=f"stress 0.5 -0.5 cell {cell} wall {cap}")
    for _ in range(20):
        now = speeds(sample.run(100))
        # d eps/dt is what is held: times L^0 it is the cap to rounding
        assert np.abs(now).max() <= cap * (1.0 + 1e-15)
    np.testing.assert_allclose(now, [-cap, cap], rtol=1e-15)
    lengths = sample.frame().cell
    sample.command("fix_modify move stress 0.5 -0.5").run(300)
    np.testing.assert_allclose(sample.frame().cell, lengths + 300 * STEP * cap * np.array([-1, 1]), rtol=1e-12)


def test_strain_rate_is_capped(discs: Callable[..., Any], spread: dict[str, Any]) -> None:
    """d eps/dt = P t/M up to the cap, constant afterwards; also where the cell grows."""
    cap, stress, mass = 0.05, 0.1, inertia(spread)
    reached = cap * mass / stress
    sample = discs(**spread, move=f"stress {stress} -{stress} cell strain mass 0.3 rate {cap}")
    for steps in (400, 1600):
        sample.run(steps)
        time = sample.value("step") * STEP
        strain = stress * time**2 / (2.0 * mass) if time < reached else cap * (time - reached / 2.0)
        # the cap is reached within a step: an error of cap*STEP at most
        np.testing.assert_allclose(
            sample.frame().cell, LENGTHS * (1.0 + strain * np.array([-1, 1])), rtol=0.0, atol=12 * cap * STEP
        )
        assert np.abs(sample.vector("move", 4)[2:]).max() <= cap
    assert sample.vector("move", 4)[2:].tolist() == [cap, -cap]


def test_a_null_axis_is_fixed(discs: Callable[..., Any], spread: dict[str, Any]) -> None:
    frame = discs(**spread, move="stress NULL 0.02").run(500).frame()
    assert frame.cell[0] == LENGTHS[0] and frame.cell[1] < LENGTHS[1] - 1e-3
    assert np.array_equal(frame.position[:, 0], spread["position"][:, 0])


def test_new_targets_start_a_new_stage(discs: Callable[..., Any], spread: dict[str, Any]) -> None:
    """The cell keeps dL/dt; strain then counts from the new length, and M is 0.3 sum(m)/L of that cell."""
    first, second, steps = 0.02, 0.05, 500
    sample = discs(**spread, move=f"stress {first} {first} cell strain mass 0.3").run(steps)
    time, mass = steps * STEP, inertia(spread)
    lengths, speed = sample.frame().cell, LENGTHS * first * time / mass
    sample.command(f"fix_modify move stress {second} {second}").run(steps)
    again = mass * math.sqrt(np.prod(LENGTHS) / np.prod(lengths))
    assert sample.vector("move", 6)[5] == pytest.approx(again, rel=1e-12)
    expected = lengths - speed * time - lengths * second * time**2 / (2.0 * again)
    np.testing.assert_allclose(sample.frame().cell, expected, rtol=0.0, atol=1e-12)


def test_a_new_stage_leaves_the_equation_of_the_lengths(discs: Callable[..., Any], spread: dict[str, Any]) -> None:
    """dL/dt and W stay: one stress in two stages is the same motion as in one."""
    move, parts = "stress 0.05 0.02 cell lengths", []
    whole = discs(**spread, move=move).run(800)
    split = discs(**spread, move=move).run(400).command("fix_modify move stress 0.05 0.02").run(400)
    for sample in (whole, split):
        parts.append(sample.frame().cell)
        assert sample.vector("move", 6)[5] == pytest.approx(weight(spread), rel=1e-14)
    # strain counts from another length: other rounding in each of 400 steps
    np.testing.assert_allclose(parts[1], parts[0], rtol=1e-13)
    assert np.abs(parts[0] - LENGTHS).min() > 0.01


def test_quench_brings_the_cell_to_rest_and_leaves_the_grains(discs: Callable[..., Any], spread: dict[str, Any]) -> None:
    """Walls that move against the stress that is left stop at once; velocities of grains stay, and nothing is taken from them."""
    velocity = np.random.default_rng(1).normal(scale=1e-3, size=(12, 2))
    sample = discs(**spread, velocity=velocity, move="stress 0.5 0.5 mass 1e3").run(300)
    rate = sample.vector("move", 4)[2:]
    sample.command("fix_modify move stress -0.5 -0.5")
    sample.run(10)
    assert (sample.vector("move", 4)[2:] > 0.9 * rate).all() and (rate > 0.0).all()  # a cell that is let alone goes on
    sample.command("fix_modify move quench 1").run(1)
    # what is left is what the stress gives in one step and a half
    assert (sample.vector("move", 4)[2:] <= 0.0).all() and (sample.vector("move", 4)[2:] > -0.05 * rate).all()
    np.testing.assert_array_equal(sample.frame().velocity, velocity)
    assert sample.vector("move", 7)[6] == 0.0


@pytest.mark.parametrize("convention", [-1, 0, 1])
def test_free_velocities_scale_with_the_cell(discs: Callable[..., Any], spread: dict[str, Any], convention: int) -> None:
    """m dv/dt = c m (dL/dt/L) v: v ~ L^c along each axis, whatever the cell does; the spin stays."""
    velocity = np.random.default_rng(1).normal(scale=0.05, size=(12, 2))
    spread |= {"velocity": velocity, "omega": np.linspace(-1, 1, 12)}
    sample = discs(**spread, move=f"stress 1e9 -1e9 rate 0.1 convention {convention}").run(600)
    frame = sample.frame()
    assert not len(frame.interactions) and abs(frame.cell[0] / LENGTHS[0] - 0.94) < 1e-9
    # the factor is exp(-c d eps/dt dt/2) with L at either end of the step: the error of a step is of third order
    np.testing.assert_allclose(frame.velocity, velocity * (frame.cell / LENGTHS) ** convention, rtol=1e-7, atol=0.0)
    np.testing.assert_array_equal(frame.omega, spread["omega"])
    # what convention +-1 gives to the grains is work of the cell
    before, after = (np.sum(spread["diameter"][:, None] ** 2 * v**2) / 2.0 for v in (velocity, frame.velocity))
    assert sample.vector("move", 6)[4] == pytest.approx(after - before, abs=1e-6 * before)


def test_stress_of_free_discs_is_the_kinetic_one(discs: Callable[..., Any], spread: dict[str, Any]) -> None:
    velocity = np.random.default_rng(1).normal(scale=0.05, size=(12, 2))
    sample = discs(**spread, velocity=velocity, move="stress 0 0 mass 1e9")
    expected = spread["diameter"] ** 2 @ velocity**2 / np.prod(LENGTHS)
    np.testing.assert_allclose(sample.vector("move", 2), expected, rtol=1e-13)


@pytest.mark.parametrize("shares", ["1 1", "1.5 1"])
def test_a_packing_reaches_the_imposed_stress(discs: Callable[..., Any], gas: Callable[..., Any], shares: str) -> None:
    """Cohesionless discs, compressed from a gas at rest: stress = sum over contacts of F r/A in the end."""
    scene = gas(80, 0.5, seed=9, speed=0.0)
    law = {"kn": 1e3, "kt": 1e3, "mu": 0.3, "zeta": 0.8}
    sample = discs(**scene, law=law, step=2e-3, move=f"stress {shares} drag 0.2").run(60000)
    frame = sample.frame()
    stress = (frame.interactions.force * frame.interactions.branch).sum(axis=0) / frame.area
    # 100 time units of drag at a rate of 0.2 to 0.4 leave exp(-20) of the last vibrations; measured 1e-7
    np.testing.assert_allclose(stress, [float(s) for s in shares.split()], rtol=1e-5)
    np.testing.assert_allclose(sample.vector("move", 2), stress, rtol=1e-5)
    assert np.pi / 4.0 * np.sum(frame.diameter**2) / frame.area > 0.75


@pytest.mark.parametrize("stress", ["", "stress 1e-9 1e-9 mass 1e9"])
def test_drag_slows_free_discs_and_is_accounted(discs: Callable[..., Any], spread: dict[str, Any], stress: str) -> None:
    """v, w ~ exp(-g t), and the energy taken is the kinetic energy that is gone."""
    drag, steps = 0.7, 500
    velocity = np.random.default_rng(1).normal(scale=0.05, size=(12, 2))
    omega = np.linspace(-1, 1, 12)
    sample = discs(**spread, velocity=velocity, omega=omega, move=f"{stress} drag {drag}").run(steps)
    kept, frame = math.exp(-drag * steps * STEP), sample.frame()
    # 1000 factors exp(-g dt/2), each rounded at 1e-16
    np.testing.assert_allclose(frame.velocity, kept * velocity, rtol=1e-12, atol=0.0)
    np.testing.assert_allclose(frame.omega, kept * omega, rtol=1e-12, atol=0.0)
    mass, inertia = frame.mass, frame.mass * frame.diameter**2 / 8.0
    energy = (mass @ (velocity**2).sum(axis=1) + inertia @ omega**2) / 2.0
    assert sample.vector("move", 7)[6] == pytest.approx(energy * (1.0 - kept**2), rel=1e-11)


def test_drag_beside_fixed_discs_is_accounted(
    discs: Callable[..., Any], spread: dict[str, Any], rewrite: Callable[[str, str], None]
) -> None:
    """A disc that does not move takes no part: its energy is 0, not 0/0."""
    drag, steps = 0.7, 500
    rewrite("fix move", "group held id 1\nfix move")
    sample = discs(**spread, velocity=0.1, move=f"drag {drag} fixed held").run(steps)
    energy = 0.5 * sample.frame().mass[1:].sum() * 2.0 * 0.1**2
    # rounding of 500 sums
    assert sample.vector("move", 7)[6] == pytest.approx(energy * (1.0 - math.exp(-2.0 * drag * steps * STEP)), rel=1e-11)


def test_drag_switched_off_and_on_acts_when_it_is_on(discs: Callable[..., Any], spread: dict[str, Any]) -> None:
    sample = discs(**spread, velocity=0.1).run(100)
    assert np.array_equal(sample.frame().velocity, np.full((12, 2), 0.1))
    sample.command("fix_modify move drag 1").run(100).command("fix_modify move drag 0").run(100)
    np.testing.assert_allclose(sample.frame().velocity, 0.1 * math.exp(-0.1), rtol=1e-13)


@pytest.mark.parametrize("newton", ["on", "off"])
def test_stress_is_the_pressure_of_lammps(discs: Callable[..., Any], gas: Callable[..., Any], newton: str) -> None:
    """Two sums of the same: by the fix that moves the cell, and by compute pressure."""
    law = {"kn": 1e3, "kt": 1e3, "mu": 0.3, "zeta": 0.4, "f0": 0.5, "d0": 1e-2}
    sample = discs(**gas(50, 0.5, seed=9), law=law, step=1e-3, newton=newton, move="stress 3 2",
                   first="thermo_style custom step pxx pyy pxy c_energy\nrun 1000")  # fmt: skip
    stress = sample.vector("move", 2)
    np.testing.assert_allclose([sample.value("pxx"), sample.value("pyy")], stress, rtol=1e-12)

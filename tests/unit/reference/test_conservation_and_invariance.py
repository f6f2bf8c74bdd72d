"""Energy, momentum, angular momentum, symmetry, convergence and restarts of runs with everything switched on."""

import numpy as np
import pytest

from workflow.reference.cohesive import CohesiveLaw
from workflow.reference.discs import Discs, Trajectory, pair_list
from workflow.reference.integrate import integrate

FULL = CohesiveLaw(kn=1e4, kt=8e3, zeta=0.2, mu=0.3, f0=1.0, d0=1e-3, kr=1.0, mur=1e-3)
LAWS = {
    "full": FULL,
    "cohesionless": CohesiveLaw(kn=1e4, kt=1e4, zeta=0.3, mu=0.5),
    "elastic": CohesiveLaw(kn=1e4, f0=1.0, d0=1e-2),
    "no rolling, undamped": CohesiveLaw(kn=1e4, kt=5e3, mu=0.15, f0=1.0, d0=1e-3),
    "never slips": CohesiveLaw(kn=1e4, kt=5e3, zeta=0.1, mu=np.inf, f0=1.0, d0=1e-3, kr=1.0, mur=np.inf),
    "stiff": CohesiveLaw(kn=1e8, kt=1e8, zeta=0.8, mu=0.5, f0=1.0, d0=1e-6, kr=1e4, mur=5e-3),
}


def collision() -> Discs:
    """Four unequal discs flying at each other, spinning."""
    position = np.array([[0.0, 0.0], [0.93, 0.02], [0.45, 0.76], [0.4, -0.8]])
    velocity = np.array([[0.5, 0.1], [-0.6, 0.0], [0.1, -0.4], [-0.1, 0.5]])
    return Discs(position, velocity, np.array([2.0, -1.0, 0.3, 4.0]), np.array([1.0, 0.85, 0.75, 0.78]))


def run_collision(law: CohesiveLaw, discs: Discs | None = None, rtol: float = 1e-12, rows: int = 31) -> Trajectory:
    t_end = 0.02 if law.kn > 1e6 else 0.1
    return integrate(law, discs or collision(), t_end, t_eval=np.linspace(0.0, t_end, rows), rtol=rtol)


@pytest.mark.parametrize("name", LAWS)
def test_energy_account_closes_and_momentum_is_exact(name: str) -> None:
    run = run_collision(LAWS[name])
    energy, mass = run.energy, run.start.mass
    assert len(run.times_of("close")) >= 2
    # rtol 1e-12 over some hundred steps
    assert np.abs(energy.residual).max() < 1e-10 * energy.kinetic[0]
    for lost in (energy.viscous, energy.sliding, energy.rolling_friction, energy.opening):
        assert np.all(np.diff(lost) >= 0.0)
    momentum = (mass[:, None] * run.velocity).sum(axis=1)
    # rounding of sums of contact forces: 2e-16 relative per step, forces integrate to momenta of order 1
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), rtol=0.0, atol=1e-13)


def test_dissipation_only_where_the_law_has_it() -> None:
    lost = {name: run_collision(law, rows=2).energy for name, law in LAWS.items() if name != "stiff"}
    assert lost["elastic"].lost[-1] == 0.0
    assert lost["no rolling, undamped"].viscous[-1] == 0.0 < lost["no rolling, undamped"].sliding[-1]
    assert lost["never slips"].sliding[-1] == lost["never slips"].rolling_friction[-1] == 0.0
    full = lost["full"]
    assert min(full.viscous[-1], full.sliding[-1], full.rolling_friction[-1]) > 1e-6
    # at finite mu the limit is 0 where a contact opens: a spring holds nothing but the event tolerance then
    assert 0.0 <= full.opening[-1] < 1e-12


def test_angular_momentum_changes_at_the_rate_of_gap_times_tangential_force() -> None:
    """The moments use the radii, not the distance (G07 eq. 9): dL/dt = sum h T, not 0, in an overlapping contact."""
    law = CohesiveLaw(kn=1e2, kt=1e2, zeta=0.2, mu=0.3, f0=1.0, d0=1e-3, kr=0.01, mur=1e-2)
    run = integrate(law, collision(), 0.2, t_eval=np.linspace(0.0, 0.2, 2001))
    mass, inertia = run.start.mass, 1.0 / run.start.inverse_inertia
    cross = run.position[..., 0] * run.velocity[..., 1] - run.position[..., 1] * run.velocity[..., 0]
    angular = cross @ mass + run.omega @ inertia
    rate = (np.where(run.gap < 0.0, run.gap, 0.0) * run.tangential).sum(axis=1)
    integral = np.concatenate(([0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(run.time))))
    change = angular - angular[0]
    assert np.abs(change).max() > 1e-3
    # trapezoidal rule with some 400 points per contact and kinks at the events: about 1e-5
    np.testing.assert_allclose(change, integral, rtol=0.0, atol=1e-4 * np.abs(change).max())


def relabelled(discs: Discs, order: list[int]) -> Discs:
    return Discs(*(getattr(discs, name)[order] for name in ("position", "velocity", "omega", "diameter", "mass")))


def moved(discs: Discs, matrix: np.ndarray, shift: tuple[float, float] = (0.0, 0.0)) -> Discs:
    """Image under a rotation or reflection ``matrix`` (a reflection reverses spins) and a shift."""
    omega = discs.omega * np.linalg.det(matrix)
    return Discs(discs.position @ matrix.T + shift, discs.velocity @ matrix.T, omega, discs.diameter)


@pytest.mark.parametrize("law", [FULL, LAWS["stiff"]], ids=["full", "stiff"])
@pytest.mark.parametrize("matrix", [[[0, -1], [1, 0]], [[1, 0], [0, -1]], [[0.6, -0.8], [0.8, 0.6]]])
def test_rotation_reflection_and_shift_move_the_trajectory_along(law: CohesiveLaw, matrix: list[list[float]]) -> None:
    turn = np.array(matrix, dtype=float)
    plain = run_collision(law, rows=5)
    other = run_collision(law, moved(collision(), turn, shift=(0.25, -0.5)), rows=5)
    # the shift rounds positions at 1e-16: K_N/F0 times that in the forces, amplified by several collisions
    np.testing.assert_allclose(other.velocity, plain.velocity @ turn.T, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(other.omega, plain.omega * np.linalg.det(turn), rtol=0.0, atol=1e-8)


def test_relabelling_changes_no_motion() -> None:
    order = [2, 0, 3, 1]
    plain, other = run_collision(FULL, rows=5), run_collision(FULL, relabelled(collision(), order), rows=5)
    # only the order of sums differs
    np.testing.assert_allclose(other.velocity, plain.velocity[:, order], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(other.omega, plain.omega[:, order], rtol=0.0, atol=1e-9)
    named = [(event.kind, tuple(sorted(order[k] for k in event.pair))) for event in other.events]
    assert named == [(event.kind, event.pair) for event in plain.events]
    assert [event.time for event in other.events] == pytest.approx([event.time for event in plain.events], abs=1e-9)


def test_common_velocity_changes_nothing() -> None:
    discs = collision()
    drift = np.array([0.7, -0.3])
    plain = run_collision(FULL, rows=5)
    other = run_collision(FULL, Discs(discs.position, discs.velocity + drift, discs.omega, discs.diameter), rows=5)
    np.testing.assert_allclose(other.velocity - drift, plain.velocity, rtol=0.0, atol=1e-9)


def test_converges_with_the_tolerance() -> None:
    finest = run_collision(FULL, rtol=1e-13, rows=5)
    runs = [run_collision(FULL, rtol=rtol, rows=5) for rtol in (1e-5, 1e-8, 1e-11)]
    errors = [np.abs(run.velocity - finest.velocity).max() for run in runs]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-9  # a hundred steps and a few collisions at 1e-11


@pytest.mark.parametrize("fraction", [0.2, 0.35, 0.5, 0.65])
def test_a_run_continues_from_its_last_state(fraction: float) -> None:
    whole = integrate(FULL, collision(), 0.1)
    first = integrate(FULL, collision(), 0.1 * fraction)
    second = integrate(FULL, first.discs(), 0.1 * (1.0 - fraction))
    # absolute positions are rounded once more on the way: 1e-16 against overlaps of 1e-4
    np.testing.assert_allclose(second.velocity[-1], whole.velocity[-1], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(second.xi_t[-1], whole.xi_t[-1], rtol=0.0, atol=1e-12)
    kinds = [event.kind for event in first.events + second.events]
    assert kinds == [event.kind for event in whole.events]


def test_forces_are_minus_the_gradient_of_the_stored_energy() -> None:
    """Across tail and contact, elastic law: difference quotient of the energies of neighbouring states."""
    law, step = LAWS["elastic"], 1e-7
    for gap in (-5e-4, -1e-5, 2e-3, 9e-3, 2e-2):

        def stored(shift: float, gap: float = gap) -> Trajectory:
            position = np.array([[0.0, 0.0], [0.0, 1.0 + gap + shift]])
            return integrate(law, Discs(position, np.zeros((2, 2)), np.zeros(2), np.ones(2)), 1e-6)

        slope = (stored(step).energy.stored[0] - stored(-step).energy.stored[0]) / (2.0 * step)
        # quadratic energies: exact but for rounding, 1e-16 K_N*gap/step
        assert stored(0.0).normal[0, 0] == pytest.approx(-slope, abs=1e-7)


def test_pairs_are_listed_in_row_order() -> None:
    assert pair_list(3).tolist() == [[0, 1], [0, 2], [1, 2]]
    assert integrate(FULL, collision(), 1e-3).pairs.tolist() == pair_list(4).tolist()

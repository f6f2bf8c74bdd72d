"""Floppy modes leave gaps unchanged; self-stresses balance every grain; both are local where the network is."""

import numpy as np
import pytest
from networks import angle_between, double_triangle, packing, ring, row, strip, together, triangular

from workflow.data.contact_law import ContactLaw
from workflow.measures.modes import floppy_modes, hyperstatic_clusters, mobility, self_stress, without_loose
from workflow.measures.rigidity import rigidity

MODELS = [(False, False, False), (True, False, False), (True, False, True), (True, True, False), (True, True, True)]
LAW = ContactLaw(kn=1.0, kt=1.0, kr=1.0)


@pytest.mark.parametrize(("friction", "rolling", "free_cell"), MODELS)
def test_floppy_modes_are_an_orthonormal_basis_beyond_the_translations(friction, rolling, free_cell):
    frame = packing(50, 0.4, 2)
    model = {"friction": friction, "rolling": rolling, "free_cell": free_cell}
    modes = floppy_modes(frame, **model)
    assert len(modes.grains) == rigidity(frame, law=LAW, **model).mechanisms
    length = frame.diameter.mean()
    flat = np.hstack(((modes.grains * [1.0, 1.0, length]).reshape(len(modes.grains), -1), modes.cell * length))
    # 1e-12: round-off of orthogonalising some 150 vectors of 150 entries.
    np.testing.assert_allclose(flat @ flat.T, np.eye(len(flat)), atol=1e-12)
    np.testing.assert_allclose(modes.grains[:, :, :2].sum(axis=1), 0.0, atol=1e-12)


def test_floppy_modes_change_gaps_and_contact_points_only_to_second_order():
    """Move the grains and the cell by s times a mode: branches stretch by order s^2 and contacts do not slip."""
    frame = packing(40, 0.55, 7)
    pairs, radius = frame.interactions, 0.5 * frame.diameter
    share = radius[pairs.i] / (radius[pairs.i] + radius[pairs.j])
    modes = floppy_modes(frame, free_cell=True)
    step = 1e-5
    for motion, strain in zip(modes.grains, modes.cell, strict=True):
        shift, omega = step * motion[:, :2], step * motion[:, 2]
        branch = pairs.branch * (1.0 - step * strain) + shift[pairs.j] - shift[pairs.i]
        xi_t = np.hypot(*branch.T) - pairs.distance
        turn = angle_between(pairs.branch, branch)
        slip = pairs.distance * (share * omega[pairs.i] + (1.0 - share) * omega[pairs.j] - turn)
        # Second order: displacements are at most 1e-5, squared over a branch of at least 0.5 gives 2e-10.
        assert np.abs(xi_t).max() < 1e-9
        assert np.abs(slip).max() < 1e-9


def test_the_only_mechanism_of_a_free_cluster_is_its_rotation():
    frame = double_triangle()
    modes = floppy_modes(frame)
    (motion,) = modes.grains
    omega = motion[:, 2]
    np.testing.assert_allclose(omega, omega[0], rtol=1e-10)
    np.testing.assert_allclose(motion[:, 0], -omega[0] * frame.position[:, 1], atol=1e-12)
    np.testing.assert_allclose(motion[:, 1], omega[0] * frame.position[:, 0], atol=1e-12)


@pytest.mark.parametrize(("friction", "rolling", "free_cell"), MODELS)
def test_self_stresses_balance_every_grain(friction, rolling, free_cell):
    """Sum the forces and torques on every grain directly; in a free cell the mean stress vanishes too."""
    frame = packing(50, 0.92, 4)
    pairs = frame.interactions
    model = {"friction": friction, "rolling": rolling, "free_cell": free_cell}
    stress = self_stress(frame, **model)
    assert stress.normal.shape[0] == rigidity(frame, law=LAW, **model).hyperstaticity > 0
    systems = (part.toarray() for part in (stress.normal, stress.tangential, stress.moment))
    arm = pairs.distance / (frame.diameter[pairs.i] + frame.diameter[pairs.j])
    n = pairs.normal
    t = np.column_stack((-n[:, 1], n[:, 0]))
    for normal, tangential, moment in zip(*systems, strict=True):
        force = normal[:, None] * n + tangential[:, None] * t
        total, torque = np.zeros((frame.grains, 2)), np.zeros(frame.grains)
        np.add.at(total, pairs.j, force)
        np.subtract.at(total, pairs.i, force)
        # The contact point lies at +arm_i n from i, where i feels -T t, and at -arm_j n from j, where j feels +T t.
        np.subtract.at(torque, pairs.i, arm * frame.diameter[pairs.i] * tangential + moment)
        np.subtract.at(torque, pairs.j, arm * frame.diameter[pairs.j] * tangential - moment)
        size = max(np.abs(normal).max(), np.abs(tangential).max(), np.abs(moment).max())
        # Entries below 1e-11 of the vector are dropped, a few tens of them may meet on the way.
        assert np.abs(total).max() < 1e-9 * size
        assert np.abs(torque).max() < 1e-9 * size
        if free_cell:
            assert np.abs((force * pairs.branch).sum(axis=0)).max() < 1e-9 * size * len(pairs)


def test_forces_in_the_double_triangle_follow_g07():
    """G07 eq. 20 and fig. 18: |T/N| = sqrt(3) in the four outer contacts; equal discs leave T = 0 in the middle one."""
    frame = double_triangle()
    stress = self_stress(frame)
    (normal,), (tangential,) = stress.normal.toarray(), stress.tangential.toarray()
    middle = (frame.interactions.i == 0) & (frame.interactions.j == 1)
    np.testing.assert_allclose(np.abs(tangential / normal)[~middle], np.sqrt(3.0), rtol=1e-10)
    np.testing.assert_allclose(tangential[middle] / normal[middle], 0.0, atol=1e-12)
    assert np.ptp(np.sign(normal[~middle])) == 0.0
    assert normal[middle] * normal[~middle][0] < 0.0
    np.testing.assert_array_equal(stress.clusters, 0)


def test_hyperstatic_clusters_are_separated_and_numbered_by_size():
    """A strip (27 extra bars), two double triangles and an isostatic row: three clusters, each system inside one."""
    frame = together(double_triangle(), strip(30), row(5), double_triangle())
    stress = self_stress(frame)
    sizes = np.bincount(stress.clusters + 1)
    np.testing.assert_array_equal(sizes, [4, 57, 5, 5])
    assert stress.clusters[0] == 1 and stress.clusters[-1] == 2
    for system in range(stress.normal.shape[0]):
        carrying = np.union1d(stress.normal[[system]].indices, stress.tangential[[system]].indices)
        assert len(np.unique(stress.clusters[carrying])) == 1


def test_networks_without_self_stress_or_mechanism_give_empty_bases():
    stress = self_stress(row(6))
    assert stress.normal.shape == (0, 5)
    np.testing.assert_array_equal(stress.clusters, -1)
    assert floppy_modes(triangular(4)).grains.shape == (0, 16, 3)
    assert self_stress(ring(5), friction=False, free_cell=True).normal.shape == (0, 5)


@pytest.mark.parametrize(("friction", "rolling"), [(False, False), (True, False), (True, True)])
def test_mobility_is_the_diagonal_of_the_projector_on_the_modes(friction, rolling):
    """Twin: the squares of the orthonormal modes, lengths and angles in the same unit, summed over modes."""
    frame = packing(40, 0.6, seed=5)
    modes = floppy_modes(frame, friction=friction, rolling=rolling).grains
    assert len(modes)
    twin = (modes**2 * [1.0, 1.0, frame.diameter.mean() ** 2]).sum(axis=(0, 2))
    found = mobility(frame, friction=friction, rolling=rolling)
    assert found.mechanisms == len(modes)
    assert found.grains == pytest.approx(twin, abs=1e-7)  # the square root of rounding: both come from a product B^T B


def test_a_loose_grain_moves_freely_and_can_be_left_out():
    frame = together(strip(6), row(1))
    alone = mobility(frame).grains[-1]
    assert alone == pytest.approx(3.0 - 2.0 / frame.grains)  # its motions less its part of the translations
    held = without_loose(frame)
    assert held.grains == frame.grains - 1
    assert held.interactions.i.max() < held.grains
    assert mobility(held).mechanisms == mobility(frame).mechanisms - 3


@pytest.mark.parametrize(("friction", "rolling"), [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize("seed", range(3))
def test_clusters_without_a_basis_are_the_supports_of_the_basis(friction, rolling, seed):
    frame = packing(60, 0.82, seed=seed)
    basis = self_stress(frame, friction=friction, rolling=rolling)
    clusters, states = hyperstatic_clusters(frame, friction=friction, rolling=rolling)
    support = np.asarray((abs(basis.normal) + abs(basis.tangential) + abs(basis.moment)).sum(axis=0)).ravel() > 1e-9
    assert ((clusters >= 0) == support).all()
    assert states.sum() == basis.normal.shape[0]
    assert states.min(initial=1) >= 1  # a cluster without a system of its own would be none


def test_two_double_triangles_hold_one_system_each():
    clusters, states = hyperstatic_clusters(together(double_triangle(), row(3), double_triangle()))
    assert states.tolist() == [1, 1]
    assert np.bincount(clusters[clusters >= 0]).tolist() == [5, 5]

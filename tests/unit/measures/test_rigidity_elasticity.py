"""Stiffness, moduli and vibrations against finite differences of an energy, lattice theory and dense algebra."""

from dataclasses import replace

import numpy as np
import pytest
from networks import angle_between, frame_of, packing, ring, strip, together, triangular

from workflow.data.contact_law import ContactLaw
from workflow.errors import InputError
from workflow.measures.elasticity import elastic_moduli, vibrations
from workflow.measures.network import degrees, stiffness_matrix
from workflow.measures.rigidity import rigidity

LAW = ContactLaw(kn=1.0, kt=0.6, kr=0.05)


def energy(frame, motion, per_grain, law, rest):
    """Elastic energy of finite displacements: gaps from true distances, slip from true angles of turn and radii."""
    pairs, radius = frame.interactions, 0.5 * frame.diameter
    grains, strain = motion[: per_grain * frame.grains].reshape(-1, per_grain), motion[per_grain * frame.grains :]
    branch = pairs.branch * (1.0 - (strain if len(strain) else 0.0)) + grains[pairs.j, :2] - grains[pairs.i, :2]
    total = 0.5 * law.kn * (np.hypot(*branch.T) - rest) ** 2
    if per_grain == 3:
        spin_i, spin_j = grains[pairs.i, 2], grains[pairs.j, 2]
        turn = angle_between(pairs.branch, branch)
        slip = radius[pairs.i] * spin_i + radius[pairs.j] * spin_j - pairs.distance * turn
        total = total + 0.5 * law.kt * slip**2 + 0.5 * law.kr * (spin_i - spin_j) ** 2
    return total.sum()


def hessian(function, size, step=1e-3):
    """Second derivatives at the origin by central differences."""
    unit = step * np.eye(size)
    return np.array([[function(a + b) - function(a - b) - function(b - a) + function(-a - b) for b in unit] for a in unit]) / (
        4.0 * step**2
    )


@pytest.mark.parametrize("free_cell", [False, True])
@pytest.mark.parametrize(("friction", "rolling"), [(False, False), (True, False), (True, True)])
def test_stiffness_is_the_hessian_of_the_energy_at_zero_prestress(friction, rolling, free_cell):
    frame = strip(6)
    book = degrees(frame, friction=friction, rolling=rolling, free_cell=free_cell)
    law = LAW if rolling else replace(LAW, kr=0.0)
    exact = hessian(lambda motion: energy(frame, motion, book.per_grain, law, frame.interactions.distance), book.columns)
    # Differences over 2e-3: truncation about (1e-3)^2 times fourth derivatives of order ten.
    np.testing.assert_allclose(stiffness_matrix(frame, book, law).toarray(), exact, atol=5e-5)


def test_prestress_adds_the_rotation_term_that_the_paper_leaves_out():
    """With overlap h each contact adds -(N/r) (t.(u_i - u_j))^2, N = -K_N h, to the frictionless energy."""
    frame, overlap = strip(6), 0.01
    pairs = frame.interactions
    book = degrees(frame, friction=False)
    exact = hessian(lambda motion: energy(frame, motion, 2, LAW, pairs.distance + overlap), book.columns)
    correction = np.zeros((book.columns, book.columns))
    for i, j, n, distance in zip(pairs.i, pairs.j, pairs.normal, pairs.distance, strict=True):
        across = np.zeros(book.columns)
        across[2 * i : 2 * i + 2] = -n[1], n[0]
        across[2 * j : 2 * j + 2] = n[1], -n[0]
        correction -= overlap / distance * np.outer(across, across)
    plain = stiffness_matrix(frame, book, LAW).toarray()
    np.testing.assert_allclose(plain + correction, exact, atol=5e-5)  # truncation as above
    assert np.abs(plain - exact).max() > 1e-3  # the correction is there, of the order of the overlap


def test_distant_pairs_have_the_slope_of_the_attraction():
    """N = -F0 (1 - h/D0) (G07 eq. 4): K is the derivative of the force, -F0/D0, along the branch and zero across."""
    frame = frame_of([(0.0, 0.0), (1.001, 0.0)], 1.0, 50.0, [0], [1], [(1.001, 0.0)], gap=1e-3)
    book = degrees(frame, friction=True)
    stiffness = stiffness_matrix(frame, book, ContactLaw(kn=1e5, kt=1e5, f0=1.0, d0=1e-3)).toarray()
    expected = np.zeros((6, 6))
    expected[np.ix_([0, 3], [0, 3])] = [[-1e3, 1e3], [1e3, -1e3]]
    np.testing.assert_allclose(stiffness, expected)


@pytest.mark.parametrize("tangential", [0.0, 0.5])
def test_moduli_of_the_triangular_lattice(tangential):
    """Affine by symmetry: C11 = (2/sqrt 3)(9/8 K_N + 3/8 K_T), C12 = (2/sqrt 3)(3/8)(K_N - K_T) for three bonds per
    grain at 0, 60 and 120 degrees and sqrt(3)/2 area per grain; isotropic.
    """
    friction = tangential > 0.0
    moduli = elastic_moduli(triangular(6), law=ContactLaw(2.0, 2.0 * tangential), friction=friction)
    factor = 2.0 * 2.0 / np.sqrt(3.0)
    c11, c12 = factor * (9.0 + 3.0 * tangential) / 8.0, factor * 3.0 * (1.0 - tangential) / 8.0
    # 1e-8: the proximal term leaves forces of 1e-10 of the load.
    np.testing.assert_allclose([moduli.c11, moduli.c22, moduli.c12], [c11, c11, c12], rtol=1e-8)
    assert moduli.bulk == pytest.approx((c11 + c12) / 2.0, rel=1e-8)
    assert moduli.shear == pytest.approx((c11 - c12) / 2.0, rel=1e-8)


@pytest.mark.parametrize("solid", [0.6, 0.84])
def test_moduli_agree_with_a_dense_pseudo_inverse_with_and_without_mechanisms(solid):
    frame = packing(50, solid, 3)
    stiffness = stiffness_matrix(frame, degrees(frame, friction=True, free_cell=True), LAW).toarray()
    # 1e-9 separates round-off from the softest mode, of order 1e-4 here.
    response = stiffness[:-2, -2:].T @ np.linalg.pinv(stiffness[:-2, :-2], rcond=1e-9) @ stiffness[:-2, -2:]
    expected = (stiffness[-2:, -2:] - response) / frame.area
    moduli = elastic_moduli(frame, law=LAW)
    found = [[moduli.c11, moduli.c12], [moduli.c12, moduli.c22]]
    np.testing.assert_allclose(found, expected, atol=1e-8)  # forces solved to 1e-10, softest mode 1e-4


def test_a_cell_that_no_cluster_spans_has_no_stiffness():
    moduli = elastic_moduli(strip(10), law=LAW)
    np.testing.assert_allclose([moduli.c11, moduli.c22, moduli.c12, moduli.bulk], 0.0, atol=1e-12)


def test_dispersion_of_the_closed_chain():
    """omega = 2 sqrt(K/m) |sin(pi q/n)| along the chain; nothing resists the motions across it."""
    spectrum = vibrations(ring(8), law=ContactLaw(3.0), friction=False)
    expected = np.sort(np.concatenate((np.zeros(8), 2.0 * np.sqrt(3.0) * np.abs(np.sin(np.pi * np.arange(8) / 8)))))
    # 1e-7: the root of rounding, in the two modes that are zero by symmetry only in the sine
    np.testing.assert_allclose(np.abs(spectrum.frequency), expected, atol=1e-7)
    assert (spectrum.frequency == 0.0).sum() == 9


def test_two_discs_vibrate_and_roll_with_their_reduced_masses():
    """Normal: omega^2 = 2 K_N/m.  Tangential slip s = u_t + R(theta_1 + theta_2): omega^2 = K_T (2/m + 2 R^2/I) =
    6 K_T/m with I = m R^2/2.
    """
    frame = frame_of([(0.0, 0.0), (0.8, 0.0)], 0.8, 50.0, [0], [1], [(0.8, 0.0)])
    frame = replace(frame, mass=np.full(2, 5.0))
    spectrum = vibrations(frame, law=ContactLaw(10.0, 2.0))
    np.testing.assert_allclose(spectrum.frequency[-2:], np.sqrt([6 * 2.0 / 5.0, 2 * 10.0 / 5.0]), rtol=1e-12)
    np.testing.assert_allclose(spectrum.participation[-2:], 1.0, rtol=1e-12)
    mass = np.array([5.0, 5.0, 5.0 * 0.8**2 / 8.0])
    gram = np.einsum("aik,bik,k->ab", spectrum.modes, spectrum.modes, mass)
    np.testing.assert_allclose(gram, np.eye(6), atol=1e-12)


def test_participation_of_modes_on_two_of_many_grains():
    """A dimer among 18 rattlers: its vibration involves 2 of 20 grains."""
    dimer = frame_of([(0.0, 0.0), (1.0, 0.0)], 1.0, 50.0, [0], [1], [(1.0, 0.0)])
    lone = [frame_of([(0.0, 0.0)], 1.0, 1.0, [], [], [])] * 18
    spectrum = vibrations(together(dimer, *lone), law=ContactLaw(1.0), friction=False)
    assert spectrum.participation[-1] == pytest.approx(0.1, rel=1e-12)


def test_soft_modes_are_no_mechanisms():
    """A straight closed row that bends against rolling law of 1e-9 K_N: soft modes, and nothing is free but what the
    rank counts."""
    frame = ring(12)
    spectrum = vibrations(frame, law=ContactLaw(kn=1.0, kt=1.0, kr=1e-9), rolling=True)
    counted = rigidity(frame, law=ContactLaw(kn=1.0, kt=1.0, kr=1e-9), rolling=True)
    assert (spectrum.frequency == 0.0).sum() == counted.floppy_modes < (np.abs(spectrum.frequency) < 1e-3).sum()


@pytest.mark.parametrize("solid", [0.6, 0.84])
def test_lanczos_gives_the_lowest_modes_beyond_the_mechanisms(solid):
    frame = packing(120, solid, 1)
    dense, lowest = vibrations(frame, law=LAW), vibrations(frame, law=LAW, count=20)
    zero = np.count_nonzero(dense.frequency == 0.0)
    np.testing.assert_allclose(lowest.frequency, dense.frequency[zero : zero + 20], rtol=1e-9)
    np.testing.assert_allclose(lowest.participation, dense.participation[zero : zero + 20], rtol=1e-6)


def test_unusable_input_is_named():
    frame = strip(10)
    with pytest.raises(InputError, match="count: 28, but 30 degrees of freedom hold 3 mechanisms; give 1 to 26"):
        vibrations(frame, law=LAW, count=28)
    with pytest.raises(InputError, match="allowed up to 3000"):
        vibrations(packing(1001, 0.5, 0), law=LAW)

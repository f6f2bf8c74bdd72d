"""Elastic moduli and vibration modes of an interaction network, from its stiffness matrix K (G07 A6).

Linear response about the current state with every contact sticking and prestress corrections left out, as in K itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csc_array, diags_array, eye_array
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from workflow.data.contact_law import ContactLaw
from workflow.data.frame import Floats, Frame
from workflow.errors import InputError, WorkflowError
from workflow.measures.network import Degrees, degrees, stiffness_matrix
from workflow.measures.rigidity import dimensionless, grain_order, length_unit
from workflow.measures.sparse_rank import eigenvalues_below, factorise

PROXIMITY = 1e-10  # weight of the proximal term, in units of K_N: above round-off, below all but the softest modes
PASSES = 200  # proximal passes; modes softer than PROXIMITY need more than one, mechanisms none
SETTLED = 1e-10  # residual force, relative to the load, at which the non-affine motion is solved
SHIFT = 1e-8  # distance of the Lanczos shift from zero, relative to the largest stiffness over mass
DENSE = 3000  # degrees of freedom up to which all modes are computed at once (72 MB, some 10 s)


@dataclass(frozen=True)
class Moduli:
    """Stress increments per strain increment, sigma_a = sum_b C_ab eps_b, compression positive [force/length]."""

    c11: float
    c22: float
    c12: float

    @property
    def bulk(self) -> float:
        """B = dP/(-dA/A) for equal strains on both axes, (C11 + C22 + 2 C12)/4."""
        return (self.c11 + self.c22 + 2.0 * self.c12) / 4.0

    @property
    def shear(self) -> float:
        """G for the strain (e, -e), (C11 + C22 - 2 C12)/4; the shear modulus of an isotropic packing."""
        return (self.c11 + self.c22 - 2.0 * self.c12) / 4.0


@dataclass(frozen=True)
class Vibrations:
    """Vibration modes in a fixed cell, lowest first.

    ``frequency`` (n,): omega = sign(lambda) sqrt|lambda| [1/time], lambda the eigenvalues of K U = lambda M U with
    the masses m, m, m d^2/8 of uniform discs; negative for unstable modes, exactly 0 for the k mechanisms.  ``modes``
    (n, N, 3): u_1, u_2, theta (zero without friction), normalised to U^T M U = 1.  ``participation`` (n,): (sum
    w_i)^2/(N sum w_i^2) with w_i = m_i u_i^2 + I_i theta_i^2, from 1/N for one moving grain to 1 for all alike; among
    modes of equal frequency the basis is arbitrary.
    """

    frequency: Floats
    participation: Floats
    modes: Floats


def elastic_moduli(frame: Frame, *, law: ContactLaw, friction: bool = True, rolling: bool = False) -> Moduli:
    """C = (K_ee - K_eu K_uu^-1 K_ue)/A with u the grains and e the cell: the grains relax under its strain.

    Mechanisms of the grains carry no load and are left where they are.  Raises WorkflowError if the grains find no
    equilibrium (marginally stable or unstable network).
    """
    book = degrees(frame, friction=friction, rolling=rolling, free_cell=True)
    length = length_unit(frame)
    stiffness = stiffness_matrix(frame, book, law, length) / law.kn
    inner = csc_array(stiffness[:-2, :-2])
    load = stiffness[:-2, -2:].toarray()
    moduli = stiffness[-2:, -2:].toarray() - load.T @ _relax(inner, load)
    moduli *= law.kn * length**2 / frame.area
    return Moduli(float(moduli[0, 0]), float(moduli[1, 1]), float(moduli[0, 1]))


def _relax(inner: csc_array, load: Floats) -> Floats:
    """A solution x of ``inner`` x = ``load`` for a singular but consistent system, by proximal passes."""
    factor = splu(csc_array(inner + PROXIMITY * diags_array(np.ones(inner.shape[0]))))
    motion, scale = np.zeros_like(load), max(float(np.abs(load).max(initial=0.0)), np.finfo(float).tiny)
    for _ in range(PASSES):
        residual = load - inner @ motion
        if np.abs(residual).max(initial=0.0) <= SETTLED * scale:
            return motion
        motion += factor.solve(residual)
    raise WorkflowError(
        f"elastic moduli: forces of {np.abs(residual).max() / scale:.1e} of the load remain after {PASSES} passes "
        f"(allowed {SETTLED:g}); the network is at the edge of stability, see rigidity(...).unstable_modes"
    )


def vibrations(
    frame: Frame, *, law: ContactLaw, friction: bool = True, rolling: bool = False, count: int | None = None
) -> Vibrations:
    """Vibration modes of ``frame`` in its fixed cell: see ``Vibrations``.

    ``count``: number of lowest modes beyond the k mechanisms (whose frequency is zero), by shift-invert Lanczos; None
    computes all modes, mechanisms included, with dense algebra, for at most ``DENSE`` degrees of freedom.  Raises
    InputError for a ``count`` out of range and WorkflowError if Lanczos missed a mode.
    """
    book = degrees(frame, friction=friction, rolling=rolling)
    length = length_unit(frame)
    if count is None and book.columns > DENSE:
        raise InputError(f"count: None asks for all {book.columns} modes, allowed up to {DENSE}; give a number")
    inertia = frame.mass * frame.diameter**2 / 8.0 / length**2
    mass = np.column_stack((frame.mass, frame.mass, inertia))[:, : book.per_grain].ravel()
    weight = diags_array(1.0 / np.sqrt(mass))
    dynamical = csc_array(weight @ stiffness_matrix(frame, book, law, length) @ weight)
    if count is None:
        values, vectors = eigh(dynamical.toarray())
        # an arm that only rolling springs hold is softer than any threshold for "zero": the rank says how many are
        mechanisms = factorise(dimensionless(frame, book), *grain_order(frame, book)).nullity
        values[np.argsort(np.abs(values), kind="stable")[:mechanisms]] = 0.0
    else:
        values, vectors = _lowest(dynamical, count, frame, book, mass)
    shares = (vectors.T.reshape(-1, book.grains, book.per_grain) ** 2).sum(axis=2)
    modes = np.zeros((len(values), book.grains, 3))
    modes[:, :, : book.per_grain] = (weight @ vectors).T.reshape(-1, book.grains, book.per_grain)
    participation = shares.sum(axis=1) ** 2 / (book.grains * (shares**2).sum(axis=1))
    return Vibrations(np.sign(values) * np.sqrt(np.abs(values)), participation, modes / [1.0, 1.0, length])


def _lowest(matrix: csc_array, count: int, frame: Frame, book: Degrees, mass: Floats) -> tuple[Floats, Floats]:
    """Lowest eigenpairs beyond the mechanisms, with the inertia of the matrix as proof that none was missed.

    Lanczos would spend its time on the mechanisms, thousands of equal eigenvalues, so they are projected out.
    """
    blocks, parents = grain_order(frame, book)
    mechanisms = csc_array(diags_array(np.sqrt(mass)) @ factorise(dimensionless(frame, book), blocks, parents).null_space())
    found = mechanisms.shape[1]
    if not 1 <= count < book.columns - found:
        raise InputError(
            f"count: {count}, but {book.columns} degrees of freedom hold {found} mechanisms; give 1 to "
            f"{book.columns - found - 1}, or None for all modes of a small frame"
        )
    scale = float(matrix.diagonal().max())
    shift = -SHIFT * scale
    gram = splu(csc_array(mechanisms.T @ mechanisms))
    solver = splu(csc_array(matrix - shift * eye_array(book.columns)))

    def project(motion: Floats) -> Floats:
        return motion - mechanisms @ gram.solve(mechanisms.T @ motion)

    inverse = LinearOperator(matrix.shape, lambda motion: project(solver.solve(project(motion.ravel()))), dtype=float)
    start = project(np.random.default_rng(0).standard_normal(book.columns))
    values, vectors = eigsh(matrix, count, sigma=shift, which="LM", v0=start, OPinv=inverse)
    order = np.argsort(values, kind="stable")
    values, vectors = values[order], vectors[:, order]
    edge = values[-1] * (1.0 - SHIFT)
    below = eigenvalues_below(matrix, edge, np.concatenate(blocks))
    expected = found + int(np.count_nonzero(values < edge))
    if below != expected:
        raise WorkflowError(
            f"vibrations: {below} modes lie below the highest one computed, mechanisms and Lanczos give {expected}; "
            f"ask for another number of modes than {count}, or for all with count=None on a smaller frame"
        )
    return values, vectors

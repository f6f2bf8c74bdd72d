import json
from dataclasses import replace

import numpy as np
import pytest

from workflow.data.frame import Frame, Interactions
from workflow.errors import InputError
from workflow.measures.packing import (
    balance,
    coordination,
    kinetic_energy,
    measure,
    rumpf_ratio,
    solid_fraction,
    stress,
)

EPS = 1e-12  # sums of some hundred terms of order one in float64


def network(cell, position, diameter, i, j, branch, normal, **columns):
    """A frame at rest with contacts of given normal force (elastic part alone unless columns say otherwise)."""
    n, m = len(position), len(i)
    gap = np.hypot(*branch.T) - (diameter[i] + diameter[j]) / 2
    table = {name: np.zeros(m) for name in ("viscous", "attraction", "tangential", "moment", "xi_t", "xi_r")}
    table |= {"elastic": normal, "gap": gap, "sliding": np.zeros(m, bool), "rolling": np.zeros(m, bool)} | columns
    zeros = np.zeros((n, 2))
    return Frame(0, 0.0, "test", np.zeros(2), cell, np.arange(1, n + 1), diameter, diameter**2, position, zeros,
                 zeros[:, 0], zeros, zeros[:, 0], Interactions(i=i, j=j, branch=branch, **table))  # fmt: skip


def lattice(nx, ny, vectors, cell, force):
    """Equal discs (d = 1) on a periodic lattice; ``vectors``: (index step, branch) of half the bonds."""
    k = np.arange(nx * ny).reshape(ny, nx)
    x, y = np.meshgrid(np.arange(nx), np.arange(ny))
    offset = 0.5 * (y % 2) if len(vectors) == 3 else 0.0 * y
    height = cell[1] / ny
    position = np.column_stack(((x + offset).ravel() * cell[0] / nx, (y * height).ravel()))
    i, j, branch = [], [], []
    for step, vector in vectors:
        target = np.empty_like(k)
        for row in range(ny):
            shift, up = step(row)
            target[row] = np.roll(k[(row + up) % ny], -shift)
        i.append(k.ravel())
        j.append(target.ravel())
        branch.append(np.tile(vector, (nx * ny, 1)))
    i, j, branch = map(np.concatenate, (i, j, branch))
    return network(cell, position, np.ones(nx * ny), i, j, branch, np.full(len(i), force))


def triangular(force=0.3, overlap=1e-3, nx=6, ny=4):
    r, h = 1 - overlap, (1 - overlap) * np.sqrt(0.75)
    right, left = (lambda row: (row % 2, 1), (r / 2, h)), (lambda row: (row % 2 - 1, 1), (-r / 2, h))
    return lattice(nx, ny, [(lambda row: (1, 0), (r, 0)), right, left], np.array([nx * r, ny * h]), force)


def square(force=0.3, n=5):
    return lattice(n, n, [(lambda row: (1, 0), (1.0, 0)), (lambda row: (0, 1), (0, 1.0))], np.full(2, float(n)), force)


def disordered(seed, grains=40, links=70):
    """Random sizes, branches and forces of every kind: no geometry, only bookkeeping."""
    rng = np.random.default_rng(seed)
    i, j = np.triu_indices(grains, 1)
    rows = rng.choice(len(i), links, replace=False)
    d = rng.uniform(0.5, 1, grains)
    random = {name: rng.normal(size=links) for name in ("viscous", "attraction", "tangential", "moment")}
    frame = network(np.array([9.0, 7.0]), rng.random((grains, 2)), d, i[rows], j[rows], rng.normal(size=(links, 2)),
                    rng.random(links), **random)  # fmt: skip
    return replace(frame, velocity=rng.normal(size=(grains, 2)), omega=rng.normal(size=grains))


def test_triangular_lattice_has_the_known_measures():
    r, force = 1 - 1e-3, 0.3
    frame = triangular(force)
    result = measure(frame, force_unit=1.0, targets=(np.sqrt(3) * force / r, None))
    # Cell of one grain r^2 sqrt(3)/2, three bonds: sigma = f r (1 + 1/4 + 1/4) / A on both axes.
    assert result["stress"]["xx"] == pytest.approx(np.sqrt(3) * force / r, abs=EPS)
    assert result["stress"]["yy"] == pytest.approx(np.sqrt(3) * force / r, abs=EPS)
    assert result["stress"]["xy"] == pytest.approx(0, abs=EPS)
    assert result["stress"]["deviation"] == pytest.approx(0, abs=EPS)
    assert result["solid_fraction"] == pytest.approx(np.pi / np.sqrt(12) / r**2, abs=EPS)
    assert result["coordination"] == result["coordination_backbone"] == 6
    assert result["neighbour_shares"] == [0, 0, 0, 0, 0, 0, 1]
    assert result["rattler_fraction"] == 0
    assert result["unbalanced_force"]["force"] < EPS
    assert result["rumpf_ratio"] == pytest.approx(r, abs=EPS)  # eq. 16 neglects the overlap 1e-3


def test_square_lattice_has_the_known_measures():
    result = measure(square(0.3), force_unit=1.0, energy_residual=1e-9, equilibrated=True)
    assert result["coordination"] == 4 and result["neighbour_shares"][4] == 1
    assert [result["stress"][k] for k in ("xx", "yy", "xy")] == pytest.approx([0.3, 0.3, 0], abs=EPS)
    assert result["solid_fraction"] == pytest.approx(np.pi / 4, abs=EPS)
    assert result["rumpf_ratio"] == pytest.approx(1, abs=EPS)
    assert (result["energy_residual"], result["equilibrated"]) == (1e-9, True)
    assert result["interactions"] == {"contacts": 0, "distant": 50}  # overlap zero: gap = 0 is no contact


def test_measures_are_json_with_stable_keys():
    result = measure(triangular(), force_unit=1.0)
    assert set(json.loads(json.dumps(result))) == {
        "solid_fraction", "coordination", "coordination_backbone", "rattler_fraction", "neighbour_shares",
        "distant_share", "stress", "rumpf_ratio", "rumpf_ratio_weighted", "unbalanced_force", "kinetic_energy", "energy_residual",
        "equilibrated", "grains", "interactions",
    }  # fmt: skip


@pytest.mark.parametrize("seed", range(3))
def test_measures_agree_with_their_brute_force_twins(seed):
    frame = disordered(seed)
    c = frame.interactions
    sigma, net, moment, z = np.zeros((2, 2)), np.zeros((40, 2)), np.zeros(40), np.zeros(40)
    for k in range(len(c)):
        n = c.branch[k] / np.linalg.norm(c.branch[k])
        t = np.array([[0, -1], [1, 0]]) @ n
        f = (c.elastic[k] + c.viscous[k] + c.attraction[k]) * n + c.tangential[k] * t
        sigma += np.outer(f, c.branch[k])
        for grain, sign, arm in ((c.i[k], -1, n), (c.j[k], 1, -n)):
            net[grain] += sign * f
            r = arm * frame.diameter[grain] / 2
            moment[grain] += np.cross([*r, 0], [*(sign * f), 0])[2] + sign * c.moment[k]
            z[grain] += 1
    for m, v in zip(frame.mass, frame.velocity, strict=True):
        sigma += m * np.outer(v, v)
    np.testing.assert_allclose(sum(stress(frame)), sigma / 63, atol=EPS)
    sums = balance(frame)
    np.testing.assert_allclose(sums.force, net, atol=EPS)
    np.testing.assert_allclose(sums.moment, moment, atol=EPS)
    np.testing.assert_allclose(sums.force.sum(axis=0), 0, atol=EPS)
    network = coordination(frame, threshold=0)
    assert network.z == pytest.approx(z.mean())
    shares = [(z == k).mean() for k in range(6)] + [(z >= 6).mean()]
    np.testing.assert_allclose(network.fractions, shares, atol=EPS)
    engine = replace(frame, force=net + np.array([0, 0.25]), torque=moment - 0.5)
    assert balance(engine).force_difference == pytest.approx(0.25)
    assert balance(engine).moment_difference == pytest.approx(0.5)


def test_mean_branch_identity_behind_the_rumpf_ratio():
    """P = z Phi <N r>/(pi <d^2>) exactly, for any sizes and forces."""
    frame = disordered(5)
    c, d = frame.interactions, frame.diameter
    z = 2 * len(c) / len(d)
    exact = z * solid_fraction(frame) * (c.normal_force * c.distance).mean() / (np.pi * (d**2).mean())
    assert np.trace(stress(frame)[1]) / 2 == pytest.approx(exact, rel=1e-12)


def test_rumpf_ratio_is_one_when_force_and_size_are_uncorrelated():
    rng = np.random.default_rng(1)
    n, m = 4000, 200_000
    d = rng.uniform(0.5, 1, n)
    i, j, angle = rng.integers(0, n // 2, m), rng.integers(n // 2, n, m), rng.uniform(0, 2 * np.pi, m)
    branch = ((d[i] + d[j]) / 2)[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))
    frame = network(np.full(2, 50.0), np.zeros((n, 2)), d, i, j, branch, rng.exponential(size=m))
    # standard error of the mean of N r over 2e5 contacts: 0.25 %; of <d> over 4000 grains seen unevenly: below 0.1 %
    assert rumpf_ratio(frame, threshold=1e-4) == pytest.approx(1, abs=0.01)


def test_rumpf_ratio_is_undefined_for_a_free_sample():
    frame = square(1.0)
    free = replace(frame, interactions=replace(frame.interactions, attraction=np.full(50, -1.0)))
    assert rumpf_ratio(free, threshold=1e-4) is None


def chain(forces, attraction=0.0, grains=None):
    """Grains in a row, the k-th contact joining k and k+1."""
    m = len(forces)
    n = grains or m + 1
    return network(np.array([20.0, 20.0]), np.column_stack((np.arange(n), np.zeros(n))), np.ones(n), np.arange(m),
                   np.arange(1, m + 1), np.tile([0.999, 0.0], (m, 1)), np.array(forces, float),
                   attraction=np.full(m, attraction))  # fmt: skip


def test_rattlers_are_removed_iteratively():
    """A dangling chain on a ring: its end has one contact, then its neighbour, and so on."""
    ring_i, ring_j = np.array([0, 1, 2]), np.array([1, 2, 0])
    tail_i, tail_j = np.arange(2, 6), np.arange(3, 7)
    i, j = np.r_[ring_i, tail_i], np.r_[ring_j, tail_j]
    frame = network(np.full(2, 20.0), np.zeros((8, 2)), np.ones(8), i, j, np.tile([0.999, 0], (7, 1)), np.ones(7))
    result = coordination(frame, threshold=1e-4)
    assert result.rattlers.tolist() == [False] * 3 + [True] * 5
    assert result.z == 14 / 8 and result.z_backbone == 2 and result.rattler_fraction == 5 / 8
    np.testing.assert_allclose(result.fractions, [5 / 8, 0, 3 / 8, 0, 0, 0, 0])


def test_contacts_below_tolerance_do_not_carry():
    assert coordination(chain([1, 1, 1]), threshold=1e-4).rattlers.all()
    frame = triangular()
    weak = frame.interactions.elastic.copy()
    weak[(frame.interactions.i == 0) | (frame.interactions.j == 0)] = 5e-5
    frame = replace(frame, interactions=replace(frame.interactions, elastic=weak))
    result = coordination(frame, threshold=1e-4)
    assert result.rattlers.tolist() == [True] + [False] * 23
    assert result.z == 6 and result.z_backbone == pytest.approx(2 * (72 - 6) / 23)


def test_with_cohesion_only_grains_without_any_interaction_are_rattlers():
    frame = chain([1, 1, 1], attraction=-1.0, grains=6)
    result = coordination(frame, threshold=1e-4)
    assert result.rattlers.tolist() == [False] * 4 + [True] * 2
    assert result.z == 1 and result.z_backbone == pytest.approx(result.z / (1 - result.rattler_fraction))  # eq. 13
    np.testing.assert_allclose(result.fractions, [2 / 6, 2 / 6, 2 / 6, 0, 0, 0, 0])


def test_kinetic_energy_without_drift_and_rattlers():
    frame = replace(triangular(), velocity=np.tile([3.0, -4.0], (24, 1)), omega=np.full(24, 2.0))
    xi_r = 1.0 * 1.0**2 / 8 * 2.0**2 / 2
    alone = np.zeros(24, bool)
    assert kinetic_energy(frame, alone).raw == pytest.approx(12.5 + xi_r)
    assert kinetic_energy(frame, alone).relative == pytest.approx(xi_r)
    alone[3] = True
    frame.omega[3], frame.velocity[3] = 1e3, 1e3
    assert kinetic_energy(frame, alone).relative == pytest.approx(xi_r)


def test_relabelling_and_translation_change_nothing():
    frame = disordered(7)
    order = np.random.default_rng(8).permutation(40)
    where = np.argsort(order)
    c = frame.interactions
    moved = replace(
        frame, diameter=frame.diameter[order], mass=frame.mass[order], position=frame.position[order] + 5,
        velocity=frame.velocity[order], omega=frame.omega[order],
        interactions=replace(c, i=where[c.j], j=where[c.i], branch=-c.branch, moment=-c.moment),
    )  # fmt: skip

    def numbers(entry):
        """All numbers of a nested result in order; None (undefined) as NaN."""
        if isinstance(entry, dict | list):
            return [x for item in (entry.values() if isinstance(entry, dict) else entry) for x in numbers(item)]
        return [np.nan if entry is None else float(entry)]

    before, after = (numbers(measure(f, force_unit=1.0)) for f in (frame, moved))
    np.testing.assert_allclose(after, before, rtol=1e-10, atol=1e-10)  # the order of summation


def test_a_frame_without_interactions_is_measured():
    result = measure(chain([], grains=3), force_unit=1.0)
    assert (result["coordination"], result["coordination_backbone"], result["rattler_fraction"]) == (0, 0, 1)
    assert result["rumpf_ratio"] is None


@pytest.mark.parametrize("unit", [0.0, -1.0, float("nan")])
def test_a_force_unit_that_is_not_positive_is_refused(unit):
    with pytest.raises(InputError, match="force_unit"):
        measure(square(), force_unit=unit)

"""Counts of rigidity: closed forms on lattices and chains, the four discs of G07, dense twins, invariance, messages."""

import json
from dataclasses import replace

import numpy as np
import pytest
from networks import (
    double_triangle,
    frame_of,
    joined,
    packing,
    ring,
    row,
    square,
    strip,
    together,
    triangular,
)
from scipy.sparse import csr_array

from workflow.data.contact_law import ContactLaw
from workflow.errors import InputError, WorkflowError
from workflow.measures.network import degrees, rigidity_matrix, stiffness_matrix
from workflow.measures.rigidity import rigidity
from workflow.measures.sparse_rank import factorise

LAW = ContactLaw(kn=1.0, kt=1.0, kr=1e-4)
MODELS = [(False, False), (True, False), (True, True)]  # friction, rolling


def counts(frame, friction=True, rolling=False, free_cell=False):
    """(k, H)."""
    result = rigidity(frame, law=LAW, friction=friction, rolling=rolling, free_cell=free_cell)
    return result.floppy_modes, result.hyperstaticity


@pytest.mark.parametrize("distance", [1.0, 1.0 - 1e-5, 1.0 - 1e-3])
def test_the_double_triangle_of_g07_has_one_self_stress(distance):
    """G07 fig. 13: kappa = 3, H = 1, whatever the overlap; H = 3 per loop with rolling resistance."""
    frame = double_triangle(distance)
    assert counts(frame) == (3, 1)
    assert counts(frame, friction=False) == (3, 0)
    assert counts(frame, rolling=True) == (3, 6)


def test_a_free_cell_adds_its_two_strains_to_a_cluster_that_does_not_touch_it():
    assert counts(double_triangle(), free_cell=True) == (5, 1)


@pytest.mark.parametrize("side", [4, 6])
def test_triangular_lattice_is_rigid(side):
    """Only the two translations are left, so H = M + 2 - N_f with M = 3N (6N with friction)."""
    grains = side**2
    assert counts(triangular(side), friction=False) == (2, grains + 2)
    assert counts(triangular(side)) == (2, 3 * grains + 2)
    assert counts(triangular(side), free_cell=True) == (2, 3 * grains)


@pytest.mark.parametrize("side", [4, 6, 10])
def test_square_lattice_slides_along_its_lines(side):
    """Without friction each of the 2 side lines slides and carries one self-stress.  A free cell must keep its lengths
    and adds two balances.  With friction only the translations and the counter-rotation of all grains are left.
    """
    assert counts(square(side), friction=False) == (2 * side, 2 * side)
    assert counts(square(side), friction=False, free_cell=True) == (2 * side, 2 * side - 2)
    assert counts(square(side)) == (3, side**2 + 3)


@pytest.mark.parametrize("grains", [2, 7, 40])
def test_chains_have_the_counted_modes(grains):
    """An open chain is isostatic or floppy.  A closed one carries its axial force, with rolling resistance a bending
    moment too; the shear force would need unequal moments and is out.
    """
    assert counts(row(grains)) == (grains + 2, 0)
    assert counts(row(grains), rolling=True) == (3, 0)
    if grains > 2:
        assert counts(ring(grains)) == (grains + 1, 1)
        assert counts(ring(grains), rolling=True) == (2, 2)


def test_a_triangulated_strip_is_isostatic_without_friction():
    assert counts(strip(30), friction=False) == (3, 0)
    assert counts(strip(30)) == (3, 2 * 57 - 90 + 3)


@pytest.mark.parametrize(("friction", "each"), [(True, 3), (False, 2)])
def test_every_rattler_adds_its_own_motions_and_no_self_stress(friction, each):
    packed = packing(40, 0.8, 1, open_cell=True)
    lone = [frame_of([(0.0, 0.0)], 1.0, 1.0, [], [], [])] * 3
    floppy, hyperstatic = counts(packed, friction=friction)
    assert counts(together(packed, *lone), friction=friction) == (floppy + 3 * each, hyperstatic)


@pytest.mark.parametrize("seed", range(12))
def test_counts_agree_with_dense_singular_values(seed):
    rng = np.random.default_rng(seed)
    frame = packing(int(rng.integers(2, 60)), float(rng.uniform(0.4, 0.9)), seed)
    gap = np.where(rng.random(len(frame.interactions)) < 0.1, 1e-3, frame.interactions.gap)  # some pairs at a distance
    frame = replace(frame, interactions=replace(frame.interactions, gap=gap))
    for friction, rolling in MODELS:
        for free_cell in (False, True):
            book = degrees(frame, friction=friction, rolling=rolling, free_cell=free_cell)
            dense = rigidity_matrix(frame, book).toarray()
            assert dense.shape == (book.rows, book.columns)
            # Singular values of these networks are above 1e-4 or below 1e-14.
            rank = np.linalg.matrix_rank(dense, tol=1e-9) if dense.size else 0
            assert counts(frame, friction, rolling, free_cell) == (book.columns - rank, book.rows - rank)


@pytest.mark.parametrize("seed", range(6))
def test_stability_agrees_with_dense_eigenvalues(seed):
    """Distant pairs weaken K: count its negative eigenvalues and look for more than two vanishing ones."""
    frame = packing(50, 0.84, seed)
    gap = np.where(np.random.default_rng(seed).random(len(frame.interactions)) < 0.1, 1e-3, frame.interactions.gap)
    frame = replace(frame, interactions=replace(frame.interactions, gap=gap))
    for strength in (1e-3, 0.3, 3.0):
        law = ContactLaw(kn=1.0, kt=1.0, f0=strength, d0=1.0)
        values = np.linalg.eigvalsh(stiffness_matrix(frame, degrees(frame, friction=True), law).toarray())
        result = rigidity(frame, law=law)
        # Round-off of a 150 x 150 matrix of order one is 1e-14, the softest true eigenvalue here 1e-4.
        assert result.unstable_modes == np.count_nonzero(values < -1e-9)
        assert result.positive_definite == (np.count_nonzero(values < 1e-9) == 2)


def backbone_of(frame, rolling):
    """Twin: cut every interaction that alone holds its two ends together, unless it is a contact that does not roll."""
    pairs = list(zip(frame.interactions.i, frame.interactions.j, strict=True))

    def part_of(grain, edges):
        part, grown = set(), {grain}
        while grown != part:
            part, grown = grown, grown | {end for edge in edges if grown & set(edge) for end in edge}
        return part

    cut = [
        pair for k, pair in enumerate(pairs) if not (rolling and frame.interactions.gap[k] < 0)
        and pair[1] not in part_of(pair[0], pairs[:k] + pairs[k + 1 :])
    ]  # fmt: skip
    left = [pair for pair in pairs if pair not in cut]
    return sorted(max((part_of(grain, left) for grain in range(frame.grains)), key=len))


def alone(frame, kept):
    """The network between the grains ``kept``, built anew."""
    place = {grain: row for row, grain in enumerate(kept)}
    rows = [k for k, pair in enumerate(zip(frame.interactions.i, frame.interactions.j, strict=True)) if set(pair) <= set(kept)]
    table = frame.interactions.select(rows)
    ends = [[place[grain] for grain in side] for side in (table.i, table.j)]
    return frame_of(frame.position[kept], frame.diameter[kept], frame.cell, *ends, table.branch, gap=table.gap)


@pytest.mark.parametrize(("solid", "seed"), [(0.3, 0), (0.5, 1), (0.6, 2), (0.75, 3), (0.82, 4), (0.84, 5)])
def test_the_backbone_is_counted_as_if_the_other_grains_were_not_there(solid, seed):
    frame = packing(60, solid, seed)
    gap = np.where(np.random.default_rng(seed).random(len(frame.interactions)) < 0.05, 1e-3, frame.interactions.gap)
    frame, law = (
        replace(frame, interactions=replace(frame.interactions, gap=gap)),
        ContactLaw(kn=1.0, kt=1.0, kr=1e-4, f0=1e-3, d0=1.0),
    )
    for friction, rolling in MODELS:
        kept = backbone_of(frame, rolling)
        model = {"law": law, "friction": friction, "rolling": rolling, "free_cell": True}
        result, expected = rigidity(frame, **model), rigidity(alone(frame, kept), **model)
        assert result.backbone_grains == len(kept)
        assert result.backbone_mechanisms == expected.mechanisms
        assert result.positive_definite_backbone == expected.positive_definite


def test_a_triangle_that_floats_in_a_hole_does_not_spoil_the_backbone():
    rigid, triangle = double_triangle(), strip(3)
    result = rigidity(together(rigid, triangle), law=LAW)
    assert (result.mechanisms, result.backbone_grains, result.backbone_mechanisms) == (4, 4, 1)  # both turn, one moves besides
    lattice = triangular(8)  # periodic, so that it cannot turn; a hexagon of it taken out and a triangle put there
    apart = lattice.position - lattice.position[27]
    hole = np.hypot(*(apart - lattice.cell * np.round(apart / lattice.cell)).T) < 2.1
    corners = np.array([(0.0, 1.0), (-(0.75**0.5), -0.5), (0.75**0.5, -0.5)]) / 3**0.5  # of sides 1
    grains = np.vstack((lattice.position[~hole], lattice.position[27] + corners))
    result = rigidity(joined(grains, 1.0, lattice.cell, reach=1.001), law=LAW)
    assert (result.grains - result.backbone_grains, result.mechanisms, result.backbone_mechanisms) == (3, 3, 0)
    assert result.positive_definite_backbone and not result.positive_definite


def test_a_grain_that_hangs_on_a_rigid_lattice_rolls_and_leaves_the_backbone_rigid():
    frame = triangular(6)
    cell = frame.cell + 20.0  # cut open, one grain more at the top right corner, another one on that
    lattice = joined(frame.position + 3.0, 1.0, cell, reach=1.001)
    corner, further = lattice.position[np.argmax(lattice.position.sum(axis=1))], np.array((0.8, 0.6))
    tail = joined(np.vstack((lattice.position, corner + further, corner + 2 * further)), 1.0, cell, reach=1.001)
    result = rigidity(tail, law=LAW)
    # a lattice turns as a whole
    assert (result.mechanisms, result.backbone_grains, result.backbone_mechanisms) == (1 + 2, 36, 1)
    assert not result.positive_definite and not result.positive_definite_backbone
    record = json.loads(json.dumps(rigidity(triangular(6), law=LAW).as_dict()))
    assert record["positive_definite_backbone"] is True and record["backbone_grains"] == 36


def test_counts_do_not_depend_on_labels_orientation_of_pairs_place_or_unit_of_length():
    frame = packing(60, 0.75, 3)
    order = np.random.default_rng(0).permutation(60)
    label = np.argsort(order)
    pairs = frame.interactions
    shuffled = np.random.default_rng(1).permutation(len(pairs))
    relabelled = frame_of(
        frame.position[order],
        frame.diameter[order],
        frame.cell,
        label[pairs.j][shuffled],
        label[pairs.i][shuffled],
        -pairs.branch[shuffled],
    )
    moved = joined((frame.position + np.array((1.3, -0.7))) % frame.cell, frame.diameter, frame.cell)
    position, diameter, cell, branch = (1e3 * a for a in (frame.position, frame.diameter, frame.cell, pairs.branch))
    in_millimetres = frame_of(position, diameter, cell, pairs.i, pairs.j, branch)
    for friction, rolling in MODELS:
        expected = counts(frame, friction, rolling, True)
        for other in (relabelled, moved, in_millimetres):
            assert counts(other, friction, rolling, True) == expected


def test_branches_stored_with_few_digits_are_counted_alike():
    """Text dumps keep six digits or so; independent rounding of each branch must not stop clusters from rotating."""
    frame = packing(200, 0.6, 8, open_cell=True)
    rounded = replace(frame.interactions, branch=np.round(frame.interactions.branch, 6))
    assert counts(replace(frame, interactions=rounded)) == counts(frame)


def test_a_larger_packing_is_counted_consistently_with_a_clear_gap():
    """1400 grains, as in G07: the identities hold (or it would raise) and no pivot is near the threshold 1e-9."""
    result = rigidity(packing(1400, 0.8, 5), law=LAW, free_cell=True)
    assert result.largest_residue < 1e-11 < 1e-6 < result.smallest_pivot


def test_the_record_is_plain_json_even_without_contacts():
    frame = frame_of([(0.0, 0.0), (5.0, 5.0)], 1.0, 10.0, [], [], [])
    record = json.loads(json.dumps(rigidity(frame, law=LAW, free_cell=True).as_dict(), allow_nan=False))
    assert record["hyperstaticity"] == 0
    assert record["floppy_modes"] == 8
    assert record["cell_degrees"] == 2
    assert record["positive_definite"] is False
    assert (record["backbone_grains"], record["positive_definite_backbone"]) == (1, False)


def test_a_network_at_the_edge_of_singularity_is_refused():
    """Three grains almost in line and all bonded: a singular value of 1e-8, below the resolution of G^T G."""
    position = np.array([(0.0, 0.0), (1.0, 2e-8), (2.0, 0.0)])
    i, j = [0, 1, 0], [1, 2, 2]
    frame = frame_of(position, 1.0, 50.0, i, j, position[j] - position[i])
    with pytest.raises(WorkflowError, match="too close to singular"):
        rigidity(frame, law=LAW, friction=False)


def test_unusable_networks_are_named():
    frame = row(3)
    with pytest.raises(InputError, match="rolling resistance needs rotations"):
        rigidity(frame, law=LAW, friction=False, rolling=True)
    with pytest.raises(InputError, match="0 grains"):
        rigidity(frame_of(np.zeros((0, 2)), 1.0, 1.0, [], [], []), law=LAW)
    with pytest.raises(InputError, match="grains 1 and 2 are at the same place"):
        rigidity(frame_of(np.zeros((2, 2)), 1.0, 5.0, [0], [1], [(0.0, 0.0)]), law=LAW)
    with pytest.raises(InputError, match="'kt' is 0"):
        stiffness_matrix(frame, degrees(frame, friction=True), ContactLaw(1.0))
    for bad in ({"kn": 0.0}, {"kt": -1.0}, {"kr": np.nan}, {"f0": -1.0}):
        with pytest.raises(InputError, match=f"'{next(iter(bad))}' is"):
            ContactLaw(**({"kn": 1.0} | bad))


def test_coefficients_do_not_grow_from_front_to_front():
    """Rows x_k/1000 + x_(k+1) = 0, one column per front: eliminated in turn, x_n = 1 would make x_0 = 1000^n."""
    size = 30
    rows, columns = np.tile(np.arange(size - 1), 2), np.concatenate((np.arange(size - 1), np.arange(1, size)))
    values = np.repeat([1e-3, 1.0], size - 1)
    blocks = [np.array([k]) for k in range(size)]
    found = factorise(csr_array((values, (rows, columns)), shape=(size - 1, size)), blocks, [*range(1, size), size - 1])
    assert found.nullity == 1
    assert found.smallest_live > 0.1
    vector = found.null_space().toarray()[:, 0]
    assert np.abs(vector).max() == 1.0
    assert vector[1] / vector[0] == pytest.approx(-1e-3)
    assert found.combine_null_space(np.array([[2.0]]))[:, 0] == pytest.approx(2.0 * vector, abs=1e-15)  # no rounding to add up


def test_a_loop_with_rolling_resistance_holds_three_systems_as_eq_21_counts():
    """Six discs in a ring: 3 x 6 + H = 3 x 6 + k with k = 3 motions of the whole, so H = 3 (the text of sec. IV says 2)."""
    angle = np.arange(6) * np.pi / 3
    hexagon = joined(np.column_stack((np.cos(angle), np.sin(angle))), 1.0, 50.0, reach=1.001)
    assert counts(hexagon, rolling=True) == (3, 3)

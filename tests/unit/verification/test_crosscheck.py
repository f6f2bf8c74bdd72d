"""Files for other programs, what is measured of their packings, and that they compute what ours does."""

from __future__ import annotations

import io
import math
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workflow.data.contact_law import ContactLaw
from workflow.data.discs import Discs
from workflow.scene.method1 import Method1
from workflow.scene.placement import cell_length
from workflow.verification.crosscheck import (
    CLASSES,
    CONTROL,
    EXACT,
    NUMBERS,
    Packed,
    at_rest,
    course,
    grains,
    means,
    measured,
    own_run,
    values_of,
)
from workflow.verification.crosscheck_few import few_bodies, few_cases
from workflow.verification.one_run import Outcome
from workflow.verification.other_engines import PEERS, liggghts_data, liggghts_law, run

LAW = ContactLaw(kn=2e4, kt=1e4, zeta=0.6, mu=0.3, f0=0.0, d0=0.0, kr=0.0, mur=0.0)
DISCS = Discs(np.array([1.0, 0.5, 1.0]), np.array([[0.1, 0.2], [1.5, 1.0], [3.0, 2.5]]), np.array([4.0, 3.0]))


def needs(name: str) -> pytest.MarkDecorator:
    return pytest.mark.skipif(not shutil.which(name), reason=f"{name} is not installed: apt-get install {name}")


def test_liggghts_has_a_type_per_diameter_and_the_damping_of_each_pair() -> None:
    text = liggghts_data(DISCS, *at_rest(DISCS))
    lines = text.splitlines()
    rows = [line.split() for line in lines[lines.index("Atoms") + 2 :][:3]]
    assert "3 atoms" in text and "2 atom types" in text and "-2.0 2.0 xlo xhi" in text and "-1.5 1.5 ylo yhi" in text
    assert [row[1] for row in rows] == ["2", "1", "2"]
    # mass of a disc of that density: pi d^2/4 density = d^2
    assert [math.pi * float(d) ** 2 / 4.0 * float(density) for _, _, d, density, *_ in rows] == pytest.approx([1.0, 0.25, 1.0])
    assert [float(row[4]) for row in rows] == pytest.approx([0.1 - 2.0, 1.5 - 2.0, 3.0 - 2.0])
    law = dict([*line.split()[4:5], line.split()[7:]] for line in liggghts_law(DISCS, LAW).splitlines())
    assert {name: set(map(float, row)) for name, row in law.items() if name != "gamman_abs"} == {
        "kn": {2e4}, "kt": {1e4}, "gammat_abs": {0.0}, "coefficientFriction": {0.3},
    }  # fmt: skip
    # eq. 6: eta = zeta sqrt(4 K_N m*) for the masses 1/4 and 1
    reduced = [0.125, 0.2, 0.2, 0.5]
    assert [float(eta) for eta in law["gamman_abs"]] == pytest.approx([0.6 * math.sqrt(4 * 2e4 * m) for m in reduced])


def test_packings_have_few_diameters_and_the_wanted_density() -> None:
    scene = Method1(n=300, cohesion=False, seed=4)
    discs = grains(scene)
    assert len(np.unique(discs.diameter)) == CLASSES
    assert discs.diameter.min() > 0.5 and discs.diameter.max() < 1.0
    assert discs.cell[0] == pytest.approx(cell_length(discs.diameter, 0.36))
    assert np.array_equal(grains(scene).position, discs.position)
    assert not np.array_equal(grains(replace(scene, seed=5)).diameter, discs.diameter)


def test_a_hexagonal_packing_is_measured() -> None:
    """Equal overlaps: six contacts each of one force, N = K_N overlap; twice the overlap is the same distribution."""
    scene, side = Method1(n=64, cohesion=False, smallest=1.0), 8
    rows, columns = np.divmod(np.arange(side * side), side)

    def packing(overlap: float) -> tuple[Discs, Outcome]:
        place = np.column_stack((columns + 0.5 * (rows % 2), rows * math.sqrt(0.75))) * (1.0 - overlap)
        cell = np.array([side, side * math.sqrt(0.75)]) * (1.0 - overlap)
        return Discs(np.ones(64), place, cell), Outcome(place, np.zeros((64, 2)), np.zeros(64), cell, {}, 0.0)

    way = np.array([[0.0, 0.3], [7.0, 0.9]])
    first = measured(scene, EXACT, *packing(1e-3), None, way, 1.0)
    second = measured(scene, "yade", *packing(2e-3), first, way, 1.0)
    row = first.row
    assert (row.coordination, row.coordination_backbone, row.rattlers) == (6.0, 6.0, 0.0)
    assert row.solid_fraction == pytest.approx(math.pi / math.sqrt(12.0) / (1.0 - 1e-3) ** 2, rel=1e-12)
    assert row.mean_force == pytest.approx(1e5 * 1e-3, rel=1e-9) and row.second_moment == pytest.approx(1.0, rel=1e-12)
    assert row.time == 7.0 and row.kinetic == 0.0
    assert second.row.mean_force == pytest.approx(200.0, rel=1e-9)
    assert second.row.ks_critical == pytest.approx(1.358 * math.sqrt(2.0 / 192.0))


def test_differences_are_taken_seed_by_seed() -> None:
    """Scatter between seeds that all engines share is in the mean, not in the difference."""

    def row(seed: int, engine: str, value: float) -> Packed:
        return Packed(seed, engine, 10, *([value] * len(NUMBERS)), 0.0, 0.0, 0.0, 1.0, 1.0)

    rows = [row(s, EXACT, v) for s, v in ((1, 2.0), (2, 4.0))] + [row(s, "yade", v) for s, v in ((1, 2.1), (2, 4.3))]
    found = {(mean.engine, mean.number): mean for mean in means(rows)}
    ours, theirs = found[EXACT, "coordination"], found["yade", "coordination"]
    assert (ours.mean, ours.difference, ours.difference_error) == (3.0, 0.0, 0.0)
    assert ours.error == pytest.approx(1.0)  # values 2 and 4: deviation sqrt(2), over sqrt(2)
    assert theirs.difference == pytest.approx(0.2) and theirs.difference_error == pytest.approx(0.1)
    assert {mean.error for mean in means(rows[:1])} == {None}  # one seed says nothing of the scatter


@needs("liggghts")
@pytest.mark.engine
def test_liggghts_computes_the_law_of_lammps() -> None:
    """Without friction the laws are one and the same: to rounding that of `granular`, to the scheme's first order ours."""
    head_on, two = [case for case in few_cases(4) if case.law.mu == 0.0]
    rows = {
        (r.case, r.engine, r.steps_per_period): r for r in few_bodies(["liggghts"], [28, 112], [head_on, two], io.StringIO())
    }
    for case in (head_on, two):
        coarse, fine = (rows[case.name, "liggghts", many] for many in (28, 112))
        assert max(coarse.to_granular, fine.to_granular) < 1e-9
        assert fine.error < 0.6 * coarse.error  # first order: a quarter, but where discs graze each other
        assert rows[case.name, EXACT, 112].error < 0.1 * fine.error


@needs("liggghts")
@needs("yade")
def test_lever_arms_make_the_difference_in_friction() -> None:
    """Undamped, the laws differ by overlaps over radii alone: a tenth of the overlap leaves a tenth of the difference."""
    soft, stiff = [case for case in few_cases(4) if case.law.mu and not case.law.zeta]
    rows = {(r.case, r.engine): r.error for r in few_bodies(PEERS, [112], [soft, stiff], io.StringIO())}
    for name in PEERS:
        assert rows[soft.name, name] < 2e-3  # overlaps of 1e-3 on radii of 1/4 to 1/2
        assert rows[stiff.name, name] < 0.3 * rows[soft.name, name]


@pytest.mark.engine
@pytest.mark.parametrize("name", [pytest.param(name, marks=needs(name)) for name in PEERS])
def test_cells_shrink_alike(name: str, tmp_path: Path) -> None:
    """The same gas under the same stress: while few discs have met, the cell of G07 eq. 3 moves alike in every engine.

    Their clocks of the cell differ by up to two steps (1.5 steps of 1e-4 at a rate of 2 change the density by 3e-4).
    """
    scene = Method1(n=60, cohesion=False, max_time=0.6, dashpots=0.0, cell="strain", series_interval=0.1)
    discs = grains(scene)
    own_run(tmp_path / EXACT, scene, discs)
    values = {**values_of(scene, None), "steps": round(0.6 / scene.step_choice.step), "relax_steps": 0, "rows": 50}
    end = run(tmp_path / name, name, discs, scene.law_in_units, values, *at_rest(discs))
    ours, theirs = course(tmp_path / EXACT, discs), course(tmp_path / name, discs)
    assert ours[-1, 1] > 0.40  # it did shrink
    assert np.interp(ours[:, 0], *theirs.T)[1:-1] == pytest.approx(ours[1:-1, 1], rel=1e-3)
    assert end.cell.max() < discs.cell[0] and np.isfinite(end.position).all()
    assert CONTROL not in PEERS

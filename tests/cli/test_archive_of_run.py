"""The archive of a run, looked at from outside: MDAnalysis, and Newton's laws on its contact table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from workflow.archive.read import Archive, universe
from workflow.data.frame import Frame


@pytest.fixture(params=["packing", "cohesive"])
def archive_file(request: pytest.FixtureRequest) -> Path:
    return Path(request.getfixturevalue(request.param)) / "run.h5"


def net(frame: Frame) -> tuple[np.ndarray, np.ndarray]:
    """Net force and moment of each grain from the contact table alone, one contact after the other."""
    force, moment = np.zeros((frame.grains, 2)), np.zeros(frame.grains)
    table = frame.interactions
    radius = frame.diameter / 2
    for k in range(len(table)):
        i, j, branch = table.i[k], table.j[k], table.branch[k]
        n = branch / np.hypot(*branch)
        normal = table.elastic[k] + table.viscous[k] + table.attraction[k]
        on_j = normal * n + table.tangential[k] * np.array([-n[1], n[0]])
        force[j] += on_j
        force[i] -= on_j
        # v_t = ... - R_i w_i - R_j w_j: the work of T at the rims makes the radii its arms
        moment[i] -= table.tangential[k] * radius[i] + table.moment[k]
        moment[j] -= table.tangential[k] * radius[j] - table.moment[k]
    return force, moment


def test_mdanalysis_opens_it(archive_file: Path) -> None:
    seen = universe(archive_file)
    with Archive(archive_file) as archive:
        frames = list(archive.frames)
    assert len(seen.trajectory) == len(frames) >= 2
    for ts, frame in zip(seen.trajectory, frames, strict=True):
        # MDAnalysis keeps float32: 24 bits
        np.testing.assert_allclose(seen.atoms.positions[:, :2], frame.position, atol=2e-6 * frame.cell.max())
        np.testing.assert_allclose(ts.dimensions[:2], frame.cell, rtol=1e-6)
        assert ts.time == pytest.approx(frame.time, rel=1e-6)
    assert seen.atoms.masses.sum() == pytest.approx(frames[0].mass.sum(), rel=1e-12)


def test_contact_table_sums_to_the_forces_of_the_engine(archive_file: Path) -> None:
    """In every frame, at rest or not: sums of at most six terms of order one, 17 digits each."""
    with Archive(archive_file) as archive:
        for frame in archive.frames:
            force, moment = net(frame)
            np.testing.assert_allclose(force, frame.force, atol=1e-11)
            np.testing.assert_allclose(moment, frame.torque, atol=1e-11)


def test_grains_are_in_equilibrium_at_the_end(archive_file: Path) -> None:
    with Archive(archive_file) as archive:
        frame = archive.frame(-1)
    force, moment = net(frame)
    assert len(frame.interactions) > frame.grains
    assert np.hypot(force[:, 0], force[:, 1]).max() < 1e-4  # G07 sec. II D, with F1 = 1
    assert np.abs(moment).max() < 1e-4


def test_contact_table_is_complete_and_lawful(archive_file: Path) -> None:
    """Brute force over all pairs and images; Coulomb's limit on each contact."""
    with Archive(archive_file) as archive:
        frame, scene = archive.frame(-1), archive.provenance["scene"]
    reach = scene["d0"] if scene["cohesion"] else 0.0
    apart = frame.position[None, :, :] - frame.position[:, None, :]
    apart -= frame.cell * np.round(apart / frame.cell)
    gap = np.hypot(apart[..., 0], apart[..., 1]) - (frame.diameter[:, None] + frame.diameter[None, :]) / 2
    i, j = np.nonzero(np.triu(gap < reach, 1))
    table = frame.interactions
    assert {frozenset(pair) for pair in zip(table.i, table.j, strict=True)} == {
        frozenset(pair) for pair in zip(i, j, strict=True)
    }
    np.testing.assert_allclose(table.gap, gap[table.i, table.j], atol=1e-12)  # differences of coordinates of order ten
    cap = scene["mu"] * table.elastic
    assert np.all(np.abs(table.tangential) <= cap * (1 + 1e-12))
    assert np.all(table.elastic[~table.in_contact] == 0)
    assert np.all(table.tangential[~table.in_contact] == 0)


def test_cohesive_run_has_distant_pairs_and_tension(cohesive: Path) -> None:
    """Otherwise the tests above would say nothing about the tail."""
    with Archive(cohesive / "run.h5") as archive:
        table = archive.frame(-1).interactions
    assert np.any(~table.in_contact)
    assert np.any(table.normal_force < 0)
    assert np.any(table.moment != 0)

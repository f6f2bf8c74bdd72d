"""The decks of both methods on 1, 2 and 4 ranks: one motion, to rounding."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from workflow.archive.dumps import read_frames
from workflow.data.frame import Frame
from workflow.data.series import read_series
from workflow.deck.template import data_file, render
from workflow.runs.installation import engine
from workflow.scene.method1 import Method1
from workflow.scene.method2 import Method2
from workflow.scene.packing import Packing

# Soft grains, dense and fast, so that a hundred steps hold dozens of impacts with friction, rolling and attraction; 4 ranks
# that share 2 cores hand each other the processor at every message, which makes their steps dear.
LAW = {
    "n": 90,
    "phi0": 0.6,
    "kappa": 1e3,
    "d0": 0.01,
    "rolling": True,
    "mur": 0.05,
    "skin": 0.02,
    "seed": 3,
    "step": 2e-4,
    "max_time": 0.02,
    "series_interval": 0.005,
}
SCENES: list[Packing] = [
    Method1(**LAW, pstar=100.0, cell_mass=0.001, rate_cap=10.0, dashpots=0.0),
    Method2(**LAW, v0=100.0),
]


def last(folder: Path, scene: Packing, ranks: int) -> Frame:
    """The last state of a run of the scene's deck."""
    folder.mkdir()
    (folder / "deck.in").write_text(render(scene))
    (folder / "grains.data").write_text(data_file(scene.discs()))
    found = engine()
    options = ["-in", "deck.in", "-screen", "none", "-var", "check_every", "25"]
    command = [str(found.mpiexec), "-n", str(ranks), str(found.lmp), *options]
    done = subprocess.run(command, cwd=folder, env=found.variables(), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return list(read_frames(folder / "grains.dump", folder / "contacts.dump"))[-1]


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_same_motion_on_any_number_of_ranks(scene: Packing, tmp_path: Path) -> None:
    """A hundred steps, with what is measured on the way."""
    one = last(tmp_path / "1", scene, 1)
    assert one.step == 100 and one.interactions.in_contact.sum() > 30
    for ranks in (2, 4):
        other = last(tmp_path / str(ranks), scene, ranks)
        away = (other.position - one.position + one.cell / 2.0) % one.cell - one.cell / 2.0
        # rounding of positions at 1e-15, amplified by at most a few impacts per grain; physics would differ by 1e-3 and more
        assert np.abs(away).max() < 1e-10
        np.testing.assert_allclose(other.cell, one.cell, rtol=0.0, atol=1e-11)
        for name in ("velocity", "omega", "force", "torque"):
            np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=0.0, atol=1e-7, err_msg=name)
        assert np.array_equal(other.interactions.i, one.interactions.i) and np.array_equal(
            other.interactions.j, one.interactions.j
        )
        np.testing.assert_allclose(other.interactions.xi_t, one.interactions.xi_t, rtol=0.0, atol=1e-10)
        series, reference = (read_series(tmp_path / str(number) / "series.txt") for number in (ranks, 1))
        assert set(series) == set(reference)
        for name, values in reference.items():
            np.testing.assert_allclose(series[name], values, rtol=1e-7, atol=1e-9, err_msg=name)

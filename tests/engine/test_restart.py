"""Checkpoints: contact memory, cell and clocks survive write_restart and read_restart."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from workflow.data.frame import Frame
from workflow.deck.template import templates

TABLE = (templates() / "common" / "contact_table.in").read_text(encoding="ascii")
LAW = {"kn": 1e4, "kt": 8e3, "zeta": 0.4, "mu": 0.15, "f0": 0.5, "d0": 5e-3, "kr": 2.0, "mur": 1e-2}
MOVE = "stress 20 20 cell strain mass 0.3 rate 0.4"
CHECK = "fix eq all disc/equilibrium 10 unit 1 energy 1e9 force 1e9\n"


@pytest.fixture
def scene(gas: Callable[..., Any]) -> dict[str, Any]:
    return {**gas(50, 0.55, seed=11), "law": LAW, "step": 2e-4, "move": MOVE, "skin": 0.05}


def reader(checkpoint: Path, newton: str = "on", move: str = MOVE) -> str:
    """Input script that continues from a checkpoint; the law is in it."""
    return f"""units lj
newton {newton}
atom_modify map array sort 0 0.0
comm_modify mode single vel yes
neighbor 0.05 bin
read_restart {checkpoint}
neigh_modify once yes
timestep 2e-4
fix move all disc/integrate {move}
compute energy all pair disc/cohesive
{TABLE}
thermo_style custom step time ke c_energy c_energy[1]
thermo_modify norm no
thermo 0
"""


def same_memory(frame: Frame, before: Frame) -> None:
    """Assert the same grains and contacts; only the viscous force, evaluated at the full step, may differ."""
    assert np.array_equal(frame.velocity, before.velocity) and np.array_equal(frame.omega, before.omega)
    assert np.array_equal(frame.cell, before.cell) and frame.step == before.step and frame.time == before.time
    one, two = frame.interactions, before.interactions
    assert np.array_equal(one.i, two.i) and np.array_equal(one.j, two.j)
    for name in ("xi_t", "xi_r", "gap", "tangential", "moment", "attraction"):
        # positions are wrapped anew, which rounds gaps at 1e-15; K_N times that in forces and at the limits mu N_e/K_T
        np.testing.assert_allclose(getattr(one, name), getattr(two, name), rtol=0.0, atol=1e-10, err_msg=name)
    assert np.count_nonzero(two.xi_t) > 20 and np.count_nonzero(two.xi_r) > 20


@pytest.mark.parametrize("newton", ["on", "off"])
@pytest.mark.parametrize("number", [1, 2])
@pytest.mark.parametrize("written", ["command", "during the run"])
def test_contact_memory_survives(ranks: Callable[..., Frame], scene: dict[str, Any], tmp_path: Path,
                                 newton: str, number: int, written: str) -> None:  # fmt: skip
    """Also from two ranks to one and back."""
    checkpoint = tmp_path / "checkpoint"
    write = f"run 1500\nwrite_restart {checkpoint}\nrun 0" if written == "command" else f"restart 1500 {checkpoint}\nrun 1500"
    before = ranks(number, "run 1500", newton=newton, **scene)
    ranks(number, write, newton=newton, **scene)
    checkpoint = checkpoint if written == "command" else tmp_path / "checkpoint.1500"
    for readers in (1, 2):
        after = ranks(readers, "run 0", reader(checkpoint, newton))
        same_memory(after, before)
        assert np.array_equal(np.sort(after.ids), before.ids)


def test_writing_a_checkpoint_leaves_the_contact_table(
    discs: Callable[..., Any], scene: dict[str, Any], tmp_path: Path
) -> None:
    """The command write_restart wraps and reorders grains: the table must be made anew, and is the one of before."""
    before = discs(**scene).run(1500).frame()
    after = discs(**scene).run(1500).command(f"write_restart {tmp_path / 'c'}")
    with pytest.raises(Exception, match="contact table is out of date"):
        after.frame()
    again = discs(**scene).run(1500).command(f"write_restart {tmp_path / 'c'}\nrun 0")
    same_memory(again.frame(), before)


def test_a_resumed_run_is_the_run(
    discs: Callable[..., Any], ranks: Callable[..., Frame], scene: dict[str, Any], tmp_path: Path
) -> None:
    """Without damping nothing depends on the velocity of half a step before, and the trajectory goes on where it was."""
    scene["law"] = {**LAW, "zeta": 0.0}
    whole = discs(**scene).run(1600).frame()
    ranks(1, f"run 1000\nwrite_restart {tmp_path / 'c'}\nrun 0", **scene)
    resumed = ranks(1, "run 600", reader(tmp_path / "c"))
    # rounding of wrapped positions, amplified by some collisions
    np.testing.assert_allclose(resumed.velocity, whole.velocity, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(resumed.cell, whole.cell, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(resumed.interactions.xi_t, whole.interactions.xi_t, rtol=0.0, atol=1e-9)


def test_accounts_survive(discs: Callable[..., Any], scene: dict[str, Any], tmp_path: Path) -> None:
    """Losses, work of the cell, energy taken by drag, strain rate and inertia."""
    scene["move"] = MOVE + " drag 0.3"
    sample = discs(**scene).run(1000).command(f"write_restart {tmp_path / 'c'}")
    losses, figures = sample.energy()[4:], sample.vector("move", 7)
    again = type(sample)(reader(tmp_path / "c", move=scene["move"]) + "run 0", tmp_path)
    np.testing.assert_array_equal(again.energy()[4:], losses)
    # stresses are sums over pairs whose order and viscous force may differ; the others are copies
    np.testing.assert_array_equal(again.vector("move", 7)[2:], figures[2:])
    assert losses.min() > 0.0 and figures[6] > 0.0
    again.engine.close()


@pytest.mark.parametrize("between", ["", "run 0"])
def test_clocks_of_the_equilibrium_survive(
    discs: Callable[..., Any], scene: dict[str, Any], tmp_path: Path, between: str
) -> None:
    """With criteria that always hold, the time they have held goes on; also after the `run 0` of a deck."""
    calm = {**scene, "velocity": 0.0, "omega": 0.0, "move": "", "law": {"kn": 1e4}}
    sample = discs(**calm, first=CHECK + "run 0").run(200).command(f"write_restart {tmp_path / 'c'}")
    held, quiet = sample.vector("eq", 14)[[9, 12]]
    assert held == pytest.approx(190 * 2e-4) and quiet == pytest.approx(200 * 2e-4)
    again = type(sample)(reader(tmp_path / "c", move="") + CHECK + between, tmp_path).run(100)
    np.testing.assert_allclose(again.vector("eq", 14)[[9, 12]], [held + 0.02, quiet + 0.02], rtol=1e-9)
    again.engine.close()


def test_figures_are_measured_after_a_restart(discs: Callable[..., Any], scene: dict[str, Any], tmp_path: Path) -> None:
    sample = discs(**scene, first=CHECK + "run 1000")
    before = sample.command(f"write_restart {tmp_path / 'c'}").vector("eq", 14)
    again = type(sample)(reader(tmp_path / "c") + CHECK + "run 0", tmp_path)
    # net force and stress hold the viscous force, here of velocities at the full step
    np.testing.assert_allclose(again.vector("eq", 14)[[5, 7, 8, 10, 11]], before[[5, 7, 8, 10, 11]], rtol=1e-9)
    again.engine.close()


def test_contact_history_of_another_law_is_refused(discs: Callable[..., Any], scene: dict[str, Any], tmp_path: Path) -> None:
    """Columns of one law are not those of another: never read as such."""
    sample = discs(**scene).run(100).command(f"write_restart {tmp_path / 'c'}")
    text = reader(tmp_path / "c").replace(
        "neigh_modify", "pair_style disc/continuous\npair_coeff * * index 36 mu 0.5\nneigh_modify"
    )
    with pytest.raises(Exception, match="contact history of another version of the plugin or of another law"):
        type(sample)(text.replace("disc/cohesive", "disc/continuous") + "run 0", tmp_path)

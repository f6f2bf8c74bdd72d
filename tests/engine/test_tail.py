"""pair_style disc/tail: the attraction alone, and the stock law it completes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from workflow.data.discs import Discs
from workflow.errors import EngineError, InputError
from workflow.verification.one_run import run

F0, D0, KN = 1.0, 1e-2, 1e3
ALONE = "pair_style disc/tail\npair_coeff * * f0 1.0 d0 1e-2"
LAW = {"kn": KN, "f0": F0, "d0": D0}
MOVE = "fix move all disc/integrate"


@pytest.fixture
def tail(discs: Callable[..., Any], rewrite: Callable[[str, str], None]) -> Callable[..., Any]:
    """Opens grains that feel the tail alone, moved by LAMMPS's own integrator."""
    rewrite("pair_style disc/cohesive\n", "\n")
    rewrite("pair_coeff * * kn", ALONE + "\n#")
    rewrite("neigh_modify once yes", "neigh_modify delay 0 every 1 check yes")
    rewrite(MOVE, "fix move all nve/sphere disc #")
    for line in ("compute energy", "compute pairs"):
        rewrite(line, "#")
    rewrite("c_energy c_energy[1]", "")
    return discs


def pair_at(gap: float) -> dict[str, Any]:
    return {"position": [[5.0, 5.0], [5.75 + gap, 5.0]], "diameter": [1.0, 0.5], "law": LAW}


@pytest.mark.parametrize(
    ("gap", "force", "energy"),
    [
        (-1e-3, -1.0, -0.5 * D0 - 1e-3),  # contact: -F0; -F0 D0/2 + F0 h
        (0.25 * D0, -0.75, -0.5 * D0 * 0.75**2),  # tail: -F0 (1 - h/D0); -F0 (D0 - h)^2/(2 D0)
        (1.01 * D0, 0.0, 0.0),
    ],
)
def test_force_energy_and_virial_of_a_pair(tail: Callable[..., Any], gap: float, force: float, energy: float) -> None:
    sample = tail("thermo_style custom step pe pxx\nthermo_modify norm no\nrun 0", **pair_at(gap))
    # absolute: the gap is a difference of numbers of order 1, rounded to 1e-16, times the slope F0/D0 = 100
    assert sample.value("fx[2]") == pytest.approx(force, abs=1e-12)
    assert sample.value("fx[1]") == pytest.approx(-force, abs=1e-12)
    assert sample.value("pe") == pytest.approx(energy, abs=1e-12)
    assert sample.value("pxx") == pytest.approx(force * (0.75 + gap) / 100.0, abs=1e-12)


def test_hybrid_gives_the_force_of_the_exact_law_at_rest(tmp_path: Any) -> None:
    """Elastic contacts, tails and pairs out of reach at rest: both laws are the same function of the positions."""
    rng = np.random.default_rng(3)
    places = np.array([[x, y] for x in range(4) for y in range(4)]) * 0.995 + rng.uniform(-5e-3, 5e-3, (16, 2)) + 1.0
    grains = Discs(np.ones(16), places, np.full(2, 6.0))
    values = {"kn": KN, "zeta": 0.0, "mu": 0.0, "f0": F0, "d0": D0, "step": 1e-4, "steps": 1}
    exact, stock = (run(grains, {**values, "contact_model": law}) for law in ("disc", "stock"))
    assert np.abs(exact.velocity).max() > 1e-4  # something pulls
    # one step of 1e-4 under forces of order 10 that differ by the rounding of gaps times K_N
    np.testing.assert_allclose(stock.velocity, exact.velocity, atol=1e-13)


def test_tail_states_what_is_wrong() -> None:
    grains = Discs(np.ones(2), np.array([[1.0, 1.0], [3.0, 1.0]]), np.full(2, 6.0))
    with pytest.raises((InputError, EngineError), match=r"d0 = 0.* must be given and positive"):
        run(grains, {"contact_model": "stock", "f0": 1.0, "d0": 0.0, "steps": 1})

"""What calls itself in equilibrium bears its stress: commands that ended at once, in an empty cell, with version 0.2."""

from __future__ import annotations

import json

import numpy as np
import pytest
from wf_process import Wf

# soft grains in a dense gas: the compression takes some hundred T0
SMALL = ["--n", "30", "--kappa", "1e3", "--d0", "0.01", "--hold", "1"]
CASES = {
    "method1, P* = 1e-6": (["method1", "--phi0", "0.6", "--pstar", "1e-6", "--max-time", "200"], 1e-6, False),
    "method1, P* = 9e-5": (["method1", "--phi0", "0.6", "--pstar", "9e-5"], 9e-5, True),
    "method1, wide tolerance": (["method1", "--phi0", "0.6", "--force-tolerance", "0.02"], 0.01, True),
    "consolidation from 1e-5": (
        ["consolidation", "--rolling", "--soft-kappa", "1e3", "--phi0", "0.5", "--quiet", "2", "--pstar-first", "1e-5",
         "--pstar", "1e-5", "--max-time", "1500"], 1e-5, True,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_equilibrium_is_claimed_only_of_a_stress_that_contacts_bear(name: str, wf: Wf, tmp_path: object) -> None:
    """With the time that a stress takes it is reached, and not before."""
    words, pressure, reached = CASES[name]
    done = wf("run", *words, *SMALL, "--out", "run", "--json")
    assert done.returncode == (0 if reached else 3), done.stderr
    numbers = json.loads(done.stdout)
    assert numbers["equilibrated"] is reached
    # of the contact table, without the kinetic part; N_v acts in the criterion too, and is below 1e-3 of it at rest
    error = max(abs(numbers["stress"][axis] - pressure) for axis in ("xx", "yy"))
    if reached:
        assert numbers["coordination"] > 1.5
        assert error < 1.01 * min(1e-4, 0.01 * pressure)
    else:
        assert error > 0.01 * pressure
    assert np.isfinite(error)

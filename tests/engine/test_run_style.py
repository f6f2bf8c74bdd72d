"""run_style verlet/disc leaves out what nobody looks at, and nothing else: the same bits as run_style verlet."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

LAW = {"kn": 1e4, "kt": 1e4, "zeta": 0.5, "mu": 0.4, "f0": 1.0, "d0": 2e-3, "kr": 1.0, "mur": 1e-2}


@pytest.fixture(scope="module")
def compressed(gas: Callable[..., Any]) -> dict[str, Any]:
    """A gas that becomes dense within a few thousand steps, with several rebuilds of the list."""
    return {**gas(60, 0.5, seed=3), "law": LAW, "step": 2e-4, "skin": 0.03}


@pytest.mark.parametrize("move", ["", "stress 5 5", "stress 5 NULL drag 0.5 rate 0.1", "stress 5 5 convention 1"])
@pytest.mark.parametrize("newton", ["on", "off"])
def test_run_style_gives_the_bits_of_run_style_verlet(
    discs: Callable[..., Any], compressed: dict[str, Any], move: str, newton: str
) -> None:
    """Whatever steps are watched, and however many at a stretch."""
    runs = []
    for commands in ("run 3000", "run_style verlet/disc\nthermo 7\nrun 3000", "run_style verlet/disc\nrun 1\nrun 2999 pre no"):
        sample = discs(**compressed, move=move, newton=newton, first="").command(commands)
        frame = sample.frame()
        runs.append((frame.position, frame.velocity, frame.omega, frame.cell, frame.force, frame.interactions.xi_t,
                     sample.vector("move", 7), sample.energy()))  # fmt: skip
    for other in runs[1:]:
        for mine, theirs in zip(runs[0], other, strict=True):
            np.testing.assert_array_equal(mine, theirs)


def test_run_style_obeys_a_fix_that_acts_within_the_step(discs: Callable[..., Any], compressed: dict[str, Any]) -> None:
    """Then every step is LAMMPS's own."""
    push = "fix push all addforce 0.1 0 0\n"
    plain = discs(**compressed, first=push).run(500).frame()
    ours = discs(**compressed, first=f"{push}run_style verlet/disc\n").run(500).frame()
    np.testing.assert_array_equal(ours.velocity, plain.velocity)
    assert np.sum(plain.diameter**2 @ plain.velocity[:, 0]) > 0.9 * 0.1 * 60 * 0.1


def test_arguments_are_refused(discs: Callable[..., Any], compressed: dict[str, Any]) -> None:
    with pytest.raises(Exception, match="run_style verlet/disc takes no arguments, not 'fast'"):
        discs(**compressed, first="run_style verlet/disc fast")


@pytest.mark.parametrize(("number", "newton"), [(2, "off"), (4, "on")])
def test_run_style_gives_the_same_motion_on_any_number_of_ranks(
    ranks: Callable[..., Any], compressed: dict[str, Any], number: int, newton: str
) -> None:
    """Short of chaos the number of ranks matters to rounding only; four share the corners of the cell."""
    scene = {**compressed, "newton": newton, "move": "stress 5 5"}
    one = ranks(1, "run_style verlet/disc\nrun 600", **scene)
    more = ranks(number, "run_style verlet/disc\nrun 600", **scene)
    # 1e-15 per step and sum order, amplified by a few collisions
    np.testing.assert_allclose(more.velocity, one.velocity, rtol=0.0, atol=1e-9)
    assert len(one.interactions.xi_t) > 10

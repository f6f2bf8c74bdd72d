"""Wrong input is refused with a message that names the keyword or command that mends it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

# replaced text of the deck -> replacement, words of the message
WRONG = {
    "unknown keyword": ("kn 1000", "kn 1000 cohesion 1", "unknown keyword 'cohesion'"),
    "negative kn": ("kn 1000", "kn -1", "kn = -1 must not be negative"),
    "no kn": ("kn 1000", "zeta 0.5", "'kn' must be given"),
    "not a number": ("kn 1000", "kn stiff", "stiff"),
    "nan": ("kn 1000", "kn nan", "instead of 'nan'"),
    "negative mu": ("kn 1000", "kn 1000 kt 1 mu -0.1", "mu = -0.1 must not be negative"),
    "mu without kt": ("kn 1000", "kn 1000 mu 0.5", "'kt' must be given"),
    "f0 without d0": ("kn 1000", "kn 1000 f0 1", "'d0' must be given"),
    "mur without kr": ("kn 1000", "kn 1000 mur 0.1", "'kr' must be given"),
    "missing value": ("kn 1000", "kn 1000 kt", "'kt' needs a value"),
    "types": ("pair_coeff * *", "pair_coeff 1 1", "must start with"),
    "no coefficients": ("pair_coeff * * kn 1000", "", "pair_coeff|coeffs"),
    "account without value": ("disc/cohesive\n", "disc/cohesive account\n", "'account' needs a value"),
    "style keyword": ("disc/cohesive\n", "disc/cohesive speed yes\n", "unknown keyword 'speed'"),
    "ghost velocities": ("vel yes", "vel no", "comm_modify vel yes"),
    "skin below the range": ("kn 1000", "kn 1000 f0 1 d0 0.2", "skin 0.1 must exceed the range 0.2"),
    "stress with one value": ("integrate ", "integrate stress 1", "'stress' needs two values"),
    "fix keyword": ("integrate ", "integrate pressure 1", "unknown keyword 'pressure'"),
    "fix value": ("integrate ", "integrate rate", "'rate' needs a value"),
    "negative rate": ("integrate ", "integrate rate -1", "rate = -1 must not be negative"),
    "negative drag": ("integrate ", "integrate drag -1", "drag = -1 must not be negative"),
    "no mass": ("integrate ", "integrate mass 0", "mass = 0 must be positive"),
    "convention": ("integrate ", "integrate convention 2", "convention = 2 must be -1, 0 or 1"),
    "group": ("fix move all", "group some id 1\nfix move some", "group must be 'all'"),
    "open axis": ("boundary p p p", "boundary f p p", "must be periodic"),
    "no interval": ("compute energy", "fix eq all disc/equilibrium\ncompute energy", "interval N"),
    "interval": ("compute energy", "fix eq all disc/equilibrium 0\ncompute energy", "N = 0 must be at least 1"),
    "no unit": ("compute energy", "fix eq all disc/equilibrium 10\ncompute energy", "'unit'"),
    "equilibrium keyword": ("compute energy", "fix eq all disc/equilibrium 10 units 1\ncompute energy", "unknown keyword 'units'"),
    "equilibrium value": ("compute energy", "fix eq all disc/equilibrium 10 unit 1 hold\ncompute energy", "'hold' needs a value"),
}  # fmt: skip
TWO: dict[str, Any] = {"position": np.array([[1.0, 1.0], [2.5, 1.0]]), "diameter": np.ones(2), "law": {"kn": 1000.0}}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input_is_refused(discs: Callable[..., Any], rewrite: Callable[[str, str], None], name: str) -> None:
    old, new, words = WRONG[name]
    rewrite(old, new)
    move = "stress 1 1" if name == "open axis" else ""
    with pytest.raises(Exception, match=words):
        discs(**TWO, move=move)


@pytest.mark.parametrize("cell", [(2.1, 10.0), (10.0, 2.1)])
def test_a_cell_too_small_is_refused(discs: Callable[..., Any], cell: tuple[float, float]) -> None:
    with pytest.raises(Exception, match=r"cell length 2.1 .* is below 2.2"):
        discs(**{**TWO, "position": TWO["position"] % cell}, cell=cell)


def test_a_cell_that_becomes_too_small_is_refused(discs: Callable[..., Any], gas: Callable[..., Any]) -> None:
    sample = discs(**gas(8, 0.3, seed=1, speed=0.0), law={"kn": 1e3}, step=1e-3, move="stress 1e9 NULL rate 0.5")
    with pytest.raises(Exception, match=r"cell length .* along x is below"):
        sample.run(2000)


def test_a_collapsing_cell_is_refused(discs: Callable[..., Any]) -> None:
    with pytest.raises(Exception, match="the cell collapsed"):
        discs(**TWO, step=0.1, move="stress 1e9 1e9").run(10)


def test_an_axis_that_was_fixed_stays_fixed(discs: Callable[..., Any]) -> None:
    with pytest.raises(Exception, match="axis y was fixed"):
        discs(**TWO, move="stress 1 NULL").command("fix_modify move stress 1 1")


def test_a_pair_style_without_contacts_is_refused_by_name(discs: Callable[..., Any]) -> None:
    other = "uncompute energy\nuncompute pairs\nthermo_style one\npair_style zero 1.0\npair_coeff * *\n"
    with pytest.raises(Exception, match="fix disc/equilibrium cannot read the contacts of pair_style zero"):
        discs(**TWO, first=other + "fix eq all disc/equilibrium 10 unit 1\nrun 0")


def test_a_cell_under_stress_defined_for_another_pair_style_is_refused(discs: Callable[..., Any]) -> None:
    other = "uncompute energy\nuncompute pairs\nthermo_style one\npair_style zero 1.0\npair_coeff * *\nrun 0"
    with pytest.raises(Exception, match="define it again after pair_style"):
        discs(**TWO, move="stress 1 1", first=other)


def test_coinciding_grains_are_refused(discs: Callable[..., Any]) -> None:
    """No direction to push in: 0/0 must not spread silently."""
    sample = discs(position=[[1.0, 1.0], [1.0, 1.0], [3.0, 3.0]], diameter=np.ones(3), law={"kn": 1e3}, step=1e-4, first="")
    with pytest.raises(Exception, match="ERROR"):
        sample.run(1000)


def test_grains_nearly_on_top_of_each_other_are_pushed_apart(discs: Callable[..., Any]) -> None:
    sample = discs(position=[[1.0, 1.0], [1.0, 1.0 + 1e-9]], diameter=np.ones(2), law={"kn": 1e3}, step=1e-4).run(1000)
    # all of K_N d^2/2 becomes kinetic energy of two masses 1; Verlet with omega dt = 0.004 is exact to its square
    np.testing.assert_allclose(sample.frame().velocity, [[0.0, -np.sqrt(500.0)], [0.0, np.sqrt(500.0)]], rtol=1e-4, atol=1e-6)

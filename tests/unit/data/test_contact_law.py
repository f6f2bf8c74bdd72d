"""One class states the constants of the law: what it allows, and that every station means the same by it."""

from __future__ import annotations

import math
from dataclasses import asdict, fields

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workflow.data.contact_law import ContactLaw
from workflow.errors import InputError
from workflow.reference.cohesive import CohesiveLaw
from workflow.scene.method1 import Method1

NAMES = [field.name for field in fields(ContactLaw)]
POSITIVE = st.floats(1e-12, 1e12)
LAWS = st.builds(ContactLaw, kn=POSITIVE, **{name: POSITIVE | st.just(0.0) for name in NAMES[1:]})


@given(LAWS)
def test_reference_takes_every_law_that_a_scene_can_have(law: ContactLaw) -> None:
    reference = CohesiveLaw(**asdict(law))
    assert asdict(reference) == asdict(law)
    assert reference.cutoff_gap == law.cutoff_gap == (law.d0 if law.f0 else 0.0)


@given(LAWS)
def test_tail_is_the_slope_of_the_attraction_and_never_stiffens(law: ContactLaw) -> None:
    assert law.tail_stiffness <= 0.0
    assert (law.tail_stiffness < 0.0) == (law.f0 > 0.0 and law.d0 > 0.0)
    if law.tail_stiffness:
        assert law.tail_stiffness * law.d0 == pytest.approx(-law.f0, rel=1e-15)


@given(st.sampled_from(NAMES), st.floats(max_value=0.0, exclude_max=True) | st.just(math.nan) | st.just(math.inf))
def test_value_out_of_range_is_named(name: str, value: float) -> None:
    unlimited = name in ("mu", "mur") and value == math.inf
    if unlimited or (name == "mu" and math.isnan(value)):  # never slips, or not known
        ContactLaw(**{"kn": 1.0, name: value})
        return
    with pytest.raises(InputError, match=f"law: '{name}' is "):
        ContactLaw(**{"kn": 1.0, name: value})


def test_reference_refuses_a_friction_that_is_not_known() -> None:
    with pytest.raises(InputError, match="'mu' is nan"):
        CohesiveLaw(kn=1.0, mu=math.nan)


@pytest.mark.parametrize("cohesion", [True, False])
@pytest.mark.parametrize("rolling", [True, False])
def test_deck_is_given_the_constants_of_the_scene(cohesion: bool, rolling: bool) -> None:
    scene = Method1(cohesion=cohesion, rolling=rolling, mu=0.3)
    law, variables = scene.law_in_units, scene.variables()
    assert {name: variables[name] for name in NAMES} == asdict(law)
    assert (law.cohesive, law.rolling) == (cohesion, rolling)

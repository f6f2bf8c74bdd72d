"""SI values of the units of scenes."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workflow.data.si import DIMENSIONS, FORCES, Powder, in_words
from workflow.errors import InputError
from workflow.pipeline.si import of_measures, of_scene
from workflow.scene.heap import Heap
from workflow.scene.method1 import Method1
from workflow.scene.method2 import Method2
from workflow.scene.registry import SCENES

TONER = Powder.of("10um", "1200", force="30nN")
sizes = st.floats(1e-7, 1e-1)


def test_a_toner_has_the_numbers_of_the_paper() -> None:
    """G07 sec. II C: a = 10 um, some tens of nN, D0 of 10 nm; F0/a^2 of the order of 100 Pa, P* = 0.01 about 1 Pa."""
    assert TONER.unit("stress") == (pytest.approx(300.0), "Pa")
    assert TONER.unit("time")[0] == pytest.approx(math.sqrt(1200.0 * math.pi / 6.0 * 1e-15 * 1e-5 / 30e-9))
    assert dict((name, value) for name, value, _ in of_scene(Method2(), TONER))["V*"] == pytest.approx(math.sqrt(1e-3))
    assert TONER.words(1e-3, "length") == "10 nm" and TONER.back("3Pa") == ("stress", pytest.approx(0.01))


@given(a=sizes, density=st.floats(100.0, 2e4), force=st.floats(1e-12, 1.0), value=st.floats(1e-6, 1e6))
def test_what_is_converted_comes_back(a: float, density: float, force: float, value: float) -> None:
    powder = Powder.of(f"{a!r} m", f"{density!r} kg/m^3", force=f"{force!r} N")
    for dimension in DIMENSIONS:
        factor, unit = powder.unit(dimension)
        assert powder.back(f"{value * factor!r} {unit}") == (dimension, pytest.approx(value))


@given(a=sizes, density=st.floats(100.0, 2e4))
def test_units_fit_together(a: float, density: float) -> None:
    """F = m a/T^2, whatever sets it; of a heap T^2 = a/g."""
    for by, text in {"force": "1nN", "pressure": "2kPa", "gravity": "9.81"}.items():
        powder = Powder.of(f"{a!r}m", f"{density!r}", **{by: text})
        assert powder.force == pytest.approx(powder.mass * powder.length / powder.time**2)
        assert powder.unit("energy")[0] == pytest.approx(powder.mass * powder.unit("velocity")[0] ** 2)
        if by == "gravity":
            assert powder.time**2 == pytest.approx(a / 9.81)
        if by == "pressure":
            assert powder.unit("stress")[0] == pytest.approx(2000.0)


@pytest.mark.parametrize("text", ["", "um", "10", "10um um", "10 lightbulbs", "-1um", "0um", "inf m", "nan m", "1e999m", "10Pa",
                                  "9**9**9**9um", "__import__('os')", "10um;", "1" * 500])  # fmt: skip
def test_what_is_no_length_is_refused(text: str) -> None:
    if text == "10":
        assert Powder.of(text, "1200", force="1N").length == 10.0  # metres, as the help says
        return
    with pytest.raises(InputError, match=r"--diameter .* is not allowed: give a number above 0 and a unit of .m., for example"):
        Powder.of(text, "1200", force="1N")


@pytest.mark.parametrize("scene", SCENES)
def test_every_unit_of_a_parameter_has_a_dimension(scene: str) -> None:
    """Those of P* and V0 by their own rows; so no parameter with a unit is left out in silence."""
    from dataclasses import fields

    from workflow.pipeline.si import UNITS
    from workflow.scene.parameter import quantity_of

    units = {quantity_of(item).unit for item in fields(SCENES[scene])} - {"", "V*"}
    assert units <= set(UNITS)


def test_a_scene_needs_what_sets_its_forces() -> None:
    beads, heap = Powder.of("1mm", "2500", pressure="1kPa"), Powder.of("1mm", "2500", gravity="9.81")
    for scene, fits in ((Method1(), TONER), (Method1(cohesion=False), beads), (Heap(grains=20), heap)):
        assert list(of_scene(scene, fits))
        for powder in (TONER, beads, heap):
            if powder is not fits:
                with pytest.raises(InputError, match=f"give --{fits.by} instead of --{powder.by}"):
                    list(of_scene(scene, powder))
    assert set(FORCES) == {"force", "pressure", "gravity"}


def test_measures_without_a_number_are_left_out() -> None:
    found = {name for name, _, _ in of_measures({"time": 3.0, "stress": {"xx": 1.0}, "height": None, "numerics": "none"})}
    assert found == {"time", "stress xx"} and in_words(0.0, "Pa") == "0 Pa"

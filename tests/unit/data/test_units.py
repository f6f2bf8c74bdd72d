"""The unit of a quantity follows from the names of the units of length, force and time."""

from __future__ import annotations

from dataclasses import fields

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workflow.data.frame import Frame, Interactions
from workflow.data.units import DIMENSIONS, UNKNOWN, Units

COHESIVE, SMOOTH, HEAP = Units("a", "F₀", "T₀"), Units("a", "aP", "T₀"), Units("σ", "mg", "√(σ/g)")


@pytest.mark.parametrize(
    ("units", "quantity", "expected"),
    [
        (COHESIVE, "position", "a"), (COHESIVE, "velocity", "a/T0"), (COHESIVE, "omega", "1/T0"), (COHESIVE, "force", "F0"),
        (COHESIVE, "torque", "a F0"), (COHESIVE, "stress_x", "F0/a"), (COHESIVE, "mass", "m"), (COHESIVE, "ids", "1"),
        (SMOOTH, "force", "a P"), (SMOOTH, "stress_x", "P"), (SMOOTH, "work", "a^2 P"),
        (HEAP, "velocity", "sigma/sqrt(sigma/g)"), (HEAP, "force", "m g"), (HEAP, "moment", "sigma m g"),
        (HEAP, "passed", UNKNOWN),
    ],
)  # fmt: skip
def test_unit_of_a_quantity_is_a_product_of_powers(units: Units, quantity: str, expected: str) -> None:
    assert units.plain.of(quantity) == expected


def test_names_of_forces_in_the_time_series_are_energies() -> None:
    assert COHESIVE.plain.of("elastic") == "F0" and COHESIVE.plain.of_series("elastic") == "a F0"
    assert COHESIVE.plain.of_series("net_force") == "F0"


def test_every_array_of_a_frame_has_a_unit() -> None:
    names = {field.name for field in (*fields(Frame), *fields(Interactions))}
    assert names - set(DIMENSIONS) == {"interactions", "periodic", "lacks", "notes", "units"}


@given(st.sampled_from([COHESIVE, SMOOTH, HEAP]), st.sampled_from(sorted(DIMENSIONS)))
def test_units_in_files_are_ascii(units: Units, quantity: str) -> None:
    assert units.plain.of(quantity).isascii() and units.plain.of_series(quantity).isascii()

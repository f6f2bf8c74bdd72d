"""Scenes have units of their own; a powder gives them SI values: its largest diameter, its density and what sets its forces.

A cell of discs is taken as a layer of spheres that is one diameter thick: mass m = pi rho a^3/6 of the largest grain, and a
stress of the scene, force over length, is divided by the thickness a.  Time is sqrt(m a/F), F the unit of force: F0 with
cohesion, P a^2 without, m g of a heap.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache
from typing import Any

from workflow.errors import InputError

FORCES = {"force": "N", "pressure": "Pa", "gravity": "m/s^2"}  # what sets the unit of force, one of them
STANDS_FOR = {"force": "the attraction F0", "pressure": "the pressure P of a scene without cohesion", "gravity": "g of a heap"}
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([\w/*^ .²³-]{0,30})")


@cache
def registry() -> Any:
    """The units of pint, which takes half a second to load."""
    import pint

    return pint.UnitRegistry()


def measured(text: str, unit: str, name: str) -> float:
    """A quantity such as 10um, in ``unit``, which is also meant where none is given.  Raises InputError unless above 0."""
    example = f"{name} '{text}' is not allowed: give a number above 0 and a unit of [{unit}], for example {EXAMPLES[unit]}"
    found = quantity(text, unit)
    try:
        value = float(found.to(unit).magnitude) if found is not None else math.nan
    except Exception as fault:  # of another dimension; pint has many errors
        raise InputError(example) from fault
    if not 0.0 < value < math.inf:
        raise InputError(example)
    return value


EXAMPLES = {"m": "10um", "kg/m^3": "1200kg/m^3", "N": "30nN", "Pa": "1kPa", "m/s^2": "9.81m/s^2"}


def quantity(text: str, unit: str = "") -> Any:
    """Number and unit as a quantity of pint, ``unit`` where the text has none; None if it is not understood."""
    parts = _NUMBER.fullmatch(text)
    if not parts:
        return None
    try:
        return registry().Quantity(float(parts[1]), registry().parse_units(parts[2] or unit))
    except Exception:  # whatever the word may be
        return None


def in_words(value: float, unit: str) -> str:
    """A value with a prefix that makes it readable, such as 14.5 µs."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g} {unit}"
    return f"{registry().Quantity(value, unit).to_compact():.4g~P}"


@dataclass(frozen=True)
class Powder:
    """SI values of the units of scenes: ``length`` [m], ``mass`` [kg], ``force`` [N]; ``by``: which of FORCES set the last."""

    length: float
    mass: float
    force: float
    by: str

    @classmethod
    def of(cls, diameter: str, density: str, **given: str | None) -> Powder:
        """From quantities in words; ``given``: one of FORCES.  Raises InputError."""
        a, rho = measured(diameter, "m", "--diameter"), measured(density, "kg/m^3", "--density")
        mass = math.pi / 6.0 * rho * a**3
        chosen = [(name, text) for name, text in given.items() if text is not None]
        if len(chosen) != 1:
            options = ", ".join(f"--{name} ({STANDS_FOR[name]})" for name in FORCES)
            raise InputError(f"the unit of force needs one of {options}; found {len(chosen)} of them")
        by, text = chosen[0]
        value = measured(text, FORCES[by], f"--{by}")
        return cls(a, mass, value * {"force": 1.0, "pressure": a * a, "gravity": mass}[by], by)

    @property
    def time(self) -> float:
        """sqrt(m a/F) [s]."""
        return math.sqrt(self.mass * self.length / self.force)

    def unit(self, dimension: str) -> tuple[float, str]:
        """Value of the unit of a dimension in SI, and the name of that SI unit."""
        length, force, time = self.length, self.force, self.time
        return {
            "length": (length, "m"), "mass": (self.mass, "kg"), "force": (force, "N"), "time": (time, "s"),
            "velocity": (length / time, "m/s"), "rate": (1.0 / time, "1/s"), "stress": (force / length**2, "Pa"),
            "stiffness": (force / length, "N/m"), "energy": (force * length, "J"),
        }[dimension]  # fmt: skip

    def words(self, value: float, dimension: str) -> str:
        """A value of a scene in SI, with its unit."""
        factor, unit = self.unit(dimension)
        return in_words(value * factor, unit)

    def back(self, text: str) -> tuple[str, float]:
        """Dimension of an SI quantity in words, and its value in the scene.  Raises InputError for what scenes have not."""
        found = quantity(text)
        for dimension in DIMENSIONS:
            factor, unit = self.unit(dimension)
            if found is not None and found.is_compatible_with(unit):
                return dimension, float(found.to(unit).magnitude) / factor
        known = ", ".join(DIMENSIONS)
        raise InputError(f"'{text}' is no quantity of a scene: give a number and a unit of {known}, such as 5Pa")


DIMENSIONS = ("length", "mass", "force", "time", "velocity", "rate", "stress", "stiffness", "energy")

"""Units by name: what a scene measures in, and from that the unit of every quantity, as files and reprs state it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

# exponents of length, force, time and mass of a quantity, by its name in Frame, Interactions and the time series
_NONE, _LENGTH, _FORCE, _TIME, _MASS = (0, 0, 0, 0), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)
_SPEED, _ENERGY, _STRESS, _RATE = (1, 0, -1, 0), (1, 1, 0, 0), (-1, 1, 0, 0), (0, 0, -1, 0)  # a moment is as an energy
DIMENSIONS: dict[str, tuple[int, int, int, int]] = {
    name: dimension
    for dimension, names in {
        _NONE: "step stage ids i j offset sliding rolling xi_r provenance solid_fraction coordination contacts distant "
               "rattlers aggregates largest_aggregate waiting poured removed",
        _LENGTH: "position diameter cell origin branch gap xi_t length_x length_y top overlap largest_overlap largest_advance",
        _TIME: "time held quiet",
        _MASS: "mass",
        _SPEED: "velocity approach largest_approach",
        _RATE: "omega",
        _FORCE: "force elastic viscous attraction tangential normal_force net_force",
        _ENERGY: "torque moment net_moment kinetic_per_grain kinetic_per_grain_raw kinetic adhesive lost_viscous lost_sliding "
                 "lost_rolling lost_drag work residual gravity energy_in energy_out",
        _STRESS: "stress_x stress_y",
    }.items()
    for name in names.split()
}  # fmt: skip
# of the time series alone: elastic energies under the names of the forces and flags of a contact
_ENERGIES = {"elastic", "tangential", "rolling"}
UNKNOWN = "unknown"  # of a column that somebody's scene has and this table has not
_ASCII = str.maketrans({"₀": "0", "₁": "1", "σ": "sigma", "√": "sqrt"})
_PRODUCTS = {"aP": ("a", "P"), "mg": ("m", "g")}  # names of forces that are products


class Units(NamedTuple):
    """Names of the units of length, force and time; that of mass is the mass of a disc of diameter 1, "m"."""

    length: str
    force: str
    time: str

    @property
    def plain(self) -> Units:
        """The same in ASCII, for files: F0, sqrt(sigma/g)."""
        return Units(*(name.translate(_ASCII) for name in self))

    def of(self, quantity: str) -> str:
        """Unit of a field of Frame or Interactions: "F0/a" for a stress, "1" for a number, UNKNOWN for what has no entry."""
        return self._named(DIMENSIONS[quantity]) if quantity in DIMENSIONS else UNKNOWN

    def of_series(self, column: str) -> str:
        """Unit of a column of the time series."""
        return self._named(_ENERGY) if column in _ENERGIES else self.of(column)

    def _named(self, dimension: tuple[int, int, int, int]) -> str:
        powers: dict[str, int] = {}
        for name, power in zip((*self, "m"), dimension, strict=True):
            for factor in _PRODUCTS.get(name, (name,)):
                powers[factor] = powers.get(factor, 0) + power
        above, below = (" ".join(_powers(powers, sign)) for sign in (1, -1))
        return f"{above or '1'}/{below}" if below else above or "1"


def _powers(powers: dict[str, int], sign: int) -> Iterator[str]:
    for name, power in powers.items():
        if power * sign > 0:
            yield name if abs(power) == 1 else f"{name}^{abs(power)}"

"""Consolidation: the aggregate of method 2 under a rising, and if wanted falling, series of stresses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from workflow.data.contact_law import ContactLaw
from workflow.errors import InputError
from workflow.scene.method2 import Method2
from workflow.scene.parameter import parameter

MOST_STRESSES = 200  # of one run


@dataclass(frozen=True, kw_only=True, repr=False)
class Consolidation(Method2):
    """Scene `consolidation`.

    Stages 1 to 4 are those of method 2; then for each stress P*: load (no dashpots, until borne), settle (dashpots, to
    equilibrium), named "load P" and "settle P", of the falling series "unload P" and "resettle P".
    """

    name: ClassVar[str] = "consolidation"
    template: ClassVar[Path | None] = Path("method2.in")
    title: ClassVar[str] = "an aggregate pressed by a series of stresses (after G07 method 2)"

    pstar: float = parameter(
        10.0, float, "highest reduced pressure P* = P a/F0", symbol="P*", unit="F0/a", above=0.0, high=100.0
    )
    pstar_first: float = parameter(1e-3, float, "lowest reduced pressure", symbol="P*", unit="F0/a", above=0.0, high=100.0)
    per_decade: float = parameter(2.0, float, "stresses per factor of ten, at equal ratios", above=0.0, high=100.0)
    unload: bool = parameter(False, bool, "go back through the same stresses to the lowest")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.pstar_first > self.pstar:
            raise InputError(
                f"pstar_first = {self.pstar_first:g} is not allowed: it must not exceed the highest, pstar = {self.pstar:g}"
            )
        if len(self.stresses) > MOST_STRESSES:
            raise InputError(
                f"per_decade = {self.per_decade:g} is not allowed: it makes {len(self.stresses)} stresses, at most "
                f"{MOST_STRESSES} are allowed; use fewer per decade or a narrower range"
            )

    @property
    def _rising(self) -> int:
        """Steps from the lowest to the highest stress."""
        return math.ceil(math.log10(max(self.pstar / self.pstar_first, 1.0)) * self.per_decade - 1e-9)

    @property
    def _ratio(self) -> float:
        return (self.pstar / self.pstar_first) ** (1.0 / self._rising) if self._rising else 1.0

    @cached_property
    def stresses(self) -> tuple[float, ...]:
        """P* of each load, in their order [F0/a]."""
        up = [self.pstar_first * self._ratio**k for k in range(self._rising + 1)]
        return (*up, *up[-2::-1]) if self.unload else tuple(up)

    @cached_property
    def _loads(self) -> dict[str, float]:
        """Stress of each stage that is under one."""
        top, loads = self._rising, {}
        for k, stress in enumerate(self.stresses):
            for word in ("load", "settle") if k <= top else ("unload", "resettle"):
                loads[f"{word} {stress:.4g}"] = stress
        return loads

    @property
    def stages(self) -> dict[int, str]:  # type: ignore[override]
        """Names of the deck's stages by number."""
        return {**{k: name for k, name in Method2.stages.items() if k < 5}, **dict(enumerate(self._loads, 5))}

    @property
    def settling(self) -> tuple[str, ...]:  # type: ignore[override]
        """The stages with dashpots or drag."""
        return ("relax", "free", "stiffen", *list(self._loads)[1::2])

    @property
    def relaxations(self) -> tuple[tuple[str, str], ...]:  # type: ignore[override]
        """Pairs of stages that show what dashpots and drag did."""
        loads = list(self._loads)
        return (("aggregate", "relax"), *zip(loads[::2], loads[1::2], strict=True))

    @cached_property
    def law_in_units(self) -> ContactLaw:
        """K_N = kappa F0/a at every stress: one material."""
        return self.contact_law(1.0)

    @property
    def force_unit(self) -> float:
        """F0 at every stress: the criteria of equilibrium are those of the lowest."""
        return 1.0

    @property
    def approach_speed(self) -> float:
        """As in method 2, the work of the highest stress shared by the steps up to it."""
        return math.hypot(self.fall_speed(self.pstar / (self._rising + 1)), math.sqrt(2.0 * self.d0))

    def pressure_of(self, stage: str) -> float | None:
        """The cell is fixed while grains aggregate, then free, then under the stress of the stage."""
        return self._loads[stage] if stage in self._loads else super().pressure_of(stage)

    def variables(self) -> dict[str, Any]:
        """Values of the variables of the deck method2.in."""
        return super().variables() | {
            "stress_first": self.pstar_first, "stress_ratio": self._ratio, "stress_rises": self._rising,
            "stress_count": len(self.stresses),
        }  # fmt: skip

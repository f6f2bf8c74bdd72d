"""Parameters of a scene as data: default, symbol, unit, range, meaning and source of each, stated once.

The same statement drives validation, the TOML file, the options of the command line and their help.
"""

from __future__ import annotations

import math
import reprlib
from collections.abc import Iterable, Mapping
from dataclasses import Field, dataclass, field, fields
from typing import Any, ClassVar

from workflow.errors import InputError, did_you_mean

GROUPS = ("grains", "contact law", "protocol", "numerics", "output")  # of parameters, in the order of the help


@dataclass(frozen=True)
class Quantity:
    """What is known of one parameter beyond its name and default.

    ``low``, ``high``: closed range of allowed values; ``above``: a bound that must be exceeded.  ``choices`` instead of a
    range for words.  ``automatic``: None is allowed and stands for a value derived from the rest.  ``group``: that of GROUPS in
    the help, "" for that of the class that declares it.  ``option``: another name of it, the first on the command line.
    """

    kind: type
    meaning: str
    symbol: str = ""
    unit: str = ""
    source: str = ""
    low: float = -math.inf
    high: float = math.inf
    above: float = -math.inf
    choices: tuple[str, ...] = ()
    automatic: bool = False
    group: str = ""
    option: str = ""

    @property
    def allowed(self) -> str:
        """The allowed values in words."""
        if self.kind is bool:
            return "true or false"
        if self.choices:
            return "one of " + ", ".join(self.choices)
        noun = "a whole number" if self.kind is int else "a number"
        parts = [noun]
        if self.above > -math.inf:
            parts.append(f"above {self.above:g}")
        if self.low > -math.inf:
            parts.append(f"not below {self.low:g}")
        if self.high < math.inf:
            parts.append(f"not above {self.high:g}")
        return parts[0] + " " * (len(parts) > 1) + " and ".join(parts[1:])

    def check(self, name: str, value: Any) -> Any:
        """``value`` as ``kind``, or InputError naming parameter, value and what is allowed."""
        if value is None and self.automatic:
            return None
        converted = self._convert(value)
        if converted is None or not self._inside(converted):
            unit = f" [{self.unit}]" if self.unit else ""
            raise InputError(f"{name} = {reprlib.repr(value)} is not allowed: it must be {self.allowed}{unit} ({self.meaning})")
        return converted

    def _convert(self, value: Any) -> Any:
        if self.kind in (bool, str):
            return value if isinstance(value, self.kind) else None
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            return None
        if self.kind is int:
            return int(value) if isinstance(value, int) or value.is_integer() else None
        try:
            return float(value)
        except OverflowError:  # a whole number of hundreds of digits
            return None

    def _inside(self, value: Any) -> bool:
        if self.choices:
            return value in self.choices
        if self.kind in (bool, str):
            return True
        # infinity is a value (mu = inf: no sliding) where no upper bound is set; NaN never is
        return value >= self.low and value > self.above and value <= self.high


def parameter(default: Any, kind: type, meaning: str, **known: Any) -> Any:
    """A dataclass field that carries its Quantity."""
    return field(default=default, metadata={"quantity": Quantity(kind, meaning, **known)})


def quantity_of(item: Field) -> Quantity:
    """The Quantity of a dataclass field."""
    return item.metadata["quantity"]


def unknown_name(name: str, known: Iterable[str], what: str) -> InputError:
    """The error for a misspelt name, with the nearest known ones."""
    known = sorted(known)
    hint = did_you_mean(name, known, 3).rstrip() or f"known are: {', '.join(known)}"
    return InputError(f"unknown {what} {reprlib.repr(name)}; {hint}")


@dataclass(frozen=True, kw_only=True)
class Parameters:
    """Base of every scene: a frozen set of quantities, checked on creation.  ``GROUP``: that of its parameters in the help."""

    GROUP: ClassVar[str] = "protocol"

    def __post_init__(self) -> None:
        for item in fields(self):
            object.__setattr__(self, item.name, quantity_of(item).check(item.name, getattr(self, item.name)))

    @classmethod
    def from_mapping(cls, values: Mapping[str, Any]) -> Parameters:
        """A scene from names and values; unknown names, and one that is there under two names, are errors."""
        known = {item.name for item in fields(cls)}
        named = {quantity_of(item).option: item.name for item in fields(cls)}
        for name in values:
            if name not in known and name not in named:
                raise unknown_name(name, known, "parameter")
            if name in named and named[name] in values:
                raise InputError(f"'{name}' and '{named[name]}' are one parameter; keep one")
        return cls(**{named.get(name, name): value for name, value in values.items()})

    @classmethod
    def group_of(cls, name: str) -> str:
        """Which of GROUPS a parameter is in: its own, or that of the class that declares it first."""
        item = next(item for item in fields(cls) if item.name == name)
        declaring = next(base for base in reversed(cls.__mro__) if name in vars(base).get("__annotations__", {}))
        return quantity_of(item).group or declaring.GROUP  # type: ignore[attr-defined]

    def as_mapping(self) -> dict[str, Any]:
        """Names and values, automatic ones left out."""
        return {item.name: getattr(self, item.name) for item in fields(self) if getattr(self, item.name) is not None}

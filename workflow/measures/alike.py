"""Which samples may be averaged: those that differ in nothing but the seed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

FREE = ("seed",)  # what samples of one kind differ in


def kinds(samples: Sequence[Mapping[str, Any]], free: Sequence[str] = FREE) -> list[list[int]]:
    """The samples, by their parameters, in kinds that differ in nothing but ``free``: numbers of the members of each."""
    found: dict[str, list[int]] = {}
    for number, parameters in enumerate(samples):
        key = repr(sorted((name, repr(value)) for name, value in parameters.items() if name not in free))
        found.setdefault(key, []).append(number)
    return list(found.values())


def differing(samples: Sequence[Mapping[str, Any]], free: Sequence[str] = FREE) -> dict[str, list[Any]]:
    """The parameters besides ``free`` in which samples differ, with the value of each sample (None: it has none)."""
    names = dict.fromkeys(name for parameters in samples for name in parameters if name not in free)
    values = {name: [parameters.get(name) for parameters in samples] for name in names}
    return {name: each for name, each in values.items() if len({repr(value) for value in each}) > 1}


def in_words(different: Mapping[str, Sequence[Any]]) -> str:
    """``differing`` for people: each parameter with its values, every value once."""
    return "; ".join(f"{name} = {' | '.join(dict.fromkeys(map(str, values)))}" for name, values in different.items())


def labels(samples: Sequence[Mapping[str, Any]], names: Sequence[str]) -> list[str]:
    """What tells samples apart in a legend: the parameters in which they differ, ``names`` where that is nothing or alike."""
    different = differing(samples, free=())
    if not different or len(different) > MOST_LABELLED:
        return list(names)
    found = [", ".join(f"{name} = {_word(each[k])}" for name, each in different.items()) for k in range(len(samples))]
    return found if len(set(found)) == len(found) else list(names)


MOST_LABELLED = 3  # parameters in a legend


def _word(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else "none" if value is None else str(value)

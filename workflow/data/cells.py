"""Cells of CSV files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

FORMULA = ("=", "+", "-", "@", "\t", "\r")  # what a spreadsheet takes for the beginning of a formula


def cell(value: Any) -> Any:
    """The value as it is, a text that a spreadsheet would execute behind an apostrophe, which makes it a text there too."""
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value


def cells(row: Iterable[Any]) -> list[Any]:
    """`cell` of each value."""
    return [cell(value) for value in row]


def named_cells(row: Mapping[str, Any]) -> dict[str, Any]:
    """`cell` of each name and value."""
    return {cell(name): cell(value) for name, value in row.items()}

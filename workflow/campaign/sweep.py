"""Parameter grids and seeds declared in one TOML file -> the points of a study."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any

from workflow.campaign.study import Point
from workflow.errors import InputError
from workflow.scene.parameter import unknown_name
from workflow.scene.registry import read_toml

KEYS = {
    "scene": "name of the scene",
    "fixed": "table of parameters that all points share",
    "grid": "table of lists, every combination is a point; or several such tables",
    "seeds": "number of seeds (1, 2, ...), or a list of seeds",
}
MOST_POINTS = 1_000_000


def read_sweep(path: Path) -> list[Point]:
    """The points that the file declares.  Raises InputError saying what is wrong and what is allowed."""
    try:
        return points_of(read_toml(path))
    except InputError as fault:
        words = str(fault).removeprefix("scene file ").removesuffix("; see 'wf run --help' for an example")
        raise InputError(words if str(path) in words else f"study file '{path}': {words}") from fault


def points_of(declared: Mapping[str, Any]) -> list[Point]:
    """The points of a declaration: every combination of the lists of a ``grid`` with ``fixed``, for every seed.

    The last name of the grid varies fastest but for the seed.  Combinations that make the same scene are one point.
    """
    for key in declared:
        if key not in KEYS:
            allowed = "; ".join(f"{name}: {meaning}" for name, meaning in KEYS.items())
            raise InputError(f"{unknown_name(key, KEYS, 'key')}. Allowed are {allowed}; parameters go into fixed or grid")
    fixed, grids = _table("fixed", declared.get("fixed", {})), declared.get("grid", {})
    seeds = _seeds(declared["seeds"]) if "seeds" in declared else None
    scene = {"scene": declared["scene"]} if "scene" in declared else {}
    chosen = [_full(_table("grid", grid), fixed, seeds) for grid in (grids if isinstance(grids, list) else [grids])]
    count = sum(math.prod(len(values) for values in grid.values()) for grid in chosen)
    if not 0 < count <= MOST_POINTS:
        raise InputError(f"the grid has {count} points, 1 to {MOST_POINTS} are allowed; split the study")
    return [
        Point.of({**scene, **fixed, **dict(zip(grid, values, strict=True))})
        for grid in chosen
        for values in product(*grid.values())
    ]


def _full(grid: dict[str, Any], fixed: Mapping[str, Any], seeds: list[Any] | None) -> dict[str, Any]:
    """The grid with its seeds."""
    for name, values in grid.items():
        if not isinstance(values, list) or not values:
            raise InputError(f"grid.{name} = {values!r} is not allowed: it must be a list of values, for example [0.15, 0.5]")
        if name in fixed:
            raise InputError(f"'{name}' stands in fixed and in grid; keep one")
    given = "seed" in fixed or "seed" in grid
    if seeds is not None and given:
        raise InputError("'seed' stands beside seeds; keep one")
    return grid if given else {**grid, "seed": seeds or [1]}


def _table(key: str, table: Any) -> dict[str, Any]:
    if not isinstance(table, dict):
        raise InputError(f"{key} = {table!r} is not allowed: it must be a table, [{key}] with lines NAME = VALUE")
    if "scene" in table:
        raise InputError(f"'scene' stands in {key}; it belongs above the tables, one study has one scene")
    return table


def _seeds(value: Any) -> list[Any]:
    if isinstance(value, list) and value:
        return value
    if isinstance(value, int) and not isinstance(value, bool) and 0 < value <= MOST_POINTS:
        return list(range(1, value + 1))
    raise InputError(f"seeds = {value!r} is not allowed: it must be a number from 1 to {MOST_POINTS} or a list of seeds")

"""Frames from plain arrays: anyone's grains and contacts, periodic repetitions, and pairs found from the geometry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from workflow.data.frame import Floats, Frame, Interactions, Ints
from workflow.errors import InputError

PAIR_FIELDS = tuple(field.name for field in fields(Interactions))
NORMAL = "normal"  # a normal force that is not split into its parts
WITHOUT_NUMBERS = {"elastic": 0.0, "viscous": 0.0, "attraction": 0.0, "tangential": 0.0, "moment": 0.0, "xi_t": 0.0,
                   "xi_r": 0.0, "sliding": False, "rolling": False}  # fmt: skip


def make_frame(
    position: ArrayLike,
    diameter: ArrayLike,
    cell: ArrayLike,
    pairs: Mapping[str, ArrayLike] | None = None,
    *,
    origin: ArrayLike = (0.0, 0.0),
    periodic: tuple[bool, bool] = (True, True),
    **grains: Any,
) -> Frame:
    """Frame from arrays; only what is known need be given.

    ``position`` (N, 2) or (N, 3) (the third column is ignored), ``diameter`` (N,) or one number, ``cell`` (2,) lengths
    of the periodic cell, ``origin`` (2,) its lower corner, ``periodic`` of the axes x, y.  ``pairs``: columns of
    `Interactions`, at least ``i`` and ``j``
    (0-based rows of the grains); None: the discs that touch (`pairs_in_contact`), without forces.  ``branch`` defaults to
    the vector to the nearest image, ``gap`` to its length less the radii, everything else to 0; ``normal`` may stand for
    the three parts of N (its positive values count as elastic, its negative ones as attraction).  ``grains``: further
    fields of `Frame` (mass defaults to diameter^2, ids to 1 ... N).  Raises InputError.
    """
    x = _numbers("position", position)
    if x.ndim != 2 or x.shape[1] not in (2, 3):
        raise InputError(f"position has the shape {x.shape}; give (N, 2), or (N, 3) whose last column is ignored")
    number = len(x)
    size, lengths, corner = (_numbers(*item) for item in (("diameter", diameter), ("cell", cell), ("origin", origin)))
    if lengths.shape != (2,) or not (lengths > 0).all() or corner.shape != (2,):
        raise InputError(f"cell = {lengths}, origin = {corner}: give two lengths above 0 and two coordinates")
    if size.shape not in ((), (number,)) or not (size > 0).all():
        raise InputError(f"diameter has the shape {size.shape} or a value <= 0; give {number} positive numbers, or one")
    x, size = np.ascontiguousarray(x[:, :2]), np.broadcast_to(size, number).copy()
    vectors, scalars = np.zeros((number, 2)), np.zeros(number)
    known: dict[str, Any] = {
        "step": 0, "time": 0.0, "stage": "", "ids": np.arange(1, number + 1), "mass": size**2, "velocity": vectors,
        "omega": scalars, "force": vectors, "torque": scalars,
    }  # fmt: skip
    unknown = set(grains) - set(known)
    if unknown:
        raise InputError(f"'{min(unknown)}' is no field of a frame; known are {', '.join(known)}")
    if pairs is None:
        i, j = pairs_in_contact(x, size, lengths, periodic=periodic)
        pairs = {"i": i, "j": j}
    table = _contacts(pairs, x, size, np.where(periodic, lengths, np.inf))
    return Frame(
        origin=corner, cell=lengths, position=x, diameter=size, interactions=table, periodic=periodic, **known | grains
    )


def _numbers(name: str, values: ArrayLike) -> Floats:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name} is no array of numbers; give floats") from None
    if not np.isfinite(array).all():
        raise InputError(f"{name} holds a value that is not finite; leave such grains or pairs out")
    return array


def _contacts(pairs: Mapping[str, ArrayLike], position: Floats, diameter: Floats, cell: Floats) -> Interactions:
    unknown, missing = set(pairs) - {*PAIR_FIELDS, NORMAL}, {"i", "j"} - set(pairs)
    if unknown or missing:
        what = f"'{min(unknown)}' is no column" if unknown else f"column '{min(missing)}' is missing"
        raise InputError(f"contacts: {what}; the columns are {', '.join(PAIR_FIELDS)}, {NORMAL}; i and j are needed")
    values = {name: _numbers(name, column) for name, column in pairs.items()}
    i, j = (_rows(name, values.pop(name), len(position)) for name in ("i", "j"))
    if NORMAL in values:
        normal = values.pop(NORMAL)
        values = {"elastic": np.maximum(normal, 0.0), "attraction": np.minimum(normal, 0.0)} | values
    branch = values.pop("branch", None)
    if branch is None:
        branch = nearest(position[j] - position[i], cell)
    if branch.shape != (len(i), 2):
        raise InputError(f"contacts: branch has the shape {branch.shape}; give ({len(i)}, 2), vectors from i to j")
    gap = values.pop("gap", np.hypot(*branch.T) - (diameter[i] + diameter[j]) / 2)
    columns = {name: values.get(name, np.full(len(i), value)) for name, value in WITHOUT_NUMBERS.items()}
    columns |= {name: columns[name] != 0 for name in ("sliding", "rolling")}
    return Interactions(i=i, j=j, branch=branch, gap=gap, **columns)


def _rows(name: str, values: Floats, grains: int) -> Ints:
    rows = values.astype(np.int64)
    if values.ndim != 1 or (rows != values).any() or not ((rows >= 0) & (rows < grains)).all():
        raise InputError(f"contacts: '{name}' must hold whole numbers from 0 to {grains - 1}, rows of the grains")
    return rows


def nearest(apart: Floats, cell: Floats) -> Floats:
    """Vectors (M, 2) to the nearest image; ``cell`` (2,) holds infinity along an axis that is not periodic."""
    crossed = np.round(apart / cell)
    return np.asarray(apart - np.where(crossed != 0.0, crossed, 0.0) * np.where(np.isinf(cell), 0.0, cell))


def pairs_in_contact(
    position: Floats, diameter: Floats, cell: Floats, reach: float = 0.0, *, periodic: tuple[bool, bool] = (True, True)
) -> tuple[Ints, Ints]:
    """Pairs (i, j), i < j, whose gap to the nearest image is below ``reach`` [length]: two arrays (M,), sorted.

    A periodic ``cell`` must be wider than twice the largest diameter plus ``reach``, so that a pair meets at one image only.
    """
    widest = float(diameter.max(initial=0.0)) + reach
    lengths = np.where(periodic, cell, np.inf)
    if not 2.0 * widest < lengths.min():
        raise InputError(f"cell = {cell}: pairs would meet at two images; it must exceed {2 * widest:.6g}, repeat the cell")
    inside = np.where(periodic, position % cell, position)
    tree = cKDTree(np.where(inside >= lengths, 0.0, inside), boxsize=np.where(periodic, cell, 0.0))
    pairs = tree.query_pairs(widest, output_type="ndarray")
    apart = nearest(position[pairs[:, 1]] - position[pairs[:, 0]], lengths)
    near = np.hypot(*apart.T) < (diameter[pairs[:, 0]] + diameter[pairs[:, 1]]) / 2 + reach
    i, j = pairs[near].astype(np.int64).T
    order = np.lexsort((j, i))
    return i[order], j[order]


def repeat(frame: Frame, times: tuple[int, int]) -> Frame:
    """``frame`` with its cell repeated ``times`` along the two axes: the same packing, larger (contacts included)."""
    if min(times) < 1:
        raise InputError(f"times = {times}; give two whole numbers of at least 1")
    first, second = (a.ravel() for a in np.indices(times))
    copies, table = len(first), frame.interactions
    # contact k of copy (a, b) ends in the copy that its branch leads to
    place = (frame.position - frame.origin) / frame.cell
    crossed = np.round(table.branch / frame.cell - (place[table.j] - place[table.i])).astype(np.int64)
    to = ((first[:, None] + crossed[:, 0]) % times[0]) * times[1] + (second[:, None] + crossed[:, 1]) % times[1]

    def tiled(values: Any) -> Any:
        return np.tile(values, (copies, *[1] * (values.ndim - 1)))

    contacts = {name: tiled(getattr(table, name)) for name in PAIR_FIELDS}
    contacts["i"] = (table.i + frame.grains * np.arange(copies)[:, None]).ravel()
    contacts["j"] = (table.j + frame.grains * to).ravel()
    shift = np.column_stack((first, second)) * frame.cell
    grains = {name: tiled(getattr(frame, name)) for name in ("diameter", "mass", "velocity", "omega", "force", "torque")}
    position = (frame.position[None] + shift[:, None]).reshape(-1, 2)
    ids = np.arange(1, copies * frame.grains + 1)
    return replace(frame, cell=frame.cell * times, position=position, ids=ids, interactions=Interactions(**contacts), **grains)

"""The printed numbers of a paper, with the scenes and the measure that should give each: data, read from `papers/*.toml`."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from workflow.campaign.study import Point
from workflow.errors import InputError
from workflow.scene.parameter import unknown_name

Sizes = tuple[tuple[int, int], ...]  # (grains, number of samples)


@dataclass(frozen=True)
class Case:
    """A cell of a printed table: which samples it is the mean of.

    ``where``: (table, row, column).  ``options``: values of the scene without size and seed, none if no scene gives it.
    ``sizes``: numbers of samples, seeds 1, 2, ...  ``first``: options of the first sample on top.  ``size``: the parameter
    that is the number of grains.  ``stage``: the one whose last frame is measured, None for the end of the run.
    """

    where: tuple[str, str, str]
    options: Mapping[str, Any]
    sizes: Sizes
    first: Mapping[str, Any]
    size: str
    stage: str | None

    def values(self) -> Iterator[dict[str, Any]]:
        """What makes the scene of each sample."""
        for grains, count in self.sizes:
            for seed in range(1, count + 1):
                on_top = self.first if seed == 1 and grains == self.sizes[0][0] else {}
                yield {**self.options, **on_top, self.size: grains, "seed": seed}


@dataclass(frozen=True)
class Printed:
    """A printed number: ``value`` +- ``error`` (None: not printed), or a bound ``low`` or ``high``, or both.

    ``measure``: path in the measures of a run, or in those of several (see `workflow.campaign.measured`), None if there is
    none.  ``reason``: what is known of a difference; ``misprint``: why the print is doubted.
    """

    case: Case
    quantity: str
    measure: str | None
    value: float | None = None
    error: float | None = None
    low: float | None = None
    high: float | None = None
    reason: str = ""
    misprint: str = ""


@dataclass(frozen=True)
class Drawing:
    """A figure: ``plot`` a kind of `wf plot`, or a sketch that needs no sample, of the samples of ``cases``, ``most`` of each.

    ``partial``: it is drawn of those cases that have finished samples, any other of all or not at all.  ``time``: of the
    frame nearest to it instead of the last.  ``shows``: what the paper's figure shows.
    """

    number: str
    plot: str
    cases: tuple[Case, ...]
    most: int | None
    partial: bool
    time: float | None
    shows: str


@dataclass(frozen=True)
class Paper:
    """``name`` of the file, ``title``, ``short`` name, what its ``uncertainty`` means, numbers and figures.

    ``quick``: it is the small version, of other sizes than the paper's."""

    name: str
    title: str
    short: str
    uncertainty: str
    titles: Mapping[str, str]
    numbers: tuple[Printed, ...]
    drawings: tuple[Drawing, ...]
    quick: bool

    @property
    def tables(self) -> list[str]:
        """Names of the tables that have numbers."""
        return list(dict.fromkeys(number.case.where[0] for number in self.numbers))

    def chosen(self, tables: Sequence[str] | None, figures: Sequence[str] | None) -> tuple[list[Printed], list[Drawing]]:
        """Numbers and figures of a selection; everything if neither is given.  Raises InputError for unknown ones."""
        whole = tables is None and figures is None
        for name in tables or ():
            if name not in self.tables:
                raise InputError(f"--table {name} is not known in {self.short}; there are: {', '.join(self.tables)}")
        known = list(dict.fromkeys(_integer(drawing.number) for drawing in self.drawings))
        for name in figures or ():
            if not any(_names(name, drawing) for drawing in self.drawings):
                raise InputError(f"--figure {name} is not known in {self.short}; there are: {', '.join(known)}")
        numbers = [number for number in self.numbers if whole or number.case.where[0] in (tables or ())]
        drawings = [d for d in self.drawings if whole or any(_names(name, d) for name in figures or ())]
        return numbers, drawings


def points_of(numbers: Sequence[Printed], drawings: Sequence[Drawing]) -> list[Point]:
    """The runs that numbers and figures need, each once: small ones first, the first sample of everything before the second."""
    cases = [number.case for number in numbers if number.measure] + [case for d in drawings for case in d.cases]
    values = {repr(sorted(one.items())): one for case in cases if case.options for one in case.values()}
    points = {point.digest: point for point in map(Point.of, values.values())}
    return sorted(points.values(), key=lambda point: (point.grains, point.values["seed"]))


def papers() -> list[str]:
    """Names of the papers."""
    return sorted(path.name.removesuffix(".toml") for path in _folder().iterdir() if path.name.endswith(".toml"))


def load_paper(name: str) -> dict[str, Any]:
    """What papers/NAME.toml declares.  Raises InputError for an unknown name."""
    if name not in papers():
        raise unknown_name(name, papers(), "paper")
    return tomllib.loads((_folder() / f"{name}.toml").read_text(encoding="utf-8"))


def read_paper(name: str, *, quick: bool = False, samples: int | None = None) -> Paper:
    """The paper ``name``; ``quick``: fewer and smaller samples; ``samples``: so many of each kind instead of the paper's."""
    data = load_paper(name)
    small = data["quick"] if quick else None
    numbers: list[Printed] = []
    cases: dict[tuple[str, str, str], Case] = {}
    titles: dict[str, str] = {}
    blocks: dict[str, Table] = {}
    for own in data["block"]:
        block = {**blocks.get(own.get("like", ""), {}), **own}
        blocks.setdefault(block["table"], block)
        for r, row in enumerate(block["row"]):
            for c, column in enumerate(block["column"]):
                case = _case(block, row, column, small, samples)
                cases.setdefault(case.where, case)
                titles[" ".join(case.where)] = block["title"]
                numbers += [printed for number in block.get("number", []) for printed in _printed(number, case, r, c)]
    drawings = [
        Drawing(
            one["number"], one["plot"], tuple(cases[tuple(of)] for of in one.get("of", [])), one.get("most"),
            one.get("partial", False), one.get("time"), one["shows"],
        )
        for one in data["figure"]
    ]  # fmt: skip
    return Paper(name, data["paper"], data["short"], data["uncertainty"], titles, tuple(numbers), tuple(drawings), quick)


Table = Mapping[str, Any]


def _case(block: Table, row: Table, column: Table, small: Table | None, count: int | None) -> Case:
    options = {**block.get("options", {}), **row.get("options", {}), **column.get("options", {})}
    sizes = [(grains, count or number) for grains, number in row.get("samples", [])]
    if small:
        sizes = [(small["n"], count or small["samples"])] if sizes and row.get("quick", True) else []
        options |= small.get("options", {}) if options else {}
    size = "grains" if options.get("scene") == "heap" else "n"
    first = row.get("first", {}) if column["name"] in row.get("first_in", [column["name"]]) else {}
    return Case((block["table"], row["name"], column["name"]), options, tuple(sizes), first, size, row.get("stage"))


def _printed(number: Mapping[str, Any], case: Case, row: int, column: int) -> Iterator[Printed]:
    """The number of one cell, if anything is printed there."""

    def entry(name: str) -> float | None:
        table = number.get(name)
        found = table[row][column] if isinstance(table, list) else table
        return None if found is None or math.isnan(found) else float(found)

    value, error, low, high = (entry(name) for name in ("value", "error", "low", "high"))
    own: Table = next((cell for cell in number.get("cell", []) if cell["at"] == [row, column]), {})
    reason = own.get("reason", number.get("reason", ""))
    if value is not None or low is not None or high is not None:
        measure = number.get("measure")
        yield Printed(
            case, number["name"], measure, value, error, low, high, reason, own.get("misprint", number.get("misprint", ""))
        )


def _folder() -> Any:
    return files("workflow.reproduce") / "tables"


def _integer(number: str) -> str:
    """9 of 9c-P0."""
    return number[: next((k for k, letter in enumerate(number) if not letter.isdigit()), len(number))]


def _names(name: str, drawing: Drawing) -> bool:
    return name in (drawing.number, _integer(drawing.number)) or drawing.number.startswith(f"{name}-")

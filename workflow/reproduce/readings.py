"""Readings of a paper's procedure, told apart by the numbers they give: chi^2 of each against a set of printed cells."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from workflow.data.files import atomic_write
from workflow.data.table import write_csv
from workflow.errors import InputError
from workflow.reproduce.papers import Case, Paper, Printed, load_paper, read_paper
from workflow.reproduce.scoreboard import Row, theirs
from workflow.scene.registry import SCENES


@dataclass(frozen=True)
class Reading:
    """``options`` of the scenes on top of those of the cells; ``scan``: the parameter whose value this reading is one of;
    ``tables``: those whose cells it is tried on, None for all."""

    name: str
    options: Mapping[str, Any]
    scan: str
    meaning: str
    tables: tuple[str, ...] | None

    def of(self, case: Case) -> Case:
        """The case under this reading; parameters that its scene does not have are left out."""
        known = {item.name for item in fields(SCENES[case.options["scene"]])}
        return replace(case, options={**case.options, **{k: v for k, v in self.options.items() if k in known}})


@dataclass(frozen=True)
class Readings:
    """``readings`` of ``paper`` and the ``numbers`` that decide between them, as the paper prints them."""

    paper: Paper
    readings: tuple[Reading, ...]
    numbers: tuple[Printed, ...]

    def of(self, reading: Reading) -> list[Printed]:
        """The deciding numbers with the scenes of a reading."""
        tried = [n for n in self.numbers if reading.tables is None or n.case.where[0] in reading.tables]
        return [replace(number, case=reading.of(number.case)) for number in tried]


@dataclass(frozen=True)
class Line:
    """One number under one reading; ``difference`` in standard errors of both sides."""

    reading: str
    table: str
    row: str
    column: str
    quantity: str
    ours: float | None
    standard_error: float | None
    samples: int
    wanted: int
    at_rest: int
    theirs: str
    difference: float | None
    seeds: str
    digests: str
    values: str


def read_readings(name: str, *, chosen: Sequence[str] | None = None, samples: int | None = None) -> Readings:
    """The readings declared in papers/``name``.toml, all or the ``chosen`` ones; ``samples`` of each kind instead of theirs.

    Raises InputError for a paper without readings and for unknown names.
    """
    data = load_paper(name).get("readings")
    if not data:
        raise InputError(f"{name} declares no readings; papers with readings: gilabert2007, baxter1997")
    paper = read_paper(name)
    declared = [
        Reading(
            one["name"],
            one.get("options", {}),
            one.get("scan", ""),
            one.get("meaning", ""),
            tuple(one["tables"]) if "tables" in one else None,
        )
        for one in data["reading"]
    ]
    names = [one.name for one in declared]
    for unknown in sorted(set(chosen or ()) - set(names)):
        raise InputError(f"--readings {unknown} is not known in {paper.short}; there are: {', '.join(names)}")
    kept = tuple(one for one in declared if chosen is None or one.name in chosen)
    return Readings(paper, kept, tuple(_deciding(paper, data, samples or data["samples"])))


def _deciding(paper: Paper, data: Mapping[str, Any], samples: int) -> Iterator[Printed]:
    """The numbers of the cells of [readings], so many samples of each, without the frames that only figures need."""
    for cell in data["cell"]:
        found = [
            number for number in paper.numbers
            if list(number.case.where) == cell["of"] and number.quantity in cell["quantities"] and not number.misprint
        ]  # fmt: skip
        if len(found) != len(cell["quantities"]):
            raise InputError(
                f"[readings] of {paper.name}: {cell['of']} has not all of {cell['quantities']}, or a suspected misprint"
            )
        for number in found:
            case = number.case
            options = {**case.options, **cell.get("options", {})}
            yield replace(number, case=replace(case, options=options, sizes=((case.sizes[0][0], samples),), first={}))


def lines(reading: Reading, rows: Sequence[Row]) -> list[Line]:
    """What a reading gives, from the judged ``rows`` of its numbers."""
    return [
        Line(reading.name, row.table, row.row, row.column, row.quantity, row.ours, row.standard_error, row.samples,
             row.wanted, row.at_rest, theirs(row), row.difference, row.seeds, row.digests, row.values)
        for row in rows
    ]  # fmt: skip


def chi_squares(found: Sequence[Line]) -> dict[str, dict[str, tuple[float, int]]]:
    """Reading -> table -> (chi^2, how many numbers): the sum of the squared differences of the numbers that are there.

    "all" stands for all tables together.  Two readings can be told apart where their chi^2 over the same numbers differ by
    much more than sqrt(2 x numbers), its standard deviation if a reading is right.
    """
    sums: dict[str, dict[str, tuple[float, int]]] = {}
    for line in found:
        if line.difference is None:
            continue
        of = sums.setdefault(line.reading, {})
        for table in (line.table, "all"):
            value, count = of.get(table, (0.0, 0))
            of[table] = (value + line.difference**2, count + 1)
    return sums


@dataclass(frozen=True)
class Scan:
    """The value of ``parameter`` with the least chi^2, and the interval in which it grows by less than max(1, chi^2/dof).

    ``values`` and ``chi2`` (K,): the readings of the scan.  None where fewer than three values have all their numbers, or
    chi^2 has no minimum between them.
    """

    parameter: str
    values: list[float]
    chi2: list[float]
    numbers: int
    best: float | None
    low: float | None
    high: float | None


def scans(readings: Sequence[Reading], sums: Mapping[str, Mapping[str, tuple[float, int]]]) -> list[Scan]:
    """A scan for each parameter of which readings declare values; a parabola in the logarithm of the value through chi^2."""
    found = []
    for parameter in dict.fromkeys(one.scan for one in readings if one.scan):
        at = {one.options[parameter]: sums[one.name]["all"] for one in readings if one.scan == parameter and one.name in sums}
        most = max((count for _, count in at.values()), default=0)
        whole = sorted((value, chi2) for value, (chi2, count) in at.items() if count == most)
        values, chi2 = [value for value, _ in whole], [value for _, value in whole]
        found.append(Scan(parameter, values, chi2, most, *_least(values, chi2, most)))
    return found


def _least(values: Sequence[float], chi2: Sequence[float], numbers: int) -> tuple[float | None, float | None, float | None]:
    if len(values) < 3:
        return None, None, None
    x = np.log(values)
    nearest = np.argsort(chi2, kind="stable")[:5]  # far from the minimum chi^2 is no parabola
    curvature, slope, offset = np.polyfit(x[nearest], np.asarray(chi2)[nearest], 2)
    middle = -slope / (2.0 * curvature) if curvature > 0.0 else math.inf
    if not x.min() <= middle <= x.max():
        return None, None, None
    least = offset + curvature * middle**2 + slope * middle
    wide = math.sqrt(max(1.0, least / max(numbers - 1, 1)) / curvature)
    return tuple(math.exp(middle + shift) for shift in (0.0, -wide, wide))  # type: ignore[return-value]


def write_readings(folder: Path, of: Readings, found: Sequence[Line], provenance: Mapping[str, Any]) -> None:
    """readings.csv, .json and .md in ``folder``."""
    sums = chi_squares(found)
    fits = scans(of.readings, sums)
    provenance = {**provenance, "seeds and digests": "of every number in readings.csv"}
    write_csv(folder / "readings.csv", found)
    table = {
        "paper": of.paper.title, "readings": [asdict(one) for one in of.readings],
        "chi2": {name: {t: {"chi2": c, "numbers": n} for t, (c, n) in one.items()} for name, one in sums.items()},
        "scans": [asdict(fit) for fit in fits], "numbers": [asdict(line) for line in found], "provenance": dict(provenance),
    }  # fmt: skip
    with atomic_write(folder / "readings.json") as draft:
        draft.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
    with atomic_write(folder / "readings.md") as draft:
        draft.write_text(markdown(of, found, provenance), encoding="utf-8")


HOW = (
    "chi^2 is the sum over numbers of ((ours - theirs)/sqrt(SE^2 + u^2))^2, SE the standard error of our mean, u the printed\n"
    "uncertainty. A right reading gives about as much as there are numbers. These numbers decide between readings and are\n"
    "no test of the one that wins; the rest of the scoreboard is."
)


def markdown(of: Readings, found: Sequence[Line], provenance: Mapping[str, Any]) -> str:
    """The readings for people: chi^2 by table, the scans, then number by number."""
    sums = chi_squares(found)
    tables = [*dict.fromkeys(line.table for line in found), "all"]
    text = [f"# Readings of {of.paper.short}", "", HOW, "", *(f"* {name}: {value}" for name, value in provenance.items()), ""]
    text += [
        "| reading | " + " | ".join(f"table {t}" if t != "all" else t for t in tables) + " |",
        "|---" * (len(tables) + 1) + "|",
    ]
    for reading in of.readings:
        cells = [_sum(sums.get(reading.name, {}).get(table)) for table in tables]
        text.append(f"| {reading.name} | " + " | ".join(cells) + " |")
    text += ["", *(f"* {one.name}: {one.meaning}" for one in of.readings if one.meaning)]
    for fit in scans(of.readings, sums):
        known = "no minimum inside the scan" if fit.best is None else f"{fit.best:.3g} ({fit.low:.3g} to {fit.high:.3g})"
        text += [
            "",
            f"Scan of `{fit.parameter}` over {', '.join(f'{v:g}' for v in fit.values)} ({fit.numbers} numbers): {known}.",
        ]
    cases = dict.fromkeys((line.table, line.row, line.column, line.quantity, line.theirs) for line in found)
    names = [one.name for one in of.readings if one.name in {line.reading for line in found}]
    at = {(line.reading, line.table, line.row, line.column, line.quantity): line for line in found}
    text += ["", "| number | theirs | " + " | ".join(names) + " |", "|---" * (len(names) + 2) + "|"]
    for table, row, column, quantity, printed in cases:
        cells = [_cell(at.get((name, table, row, column, quantity))) for name in names]
        text.append(f"| {table} {row} {column} {quantity} | {printed} | ".replace("  ", " ") + " | ".join(cells) + " |")
    return "\n".join(text) + "\n"


def _sum(of: tuple[float, int] | None) -> str:
    return "" if of is None else f"{of[0]:.1f} ({of[1]})"


def _cell(line: Line | None) -> str:
    if line is None or line.ours is None:
        return ""
    error = "" if line.standard_error is None else f" ± {line.standard_error:.1g}"
    rest = f", {line.samples - line.at_rest} not at rest" if line.at_rest < line.samples else ""
    return f"{line.ours:.4g}{error} ({line.samples}{rest})"

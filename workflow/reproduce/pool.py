"""Numbers and figures of scoreboards made elsewhere, beside those of the runs that are here.

A sample is known by its digest, so one that is in several places counts once.  What a fit to all samples together gives
cannot be pooled sample by sample: of such a number the line that rests on the most samples stands.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from workflow.campaign.measured import TOGETHER, jackknife, of_samples
from workflow.data.files import atomic_write
from workflow.errors import InputError
from workflow.reproduce.papers import Printed
from workflow.reproduce.scoreboard import NO_SAMPLE, Ours, Row

POOLED = "pooled with"


@dataclass(frozen=True)
class Earlier:
    """A scoreboard.json: its ``lines`` by place and quantity, ``figures`` by number, ``provenance``."""

    path: Path
    lines: Mapping[tuple[str, ...], Row]
    figures: Mapping[str, Path]
    provenance: Mapping[str, str]


def read_earlier(path: Path) -> Earlier:
    """Read a scoreboard.json.  Raises InputError if it is none."""
    try:
        table = json.loads(path.read_text(encoding="utf-8"))
        lines = [_line(one) for one in table["numbers"]]
        figures = {str(one["number"]): path.parent / one["file"] for one in table["figures"] if one["file"]}
        provenance = {str(name): str(value) for name, value in table["provenance"].items()}
    except OSError as fault:
        raise InputError(
            f"--pool {path} cannot be read ({fault.strerror}); give a scoreboard.json of 'wf reproduce'"
        ) from fault
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as fault:
        raise InputError(f"--pool {path} is no scoreboard.json ({fault}); give one that 'wf reproduce' wrote") from fault
    return Earlier(path, {_place(line): line for line in lines}, figures, provenance)


def _line(entry: Mapping[str, Any]) -> Row:
    """A line as it was written; one of version 0.2.0 or before has no values of single samples."""
    line = Row(**{"pooled": 0, "values": "", **entry})
    if line.samples == 1 and not line.values and line.measure.split(".")[0] not in TOGETHER:
        line = replace(line, values=repr(line.ours))
    digests, values = line.digests.split(), [float(value) for value in line.values.split()]
    if not len(digests) == len(line.seeds.split()) == line.samples or len(values) not in (0, line.samples):
        raise ValueError(f"the samples of '{line.quantity}' in table {line.table} are not {line.samples}")
    return line


def _place(line: Row) -> tuple[str, ...]:
    return line.table, line.row, line.column, line.quantity, line.measure


def pool(ours: Ours, number: Printed, wanted: Mapping[str, int], earlier: Sequence[Earlier]) -> Ours:
    """Ours with the samples of earlier scoreboards on top, of those ``wanted``: their digests, with seeds, in their order."""
    for scoreboard in earlier:
        line = scoreboard.lines.get((*number.case.where, number.quantity, number.measure or ""))
        if line is None or not set(line.digests.split()) <= wanted.keys():
            continue
        if line.ours is None:  # its samples may be there and not give the number
            ours = replace(ours, trouble=line.reason) if ours.trouble == NO_SAMPLE and line.wanted == ours.wanted else ours
            continue
        own, theirs = _single(ours.digests, ours.values), _single(line.digests, line.values)
        missing = theirs.keys() - own.keys()
        # which of its samples are at rest a line does not say, unless all are
        if missing and line.at_rest == line.samples and len(own) == ours.samples:
            each = {name: value for name in wanted if (value := own.get(name, theirs.get(name))) is not None}
            ours = _joined(ours, each, wanted, len(missing))
        elif line.samples > ours.samples:
            ours = Ours(
                line.ours, line.standard_error, line.samples, ours.wanted, line.at_rest, line.seeds, line.digests, line.values,
                line.samples,
            )  # fmt: skip
    return ours


def _single(digests: str, values: str) -> dict[str, float]:
    """The values of single samples by digest, none if they are not known."""
    return dict(zip(digests.split(), map(float, values.split()), strict=True)) if values else {}


def _joined(ours: Ours, each: Mapping[str, float], wanted: Mapping[str, int], more: int) -> Ours:
    """Mean and standard error of single samples, ``more`` of them from elsewhere."""
    samples = [{"value": value} for value in each.values()]
    return Ours(
        of_samples("value", samples, None), jackknife("value", samples, None), len(each), ours.wanted, ours.at_rest + more,
        " ".join(str(wanted[name]) for name in each), " ".join(each), " ".join(repr(value) for value in each.values()),
        ours.pooled + more,
    )  # fmt: skip


def take_figure(number: str, earlier: Sequence[Earlier], folder: Path) -> str:
    """Copy the figure of that number from the first earlier scoreboard that has it; its file in ``folder``, or nothing."""
    for scoreboard in earlier:
        found = scoreboard.figures.get(number)
        if found is None or not found.is_file():
            continue
        target = folder / "figures" / found.name
        if not (target.exists() and target.samefile(found)):
            target.parent.mkdir(parents=True, exist_ok=True)
            with atomic_write(target) as draft:
                shutil.copyfile(found, draft)
        return f"figures/{found.name}"
    return ""


def origin(earlier: Sequence[Earlier], rows: Sequence[Row], figures: Sequence[str]) -> dict[str, str]:
    """What of a scoreboard comes from elsewhere, and how that was made: lines for its provenance."""
    lines = sum(row.pooled > 0 for row in rows)
    drawn = f" and figures {', '.join(figures)}" if figures else ""
    found = {POOLED: f"the scoreboards named below; samples of theirs are in {lines} of the numbers{drawn}"} if earlier else {}
    made: list[dict[str, str]] = []
    for scoreboard in earlier:
        sources: dict[str, dict[str, str]] = {"": {"file": str(scoreboard.path)}}  # "": itself; others it was pooled with
        for name, value in scoreboard.provenance.items():
            source, _, what = name.rpartition(": ")
            if name != POOLED:
                sources.setdefault(source, {})[what] = value
        made.extend(entries for entries in sources.values() if entries not in made)
    for number, entries in enumerate(made, start=1):
        found |= {f"scoreboard {number}: {what}": value for what, value in entries.items()}
    return found

"""From the finished runs of a paper's study to its scoreboard."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import workflow
from workflow.campaign.measured import Measures, found_at, group_of, jackknife, measured, of_samples, settings_at
from workflow.campaign.study import DONE, Point, Study, same_deck
from workflow.errors import WorkflowError
from workflow.measures.registry import Settings
from workflow.reproduce.papers import Case, Printed
from workflow.reproduce.pool import Earlier, pool
from workflow.reproduce.scoreboard import NO_SAMPLE, Ours, Row, judge

KEPT = "measures"  # folder of the study with measures of frames that the runs do not measure themselves


def samples_of(study: Study, case: Case) -> list[Point]:
    """The finished samples of a case, in the order of its seeds."""
    points = (_point(json.dumps(values)) for values in case.values()) if case.options else ()
    return [point for point in points if study.standing(point).status == DONE]


@cache
def _point(values: str) -> Point:
    """Of many numbers the same samples are asked for."""
    return Point.of(json.loads(values))


def rows(study: Study, numbers: Sequence[Printed], earlier: Sequence[Earlier], say: Callable[[str], None]) -> list[Row]:
    """A line for every number: measured where samples are finished, with those of earlier scoreboards."""
    found = []
    for k, number in enumerate(numbers):
        say(f"measuring {k + 1} of {len(numbers)}")
        wanted = _wanted(number.case) if earlier else {}
        found.append(judge(number, pool(ours(study, number), number, wanted, earlier)))
    return found


def _wanted(case: Case) -> dict[str, int]:
    """Names and seeds of the samples of a case."""
    return {_point(json.dumps(values)).name: values["seed"] for values in case.values()} if case.options else {}


def ours(study: Study, number: Printed) -> Ours:
    """What the finished samples give for a number."""
    wanted = sum(count for _, count in number.case.sizes) if number.measure else 0
    if number.measure is None or not number.case.options:
        return Ours(wanted=wanted)
    if not wanted:
        return Ours(trouble="left out of the quick version")
    points = samples_of(study, number.case)
    if not points:
        return Ours(wanted=wanted, trouble=NO_SAMPLE)
    try:
        samples, settings = _measures(study, points, number)
        value = of_samples(number.measure, samples, settings)
        error = jackknife(number.measure, samples, settings)
    except WorkflowError as fault:
        return Ours(wanted=wanted, trouble=str(fault))
    if value is None:
        return Ours(wanted=wanted, trouble="the samples do not give it")
    if error is None:  # one sample of a fit has the error of the fit
        path, _, name = number.measure.rpartition(".")
        error = of_samples(f"{path}.errors.{name}", samples, settings) if path.endswith(".fit") else None
    rest = sum(bool(measured(study.directory(p), None, None, study.folder / KEPT)["equilibrated"]) for p in points)
    each = [found_at(sample, number.measure) for sample in samples]  # a fit is had from all of them together
    known = [repr(value) for value in each if value is not None]
    return Ours(
        value, error, len(points), wanted, rest, " ".join(str(point.values["seed"]) for point in points),
        " ".join(point.name for point in points), " ".join(known) if len(known) == len(points) else "",
    )  # fmt: skip


def _measures(study: Study, points: Sequence[Point], number: Printed) -> tuple[list[Measures], Settings | None]:
    assert number.measure is not None
    stage, group = number.case.stage, group_of(number.measure)
    samples: list[Measures] = [measured(study.directory(point), stage, group, study.folder / KEPT) for point in points]
    return samples, settings_at(study.directory(points[0]), stage)


def this_version() -> str:
    """The version of this package, with the commit if it runs from a checkout."""
    root = Path(workflow.__file__).parents[1]
    words = ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=12"]
    if not ((root / ".git").exists() and shutil.which("git")):
        return f"workflow {workflow.__version__}"
    commit = subprocess.run(words, capture_output=True, text=True, check=False).stdout.strip()
    return f"workflow {workflow.__version__}, commit {commit or 'unknown'}"


def provenance(study: Study, command: str) -> dict[str, Any]:
    """Where the numbers come from: command, versions, and of the runs how many, when, at what cost."""
    points = [point for point in study.points if study.standing(point).status == DONE]
    done = [study.directory(point).state for point in points]
    older = sum(not same_deck(point, state) for point, state in zip(points, done, strict=True))
    names = ("workflow", "lammps", "platform")
    versions = {name: sorted({str(state["versions"].get(name)) for state in done}) for name in names}
    dates = sorted({str(state.get("finished", ""))[:10] for state in done})
    hours = sum(float(state.get("seconds") or 0.0) for state in done) / 3600.0
    lines = {
        "command": command,
        "measured with": this_version(),
        "runs": f"{len(done)} of {len(study.points)} finished, {hours:.2f} core hours"
        + (f", {' to '.join(dict.fromkeys((dates[0], dates[-1])))}" if done else "")
        + (f"; the deck of {older} of them was made of the same scene by another version" if older else ""),
        "made with": ", ".join(f"{name} {' and '.join(found)}" for name, found in versions.items() if found),
        "seeds and digests": "of every number in scoreboard.csv",
    }  # fmt: skip
    return {name: line for name, line in lines.items() if line}

"""Reproducibility of a finished run: do it again, or its last part, and compare what came out byte for byte."""

from __future__ import annotations

import math
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import zip_longest
from pathlib import Path
from typing import TextIO

import numpy as np

from workflow.archive.dumps import read_blocks
from workflow.data.files import open_plain
from workflow.deck.template import DATA, DECK
from workflow.errors import ArchiveError, InputError
from workflow.pipeline.run import run
from workflow.runs.directory import FINISHED, INTERRUPTED, PREPARED, SCENE, RunDirectory
from workflow.runs.identity import check_inputs
from workflow.runs.installation import versions
from workflow.runs.outputs import DUMPS
from workflow.runs.resume_point import start_of
from workflow.scene.base import Scene

RESULTS = {"series.txt": None, **DUMPS}
# Where bits may differ (ranks, versions, machine), rounding grows exponentially while grains collide: two such runs are two
# samples.  Bounds for 1400 grains, four times the scatter between samples of G07 table V and of validation/; they grow
# as 1/sqrt(N).
BOUNDS = {"solid_fraction": 0.032, "coordination": 0.12}
TOGETHER = 1e-6  # relative difference up to which two series count as the same run


@dataclass(frozen=True)
class Difference:
    """Where two runs first differ: file, stage, step, quantity, and its value then and now."""

    file: str
    stage: str
    step: int
    quantity: str
    before: float | None
    now: float | None


@dataclass(frozen=True)
class Verdict:
    """``reproduced``: ``same_bits``, or within BOUNDS where bits may differ (``expected`` says why they may).

    ``first``: the first difference.  ``agree_until``: time up to which the series agree to TOGETHER [T0].  ``changes``:
    largest difference of each bounded quantity at the ends of stages.
    """

    reproduced: bool
    same_bits: bool
    part: str
    expected: str | None
    first: Difference | None
    agree_until: float | None
    changes: dict[str, float]

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        return asdict(self)


def verify(
    directory: RunDirectory, *, last: bool = False, ranks: int | None = None, any_deck: bool = False, out: TextIO | None = None
) -> Verdict:
    """Repeat a finished run, or with ``last`` what followed its last checkpoint, in a temporary directory and compare.

    Raises InputError if the run is not finished, it is not what its record says (``any_deck`` accepts that), or ``last`` finds
    no checkpoint; KeyboardInterrupt if it was interrupted, for then nothing is known.
    """
    state = directory.state
    if state["status"] != FINISHED:
        raise InputError(f"the run in '{directory.path}' is {state['status']}, not finished; 'wf resume' it first")
    check_inputs(directory, executed=True, any_deck=any_deck)
    with tempfile.TemporaryDirectory(prefix="wf-verify-") as place:
        again = RunDirectory(Path(place))
        start = _prepare(directory, again, last)
        ranks = ranks or state.get("ranks", 1)
        if run(again, ranks=ranks, resume=last, any_deck=True, out=out) != FINISHED:
            raise KeyboardInterrupt
        return _compare(directory, again, start, _excuse(state, ranks, directory.scene, last))


def _prepare(directory: RunDirectory, again: RunDirectory, last: bool) -> int:
    """Copy what the run starts from; the step it starts at."""
    names = [DECK, DATA, *directory.scene.files(), SCENE, "run.json"]
    start = 0
    if last:
        checkpoint = start_of(directory.path).checkpoint
        if checkpoint is None:
            raise InputError(f"'{directory.path}' has no whole checkpoint to start from; verify without --last")
        start = checkpoint.step
        stages = [path.name for path in directory.path.glob("stage.*.in")]
        own = [checkpoint.path.name, checkpoint.path.name + ".json", *stages, "account.in", "log.lammps"]
        names += [name for name in (*own, *RESULTS) if (directory / name).is_file()]
    for name in names:
        with open_plain(directory / name) as old, open(again / name, "xb") as new:
            shutil.copyfileobj(old, new)
    again.record(status=INTERRUPTED if last else PREPARED)
    return start


def _excuse(state: dict, ranks: int, scene: Scene, last: bool) -> str | None:
    """Why bits may differ, None if they may not."""
    before, now = state["versions"], versions()
    reasons = [
        f"{name} {before[name]} then, {now[name]} now"
        for name in ("lammps", "platform", "libc", "processor")
        if name in before and before[name] != now[name]
    ]
    if ranks != state.get("ranks", 1):
        reasons.append(f"{state.get('ranks', 1)} ranks then, {ranks} now")
    if not scene.resumes_exactly and (last or state.get("starts", 1) > 1):
        reasons.append("LAMMPS's own restarts of this law and barostat are exact but for rounding")
    if state.get("earlier_ranks"):
        reasons.append(f"on {', '.join(map(str, state['earlier_ranks']))} ranks in earlier parts")
    return "; ".join(reasons) or None


def _compare(one: RunDirectory, two: RunDirectory, start: int, excuse: str | None) -> Verdict:
    scene = one.scene
    present = [name for name in RESULTS if (one / name).is_file()]
    differences = (difference for name in present for difference in _differences(one, two, name, scene))
    first = min(differences, key=lambda d: d.step, default=None)
    changes = _changes(one, two)
    close = all(change <= BOUNDS[name] * math.sqrt(1400.0 / scene.size) for name, change in changes.items())
    return Verdict(
        reproduced=first is None or (excuse is not None and close and bool(changes)),
        same_bits=first is None,
        part=f"from step {start} on" if start else "the whole run",
        expected=excuse,
        first=first,
        agree_until=_agree_until(one, two),
        changes=changes,
    )


def _differences(one: RunDirectory, two: RunDirectory, name: str, scene: Scene) -> Iterator[Difference]:
    """The first difference of a file, if any: nothing is read as numbers while the bytes agree."""
    if (one / name).read_bytes() == (two / name).read_bytes():
        return
    kind = RESULTS[name]
    rows = zip_longest(*(_rows(directory / name, kind) for directory in (one, two)))
    for before, now in rows:
        if before is None or now is None:
            step, columns, _ = before or now
            yield Difference(name, _stage(one, two, step, scene), step, "a row that is there only once", None, None)
            return
        step, columns, old = before
        new = now[2]
        if now[0] != step or old.shape != new.shape:
            yield Difference(name, _stage(one, two, step, scene), step, "number of rows", float(len(old)), float(len(new)))
            return
        unlike = np.argwhere((old != new) & ~(np.isnan(old) & np.isnan(new)))
        if len(unlike):
            row, column = unlike[0]
            values = float(old[row, column]), float(new[row, column])
            yield Difference(name, _stage(one, two, step, scene), step, columns[column], *values)
            return
    yield Difference(name, "?", 0, "text, though not a number", None, None)


def _rows(path: Path, kind: str | None) -> Iterator[tuple[int, tuple[str, ...], np.ndarray]]:
    """Step, column names and table of each row of a series, or of each frame of a dump."""
    if kind:
        for block in read_blocks(path, kind):
            yield block.step, block.columns, block.table
        return
    lines = [line.split() for line in path.read_text(encoding="ascii", errors="replace").splitlines()]
    columns = tuple(lines[0][1:]) if lines else ()
    for number, words in enumerate(lines[1:], 2):
        if words[:1] == ["#"]:
            continue
        try:
            values = np.array([words], dtype=float)
            step = int(values[0, 0])
        except (ValueError, IndexError, OverflowError):
            raise ArchiveError(f"{path}, line {number}: expected numbers that begin with a step; the run was changed since, "
                               "and cannot be compared") from None  # fmt: skip
        yield step, columns, values


def _stage(one: RunDirectory, two: RunDirectory, step: int, scene: Scene) -> str:
    """Name of the stage in which ``step`` lies."""
    for series in (one.series(), two.series()):
        if series and series["step"][-1] >= step:
            return scene.stages[int(series["stage"][np.searchsorted(series["step"], step)])]
    return list(scene.stages.values())[-1]


def _agree_until(one: RunDirectory, two: RunDirectory) -> float | None:
    """Time up to which solid fraction, coordination and kinetic energy agree to TOGETHER."""
    before, now = one.series(), two.series()
    if not before or not now:
        return None
    rows = min(len(before["step"]), len(now["step"]))
    names = [name for name in ("time", "solid_fraction", "coordination", "kinetic") if name in before]
    same = np.all([np.isclose(before[n][:rows], now[n][:rows], rtol=TOGETHER, atol=0.0) for n in names], axis=0)
    count = rows if same.all() else int(np.argmin(same))
    return float(before["time"][count - 1]) if count else 0.0


def _changes(one: RunDirectory, two: RunDirectory) -> dict[str, float]:
    """Largest change of each bounded quantity over the ends of the stages; empty if the stages differ."""
    ends = []
    for directory in (one, two):
        series = directory.series()
        if not series:
            return {}
        last = {int(stage): row for row, stage in enumerate(series["stage"])}
        ends.append(
            {stage: {name: float(series[name][row]) for name in BOUNDS if name in series} for stage, row in last.items()}
        )
    if set(ends[0]) != set(ends[1]):
        return {}
    bounded = next(iter(ends[0].values()))
    return {name: max(abs(ends[0][stage][name] - ends[1][stage][name]) for stage in ends[0]) for name in bounded}


def summary(verdict: Verdict) -> str:
    """The verdict for people."""
    first = verdict.first
    if first is None:
        return f"reproduced: {verdict.part}, every byte of what it wrote"
    values = "" if first.before is None else f": {first.before!r} then, {first.now!r} now"
    lines = [
        f"{'reproduced within bounds' if verdict.reproduced else 'NOT reproduced'}: {verdict.part}",
        f"first difference: stage {first.stage}, step {first.step}, {first.quantity} ({first.file}){values}",
    ]
    if verdict.expected:
        lines.append(f"bits may differ: {verdict.expected}")
        lines.append(f"the series agree to {TOGETHER:g} until t = {verdict.agree_until:.4g} T0; changes at the ends of stages:")
        lines += [f"  {name} {change:.2g} (bound {BOUNDS[name]:g} x sqrt(1400/N))" for name, change in verdict.changes.items()]
    return "\n".join(lines)

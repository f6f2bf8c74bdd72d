"""Scenes of many grains: time, memory and bytes of every stage, each measured in a process of its own; and from these numbers
what a larger scene on a cluster would need."""

from __future__ import annotations

import json
import math
import os
import re
import resource
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import util
from pathlib import Path
from typing import Any, TextIO

from workflow.archive.export import FORMATS
from workflow.archive.read import Archive
from workflow.data.build import repeat
from workflow.data.progress import Meter
from workflow.deck.template import DATA, DECK, data_parts
from workflow.errors import EngineError, WorkflowError
from workflow.measures.registry import measure_groups
from workflow.pipeline.collect import measures_of, settings_of, write
from workflow.runs.directory import ARCHIVE, RunDirectory
from workflow.runs.installation import python_child
from workflow.runs.launch import run_deck, run_program
from workflow.scene.method1 import Method1
from workflow.verification.bench_states import of_frame

STATES = ("gas", "dense")
SEED = 1
SMALL = 1400  # grains of the packing that the dense state repeats
GB = 1e9
WIRE = 8 * (5 + 4)  # bytes per ghost and step: position, velocity, spin to the ghost; force, moment, tangential part back
DATA_FILE, START, LOOP, SAVE = "deck and data file", "engine: start, two frames", "engine: time loop", "engine: one checkpoint"
ARCHIVED = "archive of two frames"
BEGAN = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # bytes of this process once all is imported


@dataclass(frozen=True)
class Stage:
    """One stage of one scene.

    ``seconds`` on the clock and ``processor_seconds`` of all processes; ``peak_GB``: largest resident size of a process,
    of ranks the largest; ``bytes_per_grain``: the same per grain, without what the process occupies before it has grains;
    ``ns_per_grain_step`` of the time loop without output; ``MB`` written; ``ghosts`` per rank; None where a stage has no such
    number.
    """

    state: str
    n: int
    stage: str
    ranks: int
    seconds: float
    processor_seconds: float
    peak_GB: float
    bytes_per_grain: float
    ns_per_grain_step: float | None = None
    MB: float | None = None
    ghosts: float | None = None


# ---- what a process of its own measures: functions of a folder that give the numbers of one or more stages ----------------


@contextmanager
def measured(
    rows: list[dict[str, Any]],
    stage: str,
    n: int,
    *,
    ranks: int = 1,
    who: int = resource.RUSAGE_SELF,
    base: float | None = None,
) -> Iterator[dict[str, Any]]:
    """Append a row for what is done inside; further numbers can be put into it.

    ``who``: this process or its children; ``base``: what they occupy without grains [bytes], by default what this process
    occupied when it began.
    """
    row: dict[str, Any] = {"n": n, "stage": stage, "ranks": ranks}
    clock, spent = time.perf_counter(), _spent()
    yield row
    peak = 1024 * resource.getrusage(who).ru_maxrss
    more = (peak - (BEGAN if base is None else base)) * ranks / n
    row |= {"seconds": time.perf_counter() - clock, "processor_seconds": _spent() - spent, "peak_GB": peak / GB}
    rows.append({"bytes_per_grain": more} | row)


def _spent() -> float:
    """Processor seconds of this process and of its children that ended."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def prepare_gas(folder: Path, n: int, steps: int) -> list[dict[str, Any]]:
    """Place the gas; write the run directory."""
    rows: list[dict[str, Any]] = []
    scene = _scene(n, steps)
    with measured(rows, "placement", n):
        discs = scene.discs()
    with measured(rows, DATA_FILE, n) as row:
        RunDirectory.create(folder, scene)
        row["MB"] = _size(folder / DATA)
    del discs
    return rows


def prepare_dense(folder: Path, n: int, steps: int) -> list[dict[str, Any]]:
    """Repeat a small packing of the same scene to about ``n`` grains; write the run directory."""
    rows: list[dict[str, Any]] = []
    times = max(1, round(math.sqrt(n / SMALL)))
    n = SMALL * times * times
    small = folder.with_name("small")
    if not (small / ARCHIVE).is_file():
        from workflow.pipeline.run import run

        with open(os.devnull, "w") as silent:
            run(RunDirectory.create(small, Method1(n=SMALL, seed=SEED)), out=silent)
    with measured(rows, "repetition", n), Archive(small / ARCHIVE) as archive:
        discs = of_frame(repeat(archive.frame(-1), (times, times)))
    with measured(rows, DATA_FILE, n) as row:
        directory = RunDirectory.create(folder, _scene(SMALL, steps))
        directory.write_text(DATA, data_parts(discs))
        row["MB"] = _size(folder / DATA)
    return rows


def _scene(n: int, steps: int) -> Method1:
    """Method 1 with cohesion for so many steps, one checkpoint on the way, without the stage that settles."""
    step = Method1(n=n, seed=SEED).step_choice.step
    duration = steps * step
    return Method1(
        n=n, seed=SEED, dashpots=0.0, max_time=duration, checkpoint_interval=0.6 * duration, series_interval=0.2 * duration
    )


def run_ranks(folder: Path, n: int, ranks: int) -> list[dict[str, Any]]:
    """Run the deck of ``folder`` on so many ranks."""
    rows: list[dict[str, Any]] = []
    for name in ("grains.dump", "contacts.dump", "series.txt"):
        (folder / name).unlink(missing_ok=True)
    (folder / "nothing.in").write_text("log log.lammps\n", encoding="ascii")
    run_deck(folder, "nothing.in", ranks=ranks).output()
    who, empty = resource.RUSAGE_CHILDREN, 1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    with measured(rows, "engine", n, ranks=ranks, who=who, base=empty) as row:
        log = run_deck(folder, DECK, ranks=ranks).output()
        row["MB"] = sum(_size(folder / name) for name in ("grains.dump", "contacts.dump"))
    last = log[log.rindex("Loop time of") :]
    loop, steps = float(last.split()[3]), int(last.split()[8])
    output = re.search(r"^Output +\|[^|]*\|\s*(\S+)", last, re.MULTILINE)
    ghosts = re.search(r"^Nghost: +(\S+)", last, re.MULTILINE)
    used = re.search(r"^([\d.]+)% CPU use", last, re.MULTILINE)
    written, share = float(output[1]) if output else 0.0, float(used[1]) / 100.0 if used else 1.0
    common = {name: rows[0][name] for name in ("n", "ranks", "peak_GB", "bytes_per_grain")}
    return [
        {**rows[0], "stage": START, "seconds": rows[0]["seconds"] - loop,
         "processor_seconds": rows[0]["processor_seconds"] - loop * share * ranks},
        {**common, "stage": LOOP, "seconds": loop - written,
         "processor_seconds": (loop - written) * share * ranks,
         "ns_per_grain_step": (loop - written) / steps / n * 1e9, "ghosts": float(ghosts[1]) if ghosts else None},
        {**common, "stage": SAVE, "seconds": written, "processor_seconds": written * share * ranks,
         "MB": _size(folder / "checkpoint.1.a")},
    ]  # fmt: skip


def archive_and_measure(folder: Path, n: int) -> list[dict[str, Any]]:
    """The archive of the run, one frame of it, its measures."""
    rows: list[dict[str, Any]] = []
    directory = RunDirectory.open(folder)
    with measured(rows, ARCHIVED, n) as row:
        write(directory)
        row["MB"] = _size(folder / ARCHIVE)
    return rows


def read(folder: Path, n: int) -> list[dict[str, Any]]:
    """A frame of the archive."""
    rows: list[dict[str, Any]] = []
    with measured(rows, "read a frame", n), Archive(folder / ARCHIVE) as archive:
        archive.frame(-1)
    return rows


def measure(folder: Path, n: int) -> list[dict[str, Any]]:
    """wf measure."""
    rows: list[dict[str, Any]] = []
    with measured(rows, "wf measure", n):
        measures_of(RunDirectory.open(folder))
    return rows


def group(folder: Path, n: int, name: str) -> list[dict[str, Any]]:
    """One group of measures on a frame that is there."""
    rows: list[dict[str, Any]] = []
    scene = RunDirectory.open(folder).scene
    law = scene.law_of(scene.stages[1])
    assert law is not None
    with Archive(folder / ARCHIVE) as archive:
        frame = archive.frame(-1)
    with measured(rows, f"wf measure --only {name}", n):
        found = measure_groups(frame, settings_of(scene, law), [name])[name]
    if "error" in found:
        raise WorkflowError(f"group {name}: {found['error']}")
    return rows


def export(folder: Path, n: int, name: str) -> list[dict[str, Any]]:
    """One frame in one format."""
    rows: list[dict[str, Any]] = []
    place = folder / "export"
    place.mkdir(exist_ok=True)
    with Archive(folder / ARCHIVE) as archive:
        frame = archive.frame(-1)
    with measured(rows, f"wf export --to {name}", n) as row:
        FORMATS[name].write([frame], place)
        row["MB"] = sum(map(_size, place.iterdir()))
    shutil.rmtree(place)
    return rows


def _size(path: Path) -> float:
    return path.stat().st_size / 1e6 if path.is_file() else 0.0


PARTS: dict[str, Callable[..., list[dict[str, Any]]]] = {
    "gas": prepare_gas, "dense": prepare_dense, "run": run_ranks, "archive": archive_and_measure, "read": read,
    "measure": measure, "group": group, "export": export,
}  # fmt: skip


# ---- the study ------------------------------------------------------------------------------------------------------------


def scale(counts: Sequence[int], states: Sequence[str], ranks: Sequence[int], steps: int, out: Path,
          words: TextIO = sys.stderr) -> list[Stage]:  # fmt: skip
    """Every state and size through all stages, in folders of ``out`` that are removed afterwards.

    Raises InputError if one of the folders exists, EngineError with the words of a stage that fails.
    """
    meter = Meter(float(sum(counts)) * len(states) * (len(ranks) + 3), words)
    rows: list[Stage] = []
    for state in states:
        for wanted in counts:
            folder = out / f"{state}-{wanted}"
            found = part(state, folder, wanted, steps)
            n = found[0]["n"]
            meter.add(wanted, f"{state}, {n} grains, prepared")
            for count in ranks:
                found += part("run", folder, n, count)
                meter.add(wanted, f"{state}, {n} grains, {count} rank{'s' * (count > 1)}")
            found += [row for name in ("archive", "read", "measure") for row in part(name, folder, n)]
            meter.add(wanted, f"{state}, {n} grains, archived and measured")
            for name in ("density", "holes"):
                found += part("group", folder, n, name)
            for name, form in FORMATS.items():
                if not form.needs or _installed(form.needs):
                    found += part("export", folder, n, name)
            meter.add(wanted, f"{state}, {n} grains, analysed and exported")
            rows += [Stage(state=state, **row) for row in found]
            shutil.rmtree(folder)
    meter.end()
    return rows


def part(name: str, *arguments: Path | int | str) -> list[dict[str, Any]]:
    """One of PARTS in a process of its own."""
    words = json.dumps([name, *(str(word) if isinstance(word, Path) else word for word in arguments)])
    done = run_program([*python_child("workflow.verification.scale"), words])
    if done.status:
        raise EngineError(f"stage {words}: {done.words}")
    return list(json.loads(done.printed.splitlines()[-1]))


def _installed(package: str) -> bool:
    return util.find_spec(package) is not None


@dataclass(frozen=True)
class Estimate:
    """What a scene of ``n`` grains on ``ranks`` ranks would need if every number grew as it should.

    ``memory_GB`` and ``ghosts`` of a rank; ``sent_kB`` by a rank in a step, both ways, if all its ghosts act, and
    ``sent_MB_per_second`` at its pace; ``seconds_per_million_steps`` of the processor alone; ``data_GB``; ``frame_GB`` as
    the engine's text, and ``archive_GB``; ``restart_GB``, ``restart_seconds`` through one rank as measured, and
    ``restart_seconds_parallel`` on a file system of ``bandwidth`` [GB/s]; ``frame_seconds``: at most, through one rank.
    """

    state: str
    n: int
    ranks: int
    bandwidth: float
    grains_per_rank: float
    memory_GB: float
    ghosts: float
    sent_kB: float
    sent_MB_per_second: float
    seconds_per_million_steps: float
    data_GB: float
    frame_GB: float
    archive_GB: float
    restart_GB: float
    restart_seconds: float
    restart_seconds_parallel: float
    frame_seconds: float


def estimate(rows: Sequence[Stage], n: int, ranks: int, bandwidth: float) -> Estimate:
    """From the rows of one state: its largest scene, on its most ranks.

    Memory, files and time grow with the number of grains of a rank; ghosts, measured on one rank whose neighbours are itself,
    with the edge of its square share of the cell.
    """
    largest, most = max(row.n for row in rows), max(row.ranks for row in rows)
    table = {(row.stage, row.ranks): row for row in rows if row.n == largest}
    loop, single, start, save = table[LOOP, most], table[LOOP, 1], table[START, most], table[SAVE, most]
    share, more = n / ranks, n / largest
    # a busy machine lengthens the clock alone; processor time is told in hundredths of a second
    busy = single.processor_seconds / single.seconds if single.processor_seconds > 0.1 else 1.0
    pace = (single.ns_per_grain_step or 0.0) * busy * share * 1e-9  # seconds of a step
    empty = loop.peak_GB - loop.bytes_per_grain * largest / most / GB
    ghosts = (single.ghosts or 0.0) * math.sqrt(share / largest)
    restart = more * (save.MB or 0.0) / 1e3
    return Estimate(
        loop.state, n, ranks, bandwidth, share, empty + loop.bytes_per_grain * share / GB, ghosts, WIRE * ghosts / 1e3,
        WIRE * ghosts / 1e6 / pace, 1e6 * pace, more * (table[DATA_FILE, 1].MB or 0.0) / 1e3, more * (start.MB or 0.0) / 2e3,
        more * (table[ARCHIVED, 1].MB or 0.0) / 2e3, restart, more * save.seconds, restart / bandwidth,
        more * start.seconds / 2.0,
    )  # fmt: skip


if __name__ == "__main__":
    name, place, *others = json.loads(sys.argv[1])
    print(json.dumps(PARTS[name](Path(place), *others)))

"""A study: many scenes, one run directory each, named by the digest of the scene, so that nothing is computed twice.

points.json    the points as data: digest, number of grains, and the values that make the scene
points/NAME/   run directory of the point whose digest begins with NAME; a link where a run made elsewhere was adopted
.claims        one byte per point, locked while a process works on it

Whatever starts `wf resume` in a prepared directory can compute a study; `workflow.campaign.local` does it on this machine.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import platform
import re
import reprlib
import shutil
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from workflow.data.files import alive, atomic_write, open_plain
from workflow.deck.template import DECK, render
from workflow.errors import ArchiveError, InputError
from workflow.runs import directory as rundir
from workflow.runs.directory import RunDirectory, seconds_since
from workflow.runs.installation import versions
from workflow.scene.base import Scene
from workflow.scene.registry import scene_from

WAITING, RUNNING, INTERRUPTED, DONE, FAILED = "waiting", "running", "interrupted", "done", "failed"
STATUSES = (WAITING, RUNNING, INTERRUPTED, DONE, FAILED)
POINTS, CLAIMS = "points.json", ".claims"
OUT_OF_TIME = "not in equilibrium: the time of a stage was over"
NAME = 16  # digits of the digest that name a directory


@dataclass(frozen=True)
class Point:
    """One scene of a study: ``values`` that make it (key scene: its name), its ``digest``, its number of ``grains``."""

    values: Mapping[str, Any]
    digest: str
    grains: int

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Point:
        """The point of a scene's values.  Raises InputError if they make no scene."""
        scene = scene_from(values)
        return cls(dict(values), scene.digest, scene.size)

    @classmethod
    def recorded(cls, entry: Mapping[str, Any]) -> Point:
        """The point of an entry of points.json.  Raises ValueError, KeyError or TypeError if it is none."""
        values, digest, grains = entry["values"], entry["digest"], entry["grains"]
        # the digest names a directory, so it must be one word of digits
        fine = isinstance(values, dict) and isinstance(digest, str) and isinstance(grains, int) and 0 < grains < 10**12
        if not fine or not re.fullmatch("[0-9a-f]{64}", digest) or not isinstance(values.get("scene"), str):
            raise ValueError(f"{reprlib.repr(entry)} is no point")
        return cls(values, digest, grains)

    @property
    def name(self) -> str:
        """Name of its directory."""
        return self.digest[:NAME]

    @property
    def scene(self) -> Scene:
        """The scene itself."""
        return scene_from(self.values)


@dataclass(frozen=True)
class PointStatus:
    """Where a point stands: one of STATUSES, ``reason`` it failed or waits, ``seconds`` it has run on ``ranks`` cores."""

    status: str
    reason: str | None = None
    seconds: float = 0.0
    ranks: int = 1

    @property
    def core_seconds(self) -> float:
        """What it has cost."""
        return self.seconds * self.ranks


class Study:
    """The ``points`` in ``folder``, each once."""

    def __init__(self, folder: Path, points: Iterable[Point]) -> None:
        self.folder = folder
        self.points = list({point.digest: point for point in points}.values())

    @classmethod
    def open(cls, folder: Path) -> Study:
        """The study that points.json of ``folder`` declares.  Raises InputError if it is none, ArchiveError if damaged."""
        try:
            entries = json.loads((folder / POINTS).read_text(encoding="utf-8"))
            return cls(folder, [Point.recorded(one) for one in entries])
        except FileNotFoundError as fault:
            raise InputError(f"'{folder}' is no study (it has no {POINTS}); give the folder that 'wf sweep' wrote") from fault
        except (OSError, ValueError, KeyError, TypeError, RecursionError) as fault:
            raise ArchiveError(f"'{folder / POINTS}' cannot be read ({fault}); declare the study again") from fault

    def save(self) -> None:
        """Write points.json.  Raises InputError if the folder cannot be made."""
        try:
            (self.folder / "points").mkdir(parents=True, exist_ok=True)
        except OSError as fault:
            raise InputError(f"cannot create '{self.folder}': {fault.strerror}; give a writable --out DIR") from fault
        lines = [json.dumps({"digest": p.digest, "grains": p.grains, "values": p.values}) for p in self.points]
        with atomic_write(self.folder / POINTS) as draft:
            draft.write_text("[\n" + ",\n".join(lines) + "\n]\n", encoding="utf-8")

    def directory(self, point: Point) -> RunDirectory:
        """The run directory of a point; it need not exist yet."""
        return RunDirectory(self.folder / "points" / point.name)

    @cached_property
    def varied(self) -> list[str]:
        """Names of the values in which the points differ."""
        names = {name: None for point in self.points for name in point.values}
        return [name for name in names if len({repr(point.values.get(name)) for point in self.points}) > 1]

    def label(self, point: Point) -> str:
        """What distinguishes a point, in words."""
        return " ".join(f"{name}={point.values[name]}" for name in self.varied if name in point.values) or point.name

    def standing(self, point: Point) -> PointStatus:
        """Where a point stands.  Raises nothing: a damaged record is a failure with its reason."""
        return standing_in(f"{self.folder}/points/{point.name}")

    def adopt(self, folders: Sequence[Path], *, any_deck: bool = False) -> tuple[int, int]:
        """Link finished runs of these scenes found in ``folders`` (at any depth up to two); how many, and how many were
        left because their deck is not the one that this version makes of the scene (``any_deck`` takes them too).

        A run is known by the digest in its run.json; points that have a directory of their own keep it.
        """
        wanted = {point.digest: point for point in self.points if self.standing(point).status != DONE}
        count = left = 0
        for path in (path for folder in folders for path in _runs_in(folder)):
            state = _state(path)
            point = wanted.get(str(state.get("digest"))) if state.get("status") == rundir.FINISHED else None
            if point is None or not (path / rundir.ARCHIVE).is_file():
                continue
            if not any_deck and not same_deck(point, state):
                left += 1
                continue
            own = self.directory(point).path
            if own.is_symlink() and not own.exists():
                own.unlink()
            if not own.exists():
                own.symlink_to(path.resolve())
                del wanted[point.digest]
                count += 1
        return count, left

    @contextmanager
    def claims(self) -> Iterator[PointLocks]:
        """What keeps other processes from the points this one works on."""
        with open(self.folder / CLAIMS, "a+b") as file:
            yield PointLocks(file.fileno())

    def prepare(self, point: Point) -> RunDirectory:
        """The directory of a claimed point, made if there is none; what a killed process began is made anew.

        Raises InputError if the scene cannot be set up; the reason is then recorded in the directory.
        """
        directory = self.directory(point)
        if (directory / "run.json").is_file() and (directory / DECK).is_file():
            return directory
        if directory.path.is_symlink():
            directory.path.unlink()
        shutil.rmtree(directory.path, ignore_errors=True)
        try:
            return RunDirectory.create(directory.path, point.scene)
        except InputError as fault:
            directory.path.mkdir(parents=True, exist_ok=True)
            directory.record(status=rundir.FAILED, scene=point.values["scene"], digest=point.digest, versions=versions(),
                             reason=str(fault))  # fmt: skip
            raise


class PointLocks:
    """Locks on single points: byte number `digest` of one file, freed by the system when the process ends."""

    def __init__(self, file: int) -> None:
        self.file = file

    def take(self, point: Point) -> bool:
        """True if no other process works on the point; it is ours until `give` or the end of the process."""
        try:
            fcntl.lockf(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, int(point.digest[:15], 16))
        except OSError:
            return False
        return True

    def give(self, point: Point) -> None:
        """Leave the point to others."""
        fcntl.lockf(self.file, fcntl.LOCK_UN, 1, int(point.digest[:15], 16))


def standing_in(path: str) -> PointStatus:
    """Where the run in ``path`` stands; it need not exist.  Plain strings: of ten thousand paths the objects cost most."""
    try:
        with open_plain(f"{path}/run.json") as file:
            state = json.loads(file.read())
        if wrong := rundir.misfit(state):
            raise ValueError(wrong)
        status, reason, seconds = state["status"], state.get("reason"), float(state.get("seconds") or 0.0)
        ranks = int(state.get("ranks") or 1)
    except (FileNotFoundError, NotADirectoryError):
        return PointStatus(WAITING)
    except (OSError, ValueError, RecursionError) as fault:
        return PointStatus(FAILED, f"'{path}/run.json' cannot be read ({fault}); remove the directory to run it again")
    if status == rundir.RUNNING:
        elsewhere = state.get("host") not in (None, platform.node())
        if elsewhere or alive(state.get("pid")):
            where = f"on {state['host']}" if elsewhere else None
            return PointStatus(RUNNING, where, seconds + seconds_since(state.get("started")), ranks)
        return PointStatus(INTERRUPTED, "it was killed", seconds, ranks)
    if status == rundir.FINISHED and rundir.out_of_time(state):
        reason = OUT_OF_TIME
    known = {rundir.PREPARED: WAITING, rundir.FINISHED: DONE, rundir.INTERRUPTED: INTERRUPTED}
    return PointStatus(known.get(status, FAILED), reason, seconds, ranks)


def same_deck(point: Point, state: Mapping[str, Any]) -> bool:
    """The run of record ``state`` has the deck that this version makes of the scene."""
    return state.get("hashes", {}).get(DECK) == hashlib.sha256(render(point.scene).encode()).hexdigest()


def remaining(points: Sequence[Point], standings: Sequence[PointStatus]) -> float | None:
    """Core seconds that the unfinished points will take, None while no point is done.

    A point costs what the finished points of its scene cost per grain on the mean (all finished ones, if its scene has
    none), less what was spent on it; failed ones are left out.
    """
    spent: dict[str, list[float]] = defaultdict(lambda: [0.0, 0.0])
    for point, now in zip(points, standings, strict=True):
        if now.status == DONE:
            for kind in (str(point.values["scene"]), ""):
                spent[kind][0] += now.core_seconds
                spent[kind][1] += point.grains
    if not spent:
        return None
    rate = {kind: seconds / grains for kind, (seconds, grains) in spent.items()}
    return sum(
        max(rate.get(str(point.values["scene"]), rate[""]) * point.grains - now.core_seconds, 0.0)
        for point, now in zip(points, standings, strict=True)
        if now.status not in (DONE, FAILED)
    )


def _runs_in(folder: Path) -> list[Path]:
    """Run directories in ``folder``: itself, its children, their children."""
    if not folder.is_dir():
        raise InputError(f"'{folder}' is no directory; give a folder of runs to adopt")
    return [path.parent for depth in ("run.json", "*/run.json", "*/*/run.json") for path in sorted(folder.glob(depth))]


def _state(path: Path) -> dict[str, Any]:
    try:
        state = json.loads((path / "run.json").read_bytes())
    except (OSError, ValueError):
        return {}
    return state if isinstance(state, dict) else {}

"""A run directory: everything about one run, in files that say what they are.

scene.toml     the scene that repeats the run             run.json       status, command, versions, hashes, times
deck.in        the deck, runs alone with `lmp -in`        log.lammps     the engine's log
grains.data    initial grains                             series.txt     time series, one row per sample
grains.dump, contacts.dump   frames as the engine wrote   run.h5         the archive: frames, contacts, series
checkpoint.*   what `wf resume` continues from            measures.json  the measures of the last frame
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
import reprlib
import shlex
import shutil
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TextIO

from workflow.data.files import alive, atomic_write, open_plain, read_plain
from workflow.data.series import read_series
from workflow.deck.template import DATA, DECK, data_parts, render
from workflow.errors import ArchiveError, InputError
from workflow.runs.installation import versions
from workflow.runs.lock import is_locked, locked_file
from workflow.scene.base import Scene
from workflow.scene.registry import SCENES, read_toml, scene_from, to_toml

ARCHIVE, TRACKS, SCENE, LOCK = "run.h5", "tracks.dump", "scene.toml", ".lock"
PORTABLE = ("plugin", "job.sh", "README.txt")  # of a directory for a cluster
FINISHED, INTERRUPTED, FAILED, RUNNING, PREPARED = "finished", "interrupted", "failed", "running", "prepared"
# entries of run.json: their types, and whether they must be there
NOTHING = type(None)
ENTRIES: dict[str, tuple[tuple[type, ...], bool]] = {
    "status": ((str,), True), "scene": ((str,), True), "digest": ((str,), True), "versions": ((dict,), True),
    "hashes": ((dict,), False), "command": ((str,), False), "ranks": ((int,), False), "pid": ((int, NOTHING), False),
    "host": ((str,), False),
    "reason": ((str, NOTHING), False), "started": ((str,), False), "finished": ((str,), False),
    "seconds": ((int, float, NOTHING), False), "result": ((dict,), False), "parts": ((dict,), False),
    "accepted": ((list,), False), "starts": ((int,), False), "earlier_ranks": ((list,), False),
    "extension": ((dict, NOTHING), False),
}  # fmt: skip


class Series(dict[str, Any]):
    """A time series, name -> (rows,); ArchiveError for a column that the deck should have written."""

    def __missing__(self, name: str) -> Any:
        raise ArchiveError(f"series.txt has no column '{name}'; the file is damaged, or of another deck: run again")


@dataclass(frozen=True)
class RunDirectory:
    """Paths and records of the run in ``path``."""

    path: Path

    def __truediv__(self, name: str) -> Path:
        return self.path / name

    @classmethod
    def open(cls, path: Path) -> RunDirectory:
        """An existing run directory; InputError if ``path`` is none."""
        if not (path / "run.json").is_file():
            if path.is_dir():
                what = "is no run directory (it has no run.json)"
            else:
                what = "is a file" if path.is_file() else "does not exist"
            raise InputError(f"'{path}' {what}; give the directory that 'wf run' or 'wf deck' wrote")
        return cls(path)

    @classmethod
    def create(
        cls, path: Path, scene: Scene, also: Callable[[RunDirectory], None] | None = None, *, ranks: int = 1
    ) -> RunDirectory:
        """A new run directory with deck, data and provenance, and what ``also`` adds; nothing is left if that fails.

        ``ranks``: on how many MPI ranks it is to run, also where it is first continued.

        It is made under its lock, run.json last: of two processes one makes it, and what a killed one left without run.json
        is made anew.
        """
        run, existed = cls(path), path.exists()
        run._require_free(scene)
        deck, discs = render(scene), scene.discs()
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as fault:
            raise InputError(f"cannot create '{path}': {fault.strerror}; give a writable --out DIR") from fault
        with run.lock():
            run._require_free(scene)
            try:
                run._clear()
                run._fill(scene, deck, data_parts(discs), also, ranks)
                (run / LOCK).unlink()  # who waits for it finds the directory made
            except BaseException:
                run._clear()
                (run / LOCK).unlink(missing_ok=True)
                if not existed:
                    path.rmdir()
                raise
        return run

    def _fill(
        self, scene: Scene, deck: str, data: Iterable[str], also: Callable[[RunDirectory], None] | None, ranks: int
    ) -> None:
        """Write everything, run.json last."""
        self.write_text(DATA, data)
        self.write_text(DECK, deck)
        for name, text in scene.files().items():
            self.write_text(name, text)
        self.write_text(SCENE, to_toml(scene))
        if also:
            also(self)
        self.record(
            status=PREPARED, scene=scene.name, digest=scene.digest, versions=versions(), ranks=ranks,
            hashes={name: self.hash(name) for name in (DECK, DATA, *scene.files())},
            command=shlex.join(["wf", *sys.argv[1:]]),
        )  # fmt: skip

    def _clear(self) -> None:
        """Remove what `create` began, all but the lock."""
        for file in self.path.iterdir():
            if file.is_dir() and not file.is_symlink():
                shutil.rmtree(file)
            elif file.name != LOCK:
                file.unlink()

    def _require_free(self, scene: Scene) -> None:
        """Raise InputError unless the directory can be made here: it is absent, empty, or one that `create` did not finish."""
        try:
            left = set(os.listdir(self.path))
        except FileNotFoundError:
            return
        except OSError:
            left = {"a file"}
        ours = {LOCK, DATA, DECK, SCENE, *PORTABLE, *scene.files()}
        begun = LOCK in left and all(name in ours or re.fullmatch(r"\..*\.part", name) for name in left)
        if left and not begun:
            raise InputError(
                f"'{self.path}' exists and is not empty; nothing was changed. Give another --out DIR, or continue it with "
                f"'wf resume {shlex.quote(str(self.path))}'"
            )

    def write_text(self, name: str, text: str | Iterable[str]) -> None:
        """Write a file of the directory, given as a whole or in parts, as a whole or not at all."""
        with atomic_write(self / name) as draft, open(draft, "w", encoding="utf-8") as file:
            file.writelines([text] if isinstance(text, str) else text)

    def hash(self, name: str) -> str:
        """SHA-256 of a file of the directory."""
        try:
            with open_plain(self / name) as file:
                return hashlib.file_digest(file, "sha256").hexdigest()  # type: ignore[arg-type]
        except OSError as fault:
            raise ArchiveError(f"'{self / name}' cannot be read ({fault.strerror}); restore it, or run again") from None

    @property
    def state(self) -> dict[str, Any]:
        """The record in run.json."""
        try:
            state = json.loads(read_plain(self / "run.json"))
        except (OSError, ValueError, RecursionError) as fault:
            raise ArchiveError(
                f"'{self / 'run.json'}' cannot be read ({fault}); the directory is damaged, run again"
            ) from fault
        wrong = misfit(state)
        if wrong:
            raise ArchiveError(f"'{self / 'run.json'}' holds no record ({wrong}); the directory is damaged, run again")
        return state

    def record(self, **changes: Any) -> None:
        """Change entries of run.json."""
        state = self.state if (self / "run.json").exists() else {}
        self.write_text("run.json", json.dumps({**state, **changes}, indent=1) + "\n")

    @property
    def scene(self) -> Scene:
        """The scene of scene.toml."""
        return scene_from(read_toml(self / SCENE))

    def series(self) -> Series | None:
        """The time series so far, None before its first row."""
        if not os.path.lexists(self / "series.txt"):
            return None
        series = Series(read_series(self / "series.txt"))
        return series if len(series["step"]) else None

    @contextmanager
    def lock(self) -> Iterator[TextIO]:
        """One `wf` at a time works in a directory; a process that inherits the open file holds the lock as well."""
        with locked_file(self / LOCK, self._orphaned) as file:
            yield file

    def locked(self) -> bool:
        """True while a `wf`, or the engine it left, works in the directory, on whatever machine."""
        return is_locked(self / LOCK)

    def _orphaned(self) -> bool:
        """The `wf` that works here by the record was one of this machine, and is no more."""
        try:
            state = self.state
        except ArchiveError:
            return False
        return state.get("host") == platform.node() and not alive(state.get("pid"))

    def result(self) -> dict[str, float]:
        """How the run ended: stage, step, equilibrated, stopped; empty if it did not get there.

        Of a finished run as run.json says; of others as the deck printed it in its log.
        """
        state = self.state if (self / "run.json").is_file() else {}
        if state.get("status") == FINISHED and state.get("result"):
            return dict(state["result"])
        log = self / "log.lammps"
        lines = read_plain(log, errors="replace").splitlines() if log.is_file() else []
        words = next((line.split()[1:] for line in reversed(lines) if line.startswith("RESULT ")), [])
        try:
            return {name: float(value) for name, value in zip(words[::2], words[1::2], strict=True)}
        except ValueError:  # the line was cut off
            return {}

    def equilibrium(self) -> bool | None:
        """Whether the run, finished, ended in equilibrium; None before its end, and of a scene that does not end so."""
        if self.state["status"] != FINISHED or not self.scene.ends_in_equilibrium:
            return None
        equilibrated = self.result().get("equilibrated")
        return None if equilibrated is None else bool(equilibrated)


def misfit(state: Any) -> str | None:
    """What is wrong with the record of a run, None if nothing is."""
    if not isinstance(state, dict):
        return f"found {reprlib.repr(state)}"
    for name, (kinds, needed) in ENTRIES.items():
        if name not in state:
            if needed:
                return f"{name} is missing"
        elif not isinstance(state[name], kinds) or isinstance(state[name], bool):
            return f"{name} = {reprlib.repr(state[name])}"
    for name in ("versions", "hashes"):
        if not all(isinstance(value, str) for value in state.get(name, {}).values()):
            return f"{name} = {reprlib.repr(state[name])}"
    for name in state.get("hashes", {}):
        if name in ("", ".", "..") or "/" in name or "\0" in name:
            return f"hashes of {reprlib.repr(name)}, which is no name of a file here"
    for name, value in state.get("result", {}).items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 2.0**63:
            return f"result {reprlib.repr(name)} = {reprlib.repr(value)}"
    for name, extent in state.get("parts", {}).items():
        if not (isinstance(extent, list) and len(extent) == 2):
            return f"parts {reprlib.repr(name)} = {reprlib.repr(extent)}"
    if not all(isinstance(entry, dict) for entry in state.get("accepted", [])):
        return f"accepted = {reprlib.repr(state['accepted'])}"
    plan = state.get("extension")
    if plan is not None and not _is_extension(plan):
        return f"extension = {reprlib.repr(plan)}"
    if state["status"] not in (FINISHED, INTERRUPTED, FAILED, RUNNING, PREPARED):
        return f"status = {reprlib.repr(state['status'])}"
    if not 1 <= state.get("ranks", 1) <= 10**6:
        return f"ranks = {reprlib.repr(state['ranks'])}"
    if not 0.0 <= (state.get("seconds") or 0.0) < 1e12:
        return f"seconds = {reprlib.repr(state['seconds'])}"
    return None


def _is_extension(plan: dict[str, Any]) -> bool:
    """It has what `workflow.runs.extend` wrote: numbers in their places."""
    back, lasts = plan.get("back"), plan.get("lasts")
    pairs = list(lasts.items()) if isinstance(lasts, dict) else [("", None)]
    numbers = [
        plan.get("max_time"),
        plan.get("max_steps"),
        *(back if isinstance(back, list) else []),
        *(step for _, step in pairs),
    ]
    fits = all(isinstance(one, int | float) and not isinstance(one, bool) and 0 < one < 2.0**63 for one in numbers)
    return fits and (back is None or (isinstance(back, list) and len(back) == 2)) and all(name.isdecimal() for name, _ in pairs)


def default_directory(scene: Scene) -> Path:
    """runs/NAME-HASH: the same scene always goes to the same place."""
    return Path("runs") / f"{scene.name}-{scene.digest[:8]}"


def out_of_time(state: Mapping[str, Any]) -> bool:
    """By the record of a finished run: its scene ends in equilibrium, and it did not get there."""
    scene = SCENES.get(state["scene"])
    return scene is not None and scene.ends_in_equilibrium and not state.get("result", {}).get("equilibrated", 1)


def timestamp() -> str:
    """Now, UTC, ISO 8601."""
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())


def seconds_since(stamp: str | None) -> float:
    """Seconds since a `timestamp`, 0 for what is none."""
    try:
        return max((datetime.now(UTC) - datetime.fromisoformat(stamp or "")).total_seconds(), 0.0)
    except ValueError:
        return 0.0

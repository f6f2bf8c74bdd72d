"""A run directory: everything about one run, in files that say what they are.

scene.toml     the scene that repeats the run             run.json       status, command, versions, hashes, times
deck.in        the deck, runs alone with `lmp -in`        log.lammps     the engine's log
grains.data    initial grains                             series.txt     time series, one row per sample
grains.dump, contacts.dump   frames as the engine wrote   run.h5         the archive: frames, contacts, series
checkpoint.*   what `wf resume` continues from            measures.json  the measures of the last frame
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import reprlib
import shlex
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

from workflow.archive.drafts import replacing
from workflow.archive.dumps import read_series
from workflow.deck.render import DATA, DECK, data_parts, render
from workflow.engine.environment import versions
from workflow.errors import ArchiveError, InputError, WorkflowError
from workflow.scene.presets import Scene, read_toml, scene_from, to_toml

ARCHIVE, TRACKS = "run.h5", "tracks.dump"
LOCK_PATIENCE = 3.0  # seconds for the engine of a killed wf to end
FINISHED, INTERRUPTED, FAILED, RUNNING, PREPARED = "finished", "interrupted", "failed", "running", "prepared"
# entries of run.json: their types, and whether they must be there
NOTHING = type(None)
ENTRIES: dict[str, tuple[tuple[type, ...], bool]] = {
    "status": ((str,), True), "scene": ((str,), True), "digest": ((str,), True), "versions": ((dict,), True),
    "hashes": ((dict,), False), "command": ((str,), False), "ranks": ((int,), False), "pid": ((int, NOTHING), False),
    "host": ((str,), False),
    "reason": ((str, NOTHING), False), "started": ((str,), False), "finished": ((str,), False),
    "seconds": ((int, float, NOTHING), False), "result": ((dict,), False),
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
    def create(cls, path: Path, scene: Scene) -> RunDirectory:
        """A new run directory with deck, data and provenance; nothing is left if that fails."""
        if path.exists() and (not path.is_dir() or any(path.iterdir())):
            raise InputError(
                f"'{path}' exists and is not empty; nothing was changed. Give another --out DIR, or continue it with "
                f"'wf resume {shlex.quote(str(path))}'"
            )
        deck, discs = render(scene), scene.discs()
        run, existed = cls(path), path.exists()
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as fault:
            raise InputError(f"cannot create '{path}': {fault.strerror}; give a writable --out DIR") from fault
        try:
            run.write_text(DATA, data_parts(discs))
            run.write_text(DECK, deck)
            for name, text in scene.files().items():
                run.write_text(name, text)
            run.write_text("scene.toml", to_toml(scene))
            run.record(
                status=PREPARED, scene=scene.name, digest=scene.digest, versions=versions(),
                hashes={name: run.hash(name) for name in (DECK, DATA, *scene.files())},
                command=shlex.join(["wf", *sys.argv[1:]]),
            )  # fmt: skip
        except BaseException:
            for file in path.iterdir():
                file.unlink()
            if not existed:
                path.rmdir()
            raise
        return run

    def write_text(self, name: str, text: str | Iterable[str]) -> None:
        """Write a file of the directory, given as a whole or in parts, as a whole or not at all."""
        with replacing(self / name) as draft, open(draft, "w", encoding="utf-8") as file:
            file.writelines([text] if isinstance(text, str) else text)

    def hash(self, name: str) -> str:
        """SHA-256 of a file of the directory."""
        with open(self / name, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()

    @property
    def state(self) -> dict[str, Any]:
        """The record in run.json."""
        try:
            state = json.loads((self / "run.json").read_text(encoding="utf-8"))
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
        return scene_from(read_toml(self / "scene.toml"))

    def series(self) -> Series | None:
        """The time series so far, None before its first row."""
        if not (self / "series.txt").is_file():
            return None
        series = Series(read_series(self / "series.txt"))
        return series if len(series["step"]) else None

    @contextmanager
    def lock(self) -> Iterator[TextIO]:
        """One `wf` at a time works in a directory; a process that inherits the open file holds the lock as well."""
        with open(self / ".lock", "w") as file:
            deadline = time.monotonic() + LOCK_PATIENCE
            while True:
                try:
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    break
                except OSError:
                    if time.monotonic() > deadline:
                        raise WorkflowError(
                            f"'{self.path}' is in use by another wf; wait for it, or look with 'wf status {self.path}'"
                        ) from None
                    time.sleep(0.05)
            yield file

    def locked(self) -> bool:
        """True while a `wf`, or the engine it left, works in the directory, on whatever machine."""
        try:
            with open(self / ".lock") as file:
                fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except FileNotFoundError:
            return False
        except OSError:
            return True
        return False

    def result(self) -> dict[str, float]:
        """What the deck printed at its end: stage, step, equilibrated, stopped.  Empty if it did not get there."""
        log = self / "log.lammps"
        lines = log.read_text(encoding="utf-8", errors="replace").splitlines() if log.is_file() else []
        words = next((line.split()[1:] for line in reversed(lines) if line.startswith("RESULT ")), [])
        try:
            return {name: float(value) for name, value in zip(words[::2], words[1::2], strict=True)}
        except ValueError:  # the line was cut off
            return {}


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
    if state["status"] not in (FINISHED, INTERRUPTED, FAILED, RUNNING, PREPARED):
        return f"status = {reprlib.repr(state['status'])}"
    if not 1 <= state.get("ranks", 1) <= 10**6:
        return f"ranks = {reprlib.repr(state['ranks'])}"
    if not 0.0 <= (state.get("seconds") or 0.0) < 1e12:
        return f"seconds = {reprlib.repr(state['seconds'])}"
    return None


def default_directory(scene: Scene) -> Path:
    """runs/NAME-HASH: the same scene always goes to the same place."""
    return Path("runs") / f"{scene.name}-{scene.digest[:8]}"


def timestamp() -> str:
    """Now, UTC, ISO 8601."""
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())

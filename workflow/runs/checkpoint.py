"""Checkpoints: LAMMPS restart files checkpoint.STAGE.a and .b, and their seals."""

from __future__ import annotations

import hashlib
import json
import os
import re
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workflow.data.files import atomic_write, read_plain, regular
from workflow.runs.outputs import Extent, Parts

ACCOUNT, ACCOUNTED = "account.in", 2  # what the drag took so far, written when this stage ends
_NAME = re.compile(r"checkpoint\.[1-9][0-9]{0,2}\.[ab]")
_MAGIC = b"LammpS RestartT\0"
# record flags at the head of a restart file
_VERSION, _SMALLINT, _TAGINT, _BIGINT, _UNITS, _NTIMESTEP = range(6)
_IMAGEINT = 48


@dataclass(frozen=True)
class Checkpoint:
    """A restart file with the stage it belongs to and the step it was written at."""

    path: Path
    stage: int
    step: int


class CheckpointChecksums:
    """Writes beside every complete checkpoint of ``folder`` what it must hold: step, size, SHA-256 (checkpoint.1.a.json), and
    ``parts``, size and SHA-256 of what series, dumps and notes of the deck held by then.

    The engine writes to two files in turn, so that one is whole while the other is written; a seal is written, after the
    checkpoint and what belongs to it have reached the disk, as a whole or not at all.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.parts = folder, Parts(folder)
        self.seen: dict[Path, tuple[int, int]] = {}

    def look(self) -> None:
        """Seal what is new.  Raises ArchiveError if the disk is full, or something is missing in what belongs to it."""
        fresh = [path for path in _files(self.folder) if _state(path) != self.seen.get(path) and _complete(path)]
        for path in sorted(fresh, key=lambda path: (step_of(path) or 0, _stage(path))):
            self._seal(path)

    def _seal(self, path: Path) -> None:
        state, step = _state(path), step_of(path)
        if step is None:
            return
        if _fits(path) is None:  # else it was sealed before this Seals was made
            entry = {"step": step, "size": state[1], "sha256": _hash(path)}
            if _state(path) != state:
                return  # the engine has begun to write the next one
            names = notes(self.folder, _stage(path))
            parts = self.parts.sealable(step) | {name: extent(self.folder / name) for name in names}
            for file in (path, *(self.folder / name for name in parts)):
                _sync(file)
            with atomic_write(_seal(path)) as draft:
                draft.write_text(json.dumps({**entry, "parts": parts}) + "\n", encoding="ascii")
        self.seen[path] = state


def notes(folder: Path, stage: int) -> list[str]:
    """What the deck wrote down for itself before a checkpoint of ``stage``, and reads when it resumes."""
    stages = [f"stage.{number}.in" for number in range(1, stage + 1)]
    return [name for name in (*stages, *([ACCOUNT] if stage > ACCOUNTED else [])) if (folder / name).is_file()]


def newest(folder: Path) -> Checkpoint | None:
    """The valid checkpoint with the largest step, or None.

    Valid are those that their seals confirm; only if there is none, whole ones that no seal speaks of (of a deck that was run
    by hand, or written since the last look), never one that its seal contradicts.  Those that a run wrote when it was asked
    to stop are left out: they were not part of its course, so what continues from them would not be, bit for bit, the run
    without the stop.
    """
    found = whole(folder)
    sealed = [one for one in found if confirmed(one.path)]
    return max(sealed or found, key=lambda c: (c.step, c.stage), default=None)


def whole(folder: Path) -> list[Checkpoint]:
    """Whole checkpoints that no seal contradicts."""
    paths = [path for path in _files(folder) if _complete(path) and not _contradicted(path)]
    return [Checkpoint(path, _stage(path), step_of(path) or 0) for path in paths]


def damaged(folder: Path) -> list[Path]:
    """Checkpoints that are not what their seal says, or not whole."""
    return [path for path in _files(folder) if not _complete(path) or _contradicted(path)]


def confirmed(path: Path) -> bool:
    """The file is, bit for bit, what its seal says."""
    return _fits(path) is True


def _contradicted(path: Path) -> bool:
    """The file has the step of its seal, but not its bits.  A seal of an earlier step says nothing: the engine wrote since."""
    return _fits(path) is False


def _fits(path: Path) -> bool | None:
    """Whether the file is what its seal says; None if there is no seal of its step."""
    entry = seal_of(path)
    if not entry or entry["step"] != step_of(path):
        return None
    return bool(entry["size"] == path.stat().st_size and entry["sha256"] == _hash(path))


def seal_of(path: Path) -> dict[str, Any]:
    """The seal of a checkpoint, {} if it has none that can be read."""
    try:
        entry = json.loads(read_plain(_seal(path)))
    except (OSError, ValueError, RecursionError):
        return {}
    parts = entry.get("parts", {}) if isinstance(entry, dict) else None
    valid = isinstance(parts, dict) and {"step", "size", "sha256"} <= entry.keys() and all(
        isinstance(extent, list) and len(extent) == 2 for extent in parts.values()
    )  # fmt: skip
    return entry if valid else {}


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.glob("checkpoint.*.[ab]") if _NAME.fullmatch(path.name) and regular(path))


def _stage(path: Path) -> int:
    return int(path.name.split(".")[1])


def _seal(path: Path) -> Path:
    return path.with_name(path.name + ".json")


def _state(path: Path) -> tuple[int, int]:
    state = path.stat()
    return state.st_mtime_ns, state.st_size


def extent(path: Path) -> Extent:
    return (path.stat().st_size, _hash(path)) if regular(path) else (0, "")


def _hash(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _sync(path: Path) -> None:
    if path.is_file():
        with open(path, "rb") as file:
            os.fsync(file.fileno())


def _complete(path: Path) -> bool:
    """Head and end mark are there: the engine came to the end of writing it."""
    size = path.stat().st_size
    with open(path, "rb") as file:
        file.seek(max(size - len(_MAGIC), 0))
        return size > len(_MAGIC) and file.read() == _MAGIC and step_of(path) is not None


def step_of(path: Path) -> int | None:
    """The step in the head of a restart file, None if it is none (or was cut off)."""
    with open(path, "rb") as file:
        head = file.read(512)
    try:
        if head[:16] != _MAGIC:
            return None
        at = 16 + 4 + 4  # magic, byte order, format revision
        while True:
            (flag,) = struct.unpack_from("<i", head, at)
            at += 4
            if flag == _NTIMESTEP:
                return int(struct.unpack_from("<q", head, at)[0])
            if flag in (_VERSION, _UNITS):
                (length,) = struct.unpack_from("<i", head, at)
                if length < 0:
                    return None
                at += length
            elif flag not in (_SMALLINT, _IMAGEINT, _TAGINT, _BIGINT):
                return None
            at += 4
    except struct.error:
        return None


def drop_later(folder: Path, chosen: Checkpoint | None) -> None:
    """Remove checkpoints of a course that ends here, those beyond ``chosen``, the one to continue from (None: all), and damaged
    ones.

    Were they left, a run that is killed once more could continue from one of them, past rows and frames it never wrote.
    """
    for path in _files(folder):
        beyond = chosen is None or (step_of(path) or 0) > chosen.step or _stage(path) > chosen.stage
        if beyond or not _complete(path) or _contradicted(path):
            path.unlink()
            _seal(path).unlink(missing_ok=True)


def drop_beyond(folder: Path, stage: int, step: int) -> None:
    """Remove checkpoints of later stages, and of ``stage`` beyond ``step``: the course ends there."""
    for path in _files(folder):
        if _stage(path) > stage or (step_of(path) or 0) > step:
            path.unlink()
            _seal(path).unlink(missing_ok=True)
    for path in folder.glob("checkpoint.*.end"):
        path.unlink()


def reseal(folder: Path, names: list[str]) -> None:
    """Let the seals say what the notes ``names`` hold now."""
    for path in _files(folder):
        entry = seal_of(path)
        changed = {name: extent(folder / name) for name in names if name in entry.get("parts", {})}
        if changed:
            with atomic_write(_seal(path)) as draft:
                draft.write_text(json.dumps({**entry, "parts": entry["parts"] | changed}) + "\n", encoding="ascii")

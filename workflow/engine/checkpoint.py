"""Checkpoints: LAMMPS restart files checkpoint.STAGE.a and .b with their seals, and cutting a run's files back to one."""

from __future__ import annotations

import hashlib
import json
import os
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from workflow.archive.drafts import replacing
from workflow.archive.dumps import read_blocks, read_series

DUMPS = {"grains.dump": "ATOMS", "contacts.dump": "ENTRIES", "tracks.dump": "ATOMS"}
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


class Seals:
    """Writes beside every complete checkpoint of ``folder`` what it must hold: step, size, SHA-256 (checkpoint.1.a.json).

    The engine writes to two files in turn, so that one is whole while the other is written; a seal is written, after the
    checkpoint and what belongs to it have reached the disk, as a whole or not at all.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.seen: dict[Path, tuple[int, int]] = {}

    def look(self) -> None:
        """Seal what is new.  Raises ArchiveError if the disk is full."""
        for path in _files(self.folder):
            state = _state(path)
            if state != self.seen.get(path) and _complete(path):
                entry = {"step": step_of(path), "size": state[1], "sha256": _hash(path)}
                if _state(path) != state:
                    continue  # the engine has begun to write the next one
                for file in (path, *(self.folder / name for name in ("series.txt", *DUMPS))):
                    _sync(file)
                with replacing(_seal(path)) as draft:
                    draft.write_text(json.dumps(entry) + "\n", encoding="ascii")
                self.seen[path] = state


def newest(folder: Path) -> Checkpoint | None:
    """The valid checkpoint with the largest step, or None.

    Valid are those that their seals confirm; only if there is none, whole ones that no seal speaks of (of a deck that was run
    by hand, or written since the last look), never one that its seal contradicts.  Those that a run wrote when it was asked
    to stop are left out: they were not part of its course, so what continues from them would not be, bit for bit, the run
    without the stop.
    """
    whole = [path for path in _files(folder) if _complete(path) and not _contradicted(path)]
    found = [Checkpoint(path, int(path.name.split(".")[1]), step_of(path) or 0) for path in whole]
    sealed = [one for one in found if confirmed(one.path)]
    return max(sealed or found, key=lambda c: (c.step, c.stage), default=None)


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
    try:
        entry = json.loads(_seal(path).read_text(encoding="ascii"))
        if entry["step"] != step_of(path):
            return None
        return bool(entry["size"] == path.stat().st_size and entry["sha256"] == _hash(path))
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.glob("checkpoint.[0-9]*.[ab]"))


def _seal(path: Path) -> Path:
    return path.with_name(path.name + ".json")


def _state(path: Path) -> tuple[int, int]:
    state = path.stat()
    return state.st_mtime_ns, state.st_size


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
    """Remove checkpoints of a course that ends here: those beyond ``chosen``, the one to continue from (None: all).

    Were they left, a run that is killed once more could continue from one of them, past rows and frames it never wrote.
    """
    for path in _files(folder):
        if chosen is None or (step_of(path) or 0) > chosen.step or int(path.name.split(".")[1]) > chosen.stage:
            path.unlink()
            _seal(path).unlink(missing_ok=True)


def cut_back(folder: Path, step: int) -> None:
    """Drop rows of the series beyond the checkpoint of ``step`` in ``folder``, and frames at or beyond it: the resumed run
    writes those again."""
    _rewrite_series(folder, lambda line: line.endswith("\n") and int(line.split()[0]) <= step)
    for name, kind in DUMPS.items():
        if (folder / name).is_file():
            _cut_dump(folder / name, kind, step)


def drop_repeats(folder: Path) -> None:
    """Leave the first title of the series and the first row of a step: a resumed engine writes title and row once more."""
    written = set[tuple[str, str]]()

    def first(line: str) -> bool:
        step, _, stage, *_ = line.split()
        new = (step, stage) not in written
        written.add((step, stage))
        return new

    _rewrite_series(folder, first)


def _rewrite_series(folder: Path, keep: Callable[[str], bool]) -> None:
    series = folder / "series.txt"
    if not series.is_file():
        return
    lines = series.read_text(encoding="ascii", errors="surrogateescape").splitlines(keepends=True)
    if lines:
        read_series(series)  # says where it is damaged
    kept = [line for k, line in enumerate(lines) if (k == 0 if line.startswith("#") else keep(line))]
    if kept != lines:
        with replacing(series) as draft:
            draft.write_text("".join(kept), encoding="ascii", errors="surrogateescape")


def _cut_dump(path: Path, kind: str, step: int) -> None:
    end = 0
    for block in read_blocks(path, kind):
        if block.step >= step:
            break
        end = block.line + len(block.table)
    with replacing(path) as draft, open(path, "rb") as old, open(draft, "wb") as new:
        for _ in range(end):
            new.write(old.readline())

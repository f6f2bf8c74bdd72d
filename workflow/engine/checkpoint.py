"""Checkpoints: LAMMPS restart files named checkpoint.STAGE.WHICH, and cutting a run's files back to one."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

from workflow.archive.dumps import read_blocks
from workflow.archive.write import replacing

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


def newest(folder: Path) -> Checkpoint | None:
    """The checkpoint with the largest step that has a readable head, or None."""
    found = []
    for file in folder.glob("checkpoint.[0-9].*"):
        step = step_of(file)
        if step is not None:
            found.append(Checkpoint(file, int(file.name.split(".")[1]), step))
    return max(found, key=lambda c: (c.step, c.stage), default=None)


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
                at += struct.unpack_from("<i", head, at)[0]
            elif flag not in (_SMALLINT, _IMAGEINT, _TAGINT, _BIGINT):
                return None
            at += 4
    except struct.error:
        return None


def cut_back(folder: Path, step: int) -> None:
    """Drop what series and dumps of ``folder`` hold beyond ``step``: the resumed run writes it again."""
    series = folder / "series.txt"
    if series.is_file():
        lines = series.read_text(encoding="ascii", errors="replace").splitlines(keepends=True)
        kept = [line for line in lines if line.startswith("#") or (line.endswith("\n") and int(line.split()[0]) <= step)]
        with replacing(series) as draft:
            draft.write_text("".join(kept), encoding="ascii")
    for name, kind in (("grains.dump", "ATOMS"), ("contacts.dump", "ENTRIES"), ("tracks.dump", "ATOMS")):
        if (folder / name).is_file():
            _cut_dump(folder / name, kind, step)


def _cut_dump(path: Path, kind: str, step: int) -> None:
    end = 0
    for block in read_blocks(path, kind):
        if block.step > step:
            break
        end = block.line + len(block.table)
    with replacing(path) as draft, open(path, "rb") as old, open(draft, "wb") as new:
        for _ in range(end):
            new.write(old.readline())

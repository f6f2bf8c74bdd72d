"""What the engine wrote, part by part: lengths and running hashes of time series and dumps up to a step.

A checkpoint of step S is continued from rows of the series up to S and frames before S; those are what its seal covers.
Repeated titles and rows, which a resumed engine writes once more, do not count: the hash is that of the series without them.
"""

from __future__ import annotations

import hashlib
import os
import statistics
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice, pairwise
from pathlib import Path
from typing import BinaryIO

from workflow.data.files import atomic_write, open_plain, regular
from workflow.errors import ArchiveError

SERIES = "series.txt"
DUMPS = {"grains.dump": "ATOMS", "contacts.dump": "ENTRIES", "tracks.dump": "ATOMS"}
HEAD = 11  # lines of a frame before its rows
ROWS = 65536  # lines in memory at one time
LARGEST = 18  # digits of a whole number that fits 64 bits
Extent = tuple[int, str]  # bytes, SHA-256


def _fault(path: Path, line: int, words: str) -> ArchiveError:
    return ArchiveError(f"{path}, line {line}: {words}; it was damaged, or could not be written (quota, disk, size limit)")


@dataclass
class Part:
    """One file, read so far: ``offset`` bytes of it, ``line`` lines, and of what counts the size and the hash.

    ``last``: step of the last row or frame that was read.
    """

    path: Path
    offset: int = 0
    line: int = 0
    size: int = 0
    last: int = -1
    hash: hashlib._Hash = field(default_factory=hashlib.sha256, repr=False)

    @property
    def extent(self) -> Extent:
        """Size and hash of what was read."""
        return self.size, self.hash.hexdigest()

    def read_to(self, step: int) -> Extent:
        """Read on as far as ``step`` goes.  Raises ArchiveError where the file is not what the engine writes."""
        try:
            file = open_plain(self.path)
        except FileNotFoundError:
            return self.extent
        except OSError as fault:
            raise ArchiveError(f"cannot read '{self.path}': {fault.strerror}; restore it or run again") from None
        with file:
            file.seek(self.offset)
            self._read(file, step)
        return self.extent

    def _read(self, file: BinaryIO, step: int) -> None:
        raise NotImplementedError

    def _take(self, lines: list[bytes], counts: bool = True) -> None:
        """These lines were read; ``counts``: they are part of what is sealed."""
        text = b"".join(lines)
        self.offset += len(text)
        self.line += len(lines)
        if counts:
            self.hash.update(text)
            self.size += len(text)


@dataclass
class Series(Part):
    """The time series: its ``title``, and of the rows that count the steps, by stage."""

    title: bytes = b""
    rows: dict[bytes, list[int]] = field(default_factory=dict, repr=False)
    known: set[tuple[int, bytes]] = field(default_factory=set, repr=False)

    def _read(self, file: BinaryIO, step: int) -> None:
        for line in file:
            if not line.endswith(b"\n") or not self._accept(line, step):
                return

    def _accept(self, line: bytes, step: int) -> bool:
        """Take a line, False if it is beyond ``step``."""
        words = line.split()
        if not self.title or line.startswith(b"#"):
            if not line.startswith(b"# step time stage ") or line != (self.title or line):
                raise _fault(self.path, self.line + 1, "expected the title '# step time stage ...'")
            self._take([line], counts=not self.title)
            self.title = line
            return True
        if len(words) != len(self.title.split()) - 1 or not _whole(words[0]) or not all(map(_number, words)):
            raise _fault(self.path, self.line + 1, f"expected {len(self.title.split()) - 1} numbers that begin with a step")
        number, stage = int(words[0]), words[2]
        if number > step:
            return False
        new = (number, stage) not in self.known
        if number < self.last:
            raise _fault(self.path, self.line + 1, f"found step {number} after step {self.last}")
        self._take([line], counts=new)
        if new:
            self.known.add((number, stage))
            self.rows.setdefault(stage, []).append(number)
            self.last = number
        return True

    def complete(self, step: int) -> None:
        """Raise ArchiveError if rows are missing up to ``step``: within a stage they are equally spaced."""
        if not self.rows:
            raise ArchiveError(f"{self.path} has no row up to step {step}; it was lost, or could not be written (quota, disk)")
        last, interval = -1, 0
        for steps in self.rows.values():
            apart = [two - one for one, two in pairwise(steps)]
            due = statistics.median_low(apart[1:]) if len(apart) > 2 else 0  # too few to tell
            if due and interval and steps[0] - last > interval + due:
                raise self._gap(last, interval)
            late = next((one for one, two in pairwise(steps) if due and two - one > due), None)
            if late is not None:
                raise self._gap(late, due)
            last, interval = steps[-1], due
        if interval and step - last >= interval:
            raise self._gap(last, interval)

    def cut(self) -> None:
        """Leave in the file what counts of what was read; no file where nothing was."""
        if not self.line:
            try:
                self.path.unlink(missing_ok=True)
            except OSError:  # it is mounted there
                os.truncate(self.path, 0)
            return
        again, kept = Series(self.path), list[bytes]()
        with open_plain(self.path) as file:
            for line in islice(file, self.line):
                before = again.size
                again._accept(line, self.last)
                kept += [line] if again.size > before else []
            whole = again.size == self.offset and not file.read(1)
        if not whole:
            with atomic_write(self.path) as draft:
                draft.write_bytes(b"".join(kept))

    def _gap(self, step: int, interval: int) -> ArchiveError:
        return ArchiveError(f"{self.path}: rows are missing behind step {step}, where one is due every {interval} steps; they "
                            "were lost, or could not be written (quota, disk, size limit)")  # fmt: skip


@dataclass
class Dump(Part):
    """Frames of a dump of kind ``kind``, those before a step; ``steps``: of the whole frames."""

    kind: str = "ATOMS"
    steps: list[int] = field(default_factory=list, repr=False)

    def _read(self, file: BinaryIO, step: int) -> None:
        while True:
            head = list(islice(file, HEAD))
            if len(head) < HEAD or not head[-1].endswith(b"\n"):
                return
            number, rows = self._head(head)
            if number >= step:
                return
            if not self._frame(file, head, rows):
                return
            self.last = number
            self.steps.append(number)

    def _head(self, head: list[bytes]) -> tuple[int, int]:
        """Step and number of rows in the head of a frame."""
        marks = {0: b"ITEM: TIME\n", 2: b"ITEM: TIMESTEP\n", 4: b"ITEM: NUMBER OF %s\n" % self.kind.encode()}
        starts = {6: b"ITEM: BOX BOUNDS ", 10: b"ITEM: %s " % self.kind.encode()}
        for k, mark in (marks | starts).items():
            if not head[k].startswith(mark):
                raise _fault(self.path, self.line + 1 + k, f"expected '{mark.decode().strip()}'")
        if not (_whole(head[3]) and _whole(head[5]) and int(head[3]) >= self.last):
            raise _fault(self.path, self.line + 4, "expected a step that is not below the one before, and a number of rows")
        return int(head[3]), int(head[5])

    def cut(self) -> None:
        """Leave in the file what was read."""
        if regular(self.path) and self.path.stat().st_size > self.offset:
            os.truncate(self.path, self.offset)

    def _frame(self, file: BinaryIO, head: list[bytes], rows: int) -> bool:
        """Take a frame; nothing of it, and False, if it is not whole."""
        draft = Part(self.path, hash=self.hash.copy())
        draft._take(head)
        for done in range(0, rows, ROWS):
            lines = list(islice(file, min(ROWS, rows - done)))
            if len(lines) < min(ROWS, rows - done) or not lines[-1].endswith(b"\n"):
                return False
            draft._take(lines)
        self.hash, self.offset, self.line, self.size = (
            draft.hash, self.offset + draft.offset, self.line + draft.line, self.size + draft.size
        )  # fmt: skip
        return True


class Parts:
    """The files that a run consists of beside its checkpoints."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.series = Series(folder / SERIES)
        self.dumps = {name: Dump(folder / name, kind=kind) for name, kind in DUMPS.items()}

    def __iter__(self) -> Iterator[Part]:
        yield self.series
        yield from self.dumps.values()

    def extents(self, step: int) -> dict[str, Extent]:
        """Size and hash of every part as far as a checkpoint of ``step`` needs it; steps must not go back."""
        return {part.path.name: part.read_to(step) for part in self if part.path.is_file()}

    def cut(self) -> None:
        """Leave in the files what was read."""
        self.series.cut()
        for dump in self.dumps.values():
            dump.cut()

    def sealable(self, step: int) -> dict[str, Extent]:
        """`extents`, of parts in which nothing is missing.  Raises ArchiveError that names what is."""
        found = self.extents(step)
        self.series.complete(step)
        self.paired()
        return found

    def paired(self) -> None:
        """Raise ArchiveError unless grains and contacts were written at the same steps."""
        grains, contacts = (self.dumps[name].steps for name in ("grains.dump", "contacts.dump"))
        if grains != contacts:
            odd = min(set(grains) ^ set(contacts), default=grains[-1] if grains else 0)
            lacking = "contacts.dump" if odd in grains else "grains.dump"
            raise ArchiveError(f"{self.folder / lacking}: the frame of step {odd} is missing; it was lost, or could not be "
                               "written (quota, disk, size limit)")  # fmt: skip

    def finished(self, step: int) -> dict[str, Extent]:
        """Size and hash of every part of a run that ended at ``step``.  Raises ArchiveError if one does not end there."""
        found = self.extents(step + 1)
        self.series.complete(step)
        self.paired()
        frames = self.dumps["grains.dump"]
        if frames.last != step:
            raise ArchiveError(f"{frames.path} ends at step {frames.last}, the run at step {step}: its end was lost, or could "
                               "not be written (quota, disk, size limit)")  # fmt: skip
        more = next((part.path for part in self if part.path.is_file() and part.path.stat().st_size > part.offset), None)
        if more:
            raise ArchiveError(f"{more} goes on behind step {step}, where the run ended; it was damaged, or is of another run")
        return found


def _whole(word: bytes) -> bool:
    return word.strip().isdigit() and len(word.strip()) <= LARGEST


def _number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True

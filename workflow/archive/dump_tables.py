"""The tables of text dumps: of one file or several, by step and by the names of their columns."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import BinaryIO

import numpy as np

from workflow.archive.formats import BUFFER, unpacked
from workflow.archive.snapshots import Snapshot, snapshots_in
from workflow.data.files import PathLike
from workflow.data.frame import Floats
from workflow.data.text import read_columns
from workflow.errors import ArchiveError, InputError


class Dump:
    """The snapshots of one or several files: ``snapshots``, {step: Snapshot} ascending, of a step that was written twice
    the later writing; ``notes`` say what is not plain.  Raises InputError for a file without a whole snapshot."""

    def __init__(self, paths: Iterable[PathLike]) -> None:
        self.paths, self.notes, steps = list(paths), list[str](), dict[int, Snapshot]()
        for path in self.paths:
            found, said = snapshots_in(path)
            if not found:
                raise InputError(
                    f"'{path}' holds no complete snapshot (a last line without its end counts as cut off); give another dump"
                    + "".join(f" ({note})" for note in said)
                )
            twice = set()
            for block in found:
                if block.step in steps:
                    twice.add(block.step)
                steps[block.step] = block
            if twice:
                self.notes.append(f"{path}: step {_some(sorted(twice))} is written twice; the later writing counts")
            self.notes += said
        self.snapshots = dict(sorted(steps.items()))
        self.streaming = False  # keep the file open: of a packed one the next table is read on from there
        self._file: tuple[PathLike, BinaryIO] | None = None

    def table(self, block: Snapshot, names: Sequence[str]) -> dict[str, Floats]:
        """Columns ``names`` of a snapshot, each (rows,) float64.  Raises ArchiveError, see `read_columns`."""
        wanted = [block.columns.index(name) for name in names]
        try:
            table = read_columns(block.path, self._at(block), block.line, block.rows, block.columns, wanted)
        except OSError as error:
            raise ArchiveError(f"{block.path}: {error}; the file is damaged, restore it") from None
        finally:
            if not self.streaming:
                self.close()
        return {name: np.ascontiguousarray(table[:, k]) for k, name in enumerate(names)}

    def _at(self, block: Snapshot) -> BinaryIO:
        """The file before the first row of ``block``."""
        if self._file is None or self._file[0] != block.path or self._file[1].tell() > block.offset:
            self.close()
            self._file = (block.path, unpacked(block.path)[0])
        file = self._file[1]
        if file.seekable():
            file.seek(block.offset)
        while left := block.offset - file.tell():
            if not file.read(min(left, BUFFER)):
                raise OSError("it was changed while it was read")
        return file

    def close(self) -> None:
        """Close what is open."""
        if self._file is not None:
            self._file[1].close()
        self._file = None


def _some(steps: Sequence[int]) -> str:
    """A few steps for a message."""
    return ", ".join(map(str, steps[:4])) + (f" and {len(steps) - 4} more" if len(steps) > 4 else "")

"""What is recorded of a run, read where it is sealed: series.txt and the log beside the archive may be cut or changed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from workflow.archive.read import Archive
from workflow.data.frame import Frame
from workflow.runs.directory import ARCHIVE, RunDirectory, Series


@dataclass(frozen=True)
class Recorded:
    """A run while its archive is open: its ``scene``, its time series, name -> (rows,), and how it ended: ``result``, empty if
    it did not get there; of archives that do not hold it, that of run.json."""

    scene: Any
    archive: Archive
    series: Series
    result: dict[str, Any]
    last: int  # step of the last frame

    def row(self, frame: Frame) -> int | None:
        """The row of the time series nearest to ``frame``, None without a series."""
        return int(abs(self.series["step"] - frame.step).argmin()) if self.series else None

    def is_last(self, frame: Frame) -> bool:
        """``frame`` is the last of the run."""
        return frame.step == self.last

    def equilibrated(self, frame: Frame) -> bool | None:
        """Whether the run ended in equilibrium; None of any frame but the last."""
        return bool(self.result.get("equilibrated")) if self.is_last(frame) else None


@contextmanager
def recorded(directory: RunDirectory) -> Iterator[Recorded]:
    """The record of the run in ``directory``."""
    with Archive(directory / ARCHIVE) as archive:
        end = archive.provenance.get("result")
        result = end if isinstance(end, dict) else directory.result()
        yield Recorded(directory.scene, archive, Series(archive.series), result, archive.frame(-1).step)

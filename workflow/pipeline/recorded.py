"""What is recorded of a run beside its frames, read where it is sealed."""

from __future__ import annotations

from typing import Any

from workflow.archive.read import Archive
from workflow.runs.directory import ARCHIVE, RunDirectory, Series


def recorded(directory: RunDirectory) -> tuple[Series, dict[str, Any]]:
    """Time series and end of a run as its archive holds them: series.txt and the log beside it may be cut or changed.

    The end is empty if the run did not get there; of archives that do not hold it, it is that of run.json.
    """
    with Archive(directory / ARCHIVE) as archive:
        end = archive.provenance.get("result")
        return Series(archive.series), end if isinstance(end, dict) else directory.result()

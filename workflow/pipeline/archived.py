"""The archive of a run: made once from what the engine wrote, and never exchanged for a worse one."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

from workflow.archive.read import Archive
from workflow.errors import ArchiveError
from workflow.pipeline.collect import collect, dump_sizes
from workflow.runs.directory import ARCHIVE, FINISHED, RunDirectory
from workflow.runs.identity import check_inputs
from workflow.runs.outputs import Parts


def archived(directory: RunDirectory, *, any_deck: bool = False) -> RunDirectory:
    """The directory with its archive, made now if the run was killed or its deck was run by hand.

    Once there, the archive is made again only from dumps that hold more; if they are damaged it stays, and a sentence on
    standard error says what is.  Raises InputError if the run is not what its record says (see `check_inputs`), ArchiveError
    if there is no archive and the dumps of a finished run are not what the run recorded.
    """
    check_inputs(directory, any_deck=any_deck)
    if not (directory / ARCHIVE).is_file():
        if not (directory / "grains.dump").is_file():
            raise ArchiveError(f"'{directory.path}' has no results yet; run its deck, or 'wf resume {directory.path}'")
        _require_whole(directory)
        _collect(directory)
        return directory
    with Archive(directory / ARCHIVE) as archive:
        provenance, last, frames = archive.provenance, archive.frame(-1).step, len(archive)
    if provenance.get("digest") != directory.state["digest"]:
        raise ArchiveError(f"'{directory / ARCHIVE}' is the archive of another run; remove it, and 'wf measure' makes its own")
    if (directory / "grains.dump").is_file() and provenance.get("sizes") != dump_sizes(directory):
        worse = _worse(directory, last, frames)
        if worse:
            print(f"wf: {worse}; '{directory / ARCHIVE}', which is sound, stays as it is and is used", file=sys.stderr)
        else:
            _collect(directory)
    return directory


def _collect(directory: RunDirectory) -> None:
    result = directory.result()
    collect(directory)
    if result and not result.get("stopped"):  # the deck came to its end; a killed run stays one to resume
        directory.record(status=FINISHED, reason=None, result=result)


def _worse(directory: RunDirectory, last: int, frames: int) -> str | None:
    """Why the dumps must not replace an archive of so many frames up to step ``last``; None if they may."""
    try:
        held = _require_whole(directory)
    except ArchiveError as fault:
        return str(fault)
    if held is None or held[0] < last or held[1] < frames:
        return f"the dumps in '{directory.path}' hold less than the archive that was made of them"
    return None


def _require_whole(directory: RunDirectory) -> tuple[int, int] | None:
    """Step of the last frame and number of frames in the dumps, None without any.

    Raises ArchiveError if the run came to its end and they do not, or are not what it recorded of them.
    """
    state, result, parts = directory.state, directory.result(), Parts(directory.path)
    if result:
        _require_recorded(directory, parts.finished(int(result.get("step", -1))), state)
    else:
        parts.extents(1 << 62)
    steps = sorted({*parts.dumps["grains.dump"].steps} & {*parts.dumps["contacts.dump"].steps})
    return (steps[-1], len(steps)) if steps else None


def _require_recorded(directory: RunDirectory, found: Mapping[str, Any], state: Mapping[str, Any]) -> None:
    for name, extent in state.get("parts", {}).items() if state["status"] == FINISHED else ():
        if list(found.get(name, (0, ""))) != extent:
            raise ArchiveError(
                f"'{directory / name}' is not what the run wrote (its SHA-256 is not that of run.json); restore it"
            )

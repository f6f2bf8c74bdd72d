"""Where a run goes on: the newest checkpoint that has all it needs, and the files cut back to it."""

from __future__ import annotations

import shlex
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from workflow.errors import ArchiveError
from workflow.runs.checkpoint import Checkpoint, confirmed, damaged, drop_later, extent, newest, notes, seal_of, whole
from workflow.runs.outputs import Extent, Parts


@dataclass(frozen=True)
class Start:
    """Where a run goes on: its checkpoint (None: at the beginning), the files as far as they belong to it, and what was found
    to be damaged, in words."""

    checkpoint: Checkpoint | None
    parts: Parts
    words: list[str]

    def cut_back(self) -> None:
        """Drop what lies beyond: checkpoints of a course that ends here, rows and frames.  The resumed run writes it again."""
        drop_later(self.parts.folder, self.checkpoint)
        self.parts.cut()


def start_of(folder: Path) -> Start:
    """The newest checkpoint that is what its seal says and whose rows and frames are what it says, else an older one.

    Without any seal (a deck that was run by hand, or before its first seal), the newest whole checkpoint, and of the parts
    only their form is checked.  Raises ArchiveError if there are seals and no checkpoint has all it needs, or without seals
    if a part is damaged.
    """
    words = [f"{path.name} is damaged (its checksum or its end is wrong) and not used" for path in damaged(folder)]
    sealed = [one for one in whole(folder) if confirmed(one.path)]
    if not sealed:
        return _unsealed(folder, words)
    good, wrong = None, ""
    reader = Parts(folder)
    for one in sorted(sealed, key=lambda c: (c.step, c.stage)):
        unlike = _unlike(reader, one)
        if not unlike:
            good = one
        else:
            wrong = unlike
            words.append(f"{one.path.name} is not used: {unlike}")
    if good is None:
        raise ArchiveError(f"'{folder}' cannot go on: {wrong}, and no older checkpoint is left; restore the file from a copy, "
                           f"or begin again with 'wf resume {shlex.quote(str(folder))} --anew'")  # fmt: skip
    if "parts" not in seal_of(good.path):
        words.append(f"{good.path.name} does not say what the time series and the dumps held; only their form is checked")
    parts = Parts(folder)
    _read_on(parts, good.step)
    return Start(good, parts, words)


def _unsealed(folder: Path, words: list[str]) -> Start:
    """The start without any seal."""
    checkpoint, parts = newest(folder), Parts(folder)
    if checkpoint is not None:
        try:
            parts.sealable(checkpoint.step)
        except ArchiveError as fault:
            raise ArchiveError(f"{fault}. No sealed checkpoint is left: restore the file from a copy, or begin again with "
                               f"'wf resume {shlex.quote(str(folder))} --anew'") from None  # fmt: skip
        words.append(f"{checkpoint.path.name} has no seal: of the time series and the dumps only the form is checked")
    return Start(checkpoint, parts, words)


def _unlike(parts: Parts, one: Checkpoint) -> str:
    """Which part of the run is not what the seal of a checkpoint says, in words; "" if all are."""
    sealed = seal_of(one.path).get("parts")
    if sealed is None:  # of a version that did not seal them
        try:
            parts.sealable(one.step)
        except ArchiveError as fault:
            return str(fault)
        return ""
    found = _read_on(parts, one.step) | {name: extent(parts.folder / name) for name in notes(parts.folder, one.stage)}
    for name, held in sealed.items():
        if list(found.get(name, (0, ""))) != held:
            return f"'{parts.folder / name}' is not what it was when the checkpoint was written (its first {held[0]} bytes)"
    return ""


def _read_on(parts: Parts, step: int) -> dict[str, Extent]:
    """The extents up to ``step``, of damaged parts those before the damage: what lies beyond a seal is dropped."""
    for part in parts:
        with suppress(ArchiveError):
            part.read_to(step)
    return {part.path.name: part.extent for part in parts}

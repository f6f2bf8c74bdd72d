"""Several dumps: steps of one sample, or several samples, each with its contacts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workflow.analysis.frame import Floats
from workflow.archive.columns import GRAINS, Reading, resolve
from workflow.archive.foreign import Sample
from workflow.archive.snapshots import Dump
from workflow.errors import InputError


@dataclass(frozen=True)
class Files:
    """The dumps of one sample, grains and contacts, and what is to be said of how they were put together."""

    grains: tuple[Path, ...]
    contacts: tuple[Path, ...] = ()
    notes: tuple[str, ...] = ()

    def sample(self, reading: Reading) -> Sample:
        """Ready to be read."""
        found = Sample(self.grains, self.contacts, reading)
        found.notes[:0] = self.notes
        return found


def gathered(grains: Sequence[Path], contacts: Sequence[Path], reading: Reading, *, apart: bool) -> Iterator[Files]:
    """The samples among ``grains``, each with its ``contacts``; ``apart``: every file is one.

    Files are steps of one sample if no two have a step in common and a grain has one diameter in all of them.  Of
    several samples each has one file of contacts, in the same order, or all have the same one.  Raises InputError.
    """
    if not grains:
        return
    if len(grains) == 1 or (not apart and _one_sample(grains, reading)):
        note = (
            f"{len(grains)} dumps are taken as steps of one sample: their steps differ, their grains do not (else: --samples)"
        )
        yield Files(tuple(grains), tuple(contacts), (note,) if len(grains) > 1 else ())
        return
    if len(contacts) not in (0, 1, len(grains)):
        raise InputError(
            f"{len(grains)} samples and {len(contacts)} files of contacts: give one for each sample, in the same order"
        )
    for number, path in enumerate(grains):
        yield Files((path,), tuple(contacts[number : number + 1] if len(contacts) > 1 else contacts))


def _one_sample(paths: Sequence[Path], reading: Reading) -> bool:
    """Whether the files are steps of one sample."""
    steps: set[int] = set()
    known: dict[float, float] = {}
    for path in paths:
        dump = Dump([path])
        if steps & set(dump.snapshots):
            return False
        steps |= set(dump.snapshots)
        ids, sizes = _sizes(dump, reading)
        if any(
            not np.isclose(known.get(grain, size), size, rtol=1e-5)
            for grain, size in zip(ids.tolist(), sizes.tolist(), strict=True)
        ):
            return False
        known |= dict(zip(ids.tolist(), sizes.tolist(), strict=True))
    return True


def _sizes(dump: Dump, reading: Reading) -> tuple[Floats, Floats]:
    """Ids and sizes of the grains of the first snapshot; 1 where they have none."""
    block = next(iter(dump.snapshots.values()))
    found = resolve(block, GRAINS, reading.names)
    names = [found[name] for name in ("id", "diameter", "radius") if name in found][:2]
    if "id" not in found:
        return np.empty(0), np.empty(0)
    columns = dump.table(block, names)
    return columns[names[0]], columns[names[1]] if len(names) > 1 else np.ones(block.rows)

"""Several dumps: steps of one sample, or several samples, each with its contacts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workflow.archive.columns import GRAINS, Reading, resolve
from workflow.archive.dump_tables import Dump
from workflow.archive.foreign import Sample
from workflow.data.frame import Floats
from workflow.errors import InputError

Sizes = tuple[Floats, Floats]


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
    several samples each file of grains has its file of contacts, or each sample, in the same order, or all share one.
    Raises InputError.
    """
    each = [[number] for number in range(len(grains))]
    samples = each if apart or len(grains) < 2 else _samples(grains, reading)
    if len(samples) > 1 and len(contacts) not in (0, 1, len(grains), len(samples)):
        raise InputError(
            f"{len(samples)} samples in {len(grains)} files of grains, and {len(contacts)} files of contacts: give one for "
            "each, in the same order"
        )
    for number, members in enumerate(samples):
        tables = list(contacts)
        if len(samples) > 1 and len(contacts) > 1:
            tables = [contacts[k] for k in (members if len(contacts) == len(grains) else [number])]
        note = (
            f"{len(members)} dumps are taken as steps of one sample: their steps differ, their grains do not (else: --samples)"
        )
        yield Files(tuple(grains[k] for k in members), tuple(tables), (note,) if len(members) > 1 else ())


def _samples(paths: Sequence[Path], reading: Reading) -> list[list[int]]:
    """Numbers of the files of each sample."""
    found: list[tuple[list[int], set[int], Sizes]] = []
    for number, path in enumerate(paths):
        dump = Dump([path])
        steps, sizes = set(dump.snapshots), _sizes(dump, reading)
        place = next((k for k, (_, taken, known) in enumerate(found) if not steps & taken and _agree(known, sizes)), None)
        if place is None:
            found.append(([number], steps, sizes))
        else:
            members, taken, known = found[place]
            found[place] = ([*members, number], taken | steps, _united(known, sizes))
    return [members for members, _, _ in found]


def _sizes(dump: Dump, reading: Reading) -> Sizes:
    """Ids and sizes of the grains of the first snapshot; sizes are 1 where they are not given."""
    block = next(iter(dump.snapshots.values()))
    found = resolve(block, GRAINS, reading.names)
    if "id" not in found:
        return np.empty(0), np.empty(0)
    size = next((found[name] for name in ("diameter", "radius") if name in found), None)
    columns = dump.table(block, [found["id"]] + ([size] if size else []))
    return columns[found["id"]], columns[size] if size else np.ones(block.rows)


def _agree(one: Sizes, two: Sizes) -> bool:
    """Whether the grains of both have the same sizes."""
    _, first, second = np.intersect1d(one[0], two[0], return_indices=True)
    return bool(np.allclose(one[1][first], two[1][second], rtol=1e-5, atol=0.0))


def _united(one: Sizes, two: Sizes) -> Sizes:
    new = ~np.isin(two[0], one[0])
    return np.concatenate((one[0], two[0][new])), np.concatenate((one[1], two[1][new]))

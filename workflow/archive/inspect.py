"""What a dump holds, and as what `wf measure` reads it."""

from __future__ import annotations

from pathlib import Path

from workflow.archive.columns import CONTACT_HELP, CONTACTS, GRAINS, Reading, contact_names, resolve
from workflow.archive.dump_tables import Dump
from workflow.archive.formats import unpacked
from workflow.archive.snapshots import Snapshot


def columns_of(path: Path, reading: Reading) -> str:
    """The snapshots, the box and the columns of a dump with what each is read as.  Raises InputError, ArchiveError."""
    dump = Dump([path])
    file, packed = unpacked(path)
    file.close()
    block = list(dump.snapshots.values())[-1]
    grains, steps = block.label == "ATOMS", list(dump.snapshots)
    found = resolve(block, GRAINS, reading.names) if grains else contact_names(block, reading.names, reading.liggghts)
    meanings = GRAINS if grains else CONTACTS
    roles = {column: f"{name}: {meanings.get(name, '')}" for name, column in found.items()}
    head = [
        f"{path}: {'grains' if grains else 'contacts'} ({block.label}), text{f' packed with {packed}' * bool(packed)}",
        f"snapshots: {len(steps)}, step {steps[0]}{f' to {steps[-1]}' * (len(steps) > 1)}; the last has {block.rows} rows",
        f"box: {_box(block)}",
    ]
    width = max(map(len, block.columns), default=0) + 2
    rows = [f"  {column:{width}s}{roles.get(column, '-')}" for column in block.columns]
    missing = [name for name in (("id",) if grains else ("id_i", "id_j")) if name not in found]
    if missing:
        rows.append(f"missing: {' '.join(missing)}" + ("" if grains else f"; {CONTACT_HELP}"))
    return "\n".join(
        [*head, "columns and what they are read as (- : not read):", *rows, *(f"note: {note}" for note in dump.notes)]
    )


def _box(block: Snapshot) -> str:
    sides = " x ".join(f"{high - low:.6g}" for low, high in block.bounds[:2])
    return f"{sides}, faces {block.flags or 'not given, taken as periodic'}"

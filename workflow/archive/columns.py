"""Which column of a dump is what: the names used here, those that the user gives, and the numbered columns of LIGGGHTS."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from workflow.archive.dumps import CONTACT_COLUMNS, NUMBERED, numbered_contacts
from workflow.archive.snapshots import Snapshot
from workflow.errors import ArchiveError, InputError
from workflow.scene.parameter import unknown_name

# the four forms of a coordinate in LAMMPS: in the box, in shares of the box, and both unwrapped
FORMS = ("", "s", "u", "su")
GRAINS: dict[str, str] = {
    "id": "number of the grain",
    **{axis + form: f"coordinate {axis}{words}" for axis in "xyz" for form, words in zip(
        FORMS, ("", " in shares of the box", ", unwrapped", " in shares of the box, unwrapped"), strict=True)},
    "diameter": "diameter", "radius": "radius", "mass": "mass", "vx": "velocity", "vy": "velocity",
    "omegaz": "angular velocity", "fx": "sum of the forces on the grain", "fy": "sum of the forces on the grain",
    "tqz": "sum of the moments on the grain",
}  # fmt: skip
CONTACTS: dict[str, str] = {
    "id_i": "grain i", "id_j": "grain j", "bx": "vector from i to j", "by": "vector from i to j", "gap": "gap, < 0 in contact",
    "overlap": "minus the gap", "normal": "normal force N, repulsion positive", "elastic": "elastic part of N",
    "viscous": "viscous part of N", "attraction": "attractive part of N", "tangential": "tangential force T",
    "fx": "force on i", "fy": "force on i", "fz": "force on i", "tx": "tangential force on i, to be added to fx fy",
    "ty": "tangential force on i, to be added to fx fy", "moment": "rolling moment of i on j",
    "du": "elastic tangential displacement", "dtheta": "elastic rotation", "sliding": "1 where the Coulomb limit is reached",
    "rolling": "1 where the rolling limit is reached",
}  # fmt: skip
CONTACT_HELP = (
    "name the columns with dump_modify colname, --columns NAME=COLUMN or --liggghts; needed: id_i id_j; used: bx by "
    "(branch), gap (or overlap), normal (or elastic viscous attraction), tangential, moment, sliding, rolling, or fx fy "
    "(force on id_i) and tx ty (its tangential part where fx fy lacks it, as in compute pair/local)"
)
# what others call a column whose meaning leaves no doubt
ALIASES = {"id1": "id_i", "id2": "id_j", "patom1": "id_i", "patom2": "id_j", "delta": "overlap"}
# keywords of compute pair/gran/local of LIGGGHTS with the number of their columns, in the order in which it writes them
# whatever the order in which they are given; history takes what is left, heatFlux comes last
LIGGGHTS = {"pos": 6, "vel": 6, "id": 3, "force": 3, "force_normal": 3, "force_tangential": 3, "torque": 3, "torque_normal": 3,
            "torque_tangential": 3, "history": 0, "contactArea": 1, "delta": 1, "contactPoint": 3, "ms_id": 2,
            "heatFlux": 1}  # fmt: skip
LIGGGHTS_DEFAULT = ("pos", "vel", "id", "force", "torque", "history", "contactArea")

Names = Mapping[str, str]


@dataclass(frozen=True)
class Reading:
    """What the user says of the files: ``names`` {name here: column}, ``liggghts``: keywords of its compute pair/gran/local
    (empty: the default ones, None: another program's table), and of the law: ``friction`` mu (None: unknown), ``attraction``
    F0, ``rolling``: contacts resist rolling.  ``complete``: a table
    that lacks pairs of overlapping discs is refused, else they are said.

    With mu a contact without flags slides where |T| >= mu (N + F0) (1 - 1e-3).
    """

    names: Mapping[str, str] = field(default_factory=dict)
    liggghts: Sequence[str] | None = None
    friction: float | None = None
    attraction: float = 0.0
    rolling: bool = False
    complete: bool = False


def check_names(names: Names, *blocks: Snapshot | None) -> None:
    """Every name that the user gives is one of ours and every column is in a file.  Raises InputError that lists both."""
    for name, column in names.items():
        if name not in GRAINS and name not in CONTACTS:
            raise unknown_name(name, {*GRAINS, *CONTACTS}, "name in --columns")
        holders = [
            block for block, known in zip(blocks, (GRAINS, CONTACTS), strict=False) if block is not None and name in known
        ]
        if not any(column in block.columns for block in holders):
            lists = "; ".join(f"{block.path} has {' '.join(block.columns)}" for block in holders) or "no file for it is given"
            raise InputError(f"--columns {name}={column}: there is no column '{column}'; {lists}")


def resolve(block: Snapshot, vocabulary: Iterable[str], names: Names) -> dict[str, str]:
    """{name here: column of the file}.  What the user names counts; such a column is nothing else besides."""
    vocabulary = set(vocabulary)
    given = {name: column for name, column in names.items() if name in vocabulary and column in block.columns}
    found = {column: column for column in block.columns if column in vocabulary and column not in given.values()} | given
    for name, column in found.items():
        if block.columns.count(column) > 1:
            raise ArchiveError(f"{block.where}: column '{column}' ({name}) is there {block.columns.count(column)} times; "
                               "leave one in the dump command")  # fmt: skip
    return found


def is_own(columns: Iterable[str]) -> bool:
    """A contact table of this package carries all its names."""
    return set(CONTACT_COLUMNS) <= set(columns)


def contact_names(block: Snapshot, names: Names, keywords: Sequence[str] | None) -> dict[str, str]:
    """`resolve` for a contact table, with the numbered columns of LIGGGHTS and of this package's old runs."""
    numbered = liggghts_columns(block, keywords) if keywords is not None else _of_old_run(block)
    others = {name: alias for alias, name in ALIASES.items() if alias in block.columns and name not in block.columns}
    return resolve(block, [*CONTACTS, "state"], {**others, **numbered, **names})


def _of_old_run(block: Snapshot) -> dict[str, str]:
    """Names for the 15 numbered columns of contacts.dump of a run directory of version 0.2; else none."""
    named = numbered_contacts(block.columns)
    return named if named and named["id_i"] == "c_pairs[1]" and _of_run(Path(block.path)) else {}


def _of_run(path: Path) -> bool:
    """Whether a file is the contact dump of a run directory of this package."""
    record = path.parent / "run.json"
    if path.name != "contacts.dump" or not record.is_file():
        return False
    with open(record, "rb") as file:
        return b'"digest"' in file.read(1 << 20)


def liggghts_columns(block: Snapshot, keywords: Sequence[str]) -> dict[str, str]:
    """Names for the columns that a ``compute pair/gran/local`` of LIGGGHTS with ``keywords`` writes (none: its default).

    ``force`` is the whole force on i; ``force_normal`` and ``force_tangential`` are used where it is missing.
    """
    keywords = tuple(keywords) or LIGGGHTS_DEFAULT
    for word in keywords:
        if word not in LIGGGHTS:
            raise unknown_name(word, LIGGGHTS, "keyword of pair/gran/local in --liggghts")
    matches = [match for match in map(NUMBERED.fullmatch, block.columns) if match]
    computes = sorted({match[1] for match in matches})
    if len(computes) != 1:
        raise InputError(f"{block.where}: --liggghts needs the numbered columns of one compute, c_ID[1] c_ID[2] ...; there "
                         f"are {' '.join(block.columns)}; use --columns")  # fmt: skip
    written = [int(match[2]) for match in matches]
    total, all_of_them = max(written), written == list(range(1, len(written) + 1))
    places, at = {}, 1
    for word, width in LIGGGHTS.items():
        if word in keywords:
            places[word] = at
            at += width
    history = total - at + 1 if all_of_them else 0  # of a choice of columns, those up to history have their numbers
    if history < 0 or (total >= at and "history" not in keywords):
        raise InputError(
            f"{block.where}: pair/gran/local with {' '.join(keywords)} writes {at - 1} "
            f"columns{' and its history' * ('history' in keywords)}, the file has {total}; give the keywords of the input "
            "script"
        )
    after = list(LIGGGHTS)[list(LIGGGHTS).index("history") + 1 :]
    known = all_of_them or "history" not in keywords
    places = {word: place + history * (word in after) for word, place in places.items() if known or word not in after}
    return {
        name: f"{computes[0]}[{place}]"
        for name, place in _meaning(places).items()
        if f"{computes[0]}[{place}]" in block.columns
    }


def _meaning(places: Mapping[str, int]) -> dict[str, int]:
    if "id" not in places:
        raise InputError("--liggghts: without the keyword id nobody knows the grains of a contact; write the dump with id")
    found = {"id_i": places["id"], "id_j": places["id"] + 1}
    if "force" in places:
        found |= {f"f{axis}": places["force"] + k for k, axis in enumerate("xyz")}
    elif "force_normal" in places:
        found |= {f"f{axis}": places["force_normal"] + k for k, axis in enumerate("xyz")}
        if "force_tangential" in places:
            found |= {f"t{axis}": places["force_tangential"] + k for k, axis in enumerate("xy")}
    return found | ({"overlap": places["delta"]} if "delta" in places else {})

"""Scene -> deck and data file, as text.  Pure functions: no engine, nothing written.

A template of ``lammps_inputs/`` is itself a runnable deck with ``variable NAME index DEFAULT`` lines at the top; rendering
puts the files it includes in their places, replaces defaults by the scene's values and nothing else, so what Python runs,
what ``lmp -in`` runs and what a cluster job runs is the same deck.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from workflow.data.discs import Discs
from workflow.errors import InputError
from workflow.scene.base import Scene

DECK = "deck.in"
DATA = "grains.data"
LEFT_TO_THE_COMMAND_LINE = {"resume", "restart", "stage"}  # where to start: defaults mean from the beginning
ROWS = 65536  # of a table that are text or Python objects at one time
# a file of a folder, or one that a variable names; what a run wrote for itself (stage.1.in) lies beside its deck and is left
_INCLUDE = r"^include\s+(?:(?P<file>\w+/\S+)|\$\{(?P<of>\w+)\})[^\S\n]*(?:#.*)?$"
_NAMED = (
    r"^variable\s+(?P<variable>\w+)\s+string\s+(?P<value>common/\S+)$"  # a deck file that the next ``include ${NAME}`` takes
)
_PART = re.compile(f"{_INCLUDE}|{_NAMED}", re.MULTILINE)
_VARIABLE = re.compile(r"^variable(\s+)(\w+)(\s+)index(\s+)(\S+)[^\S\n]*$", re.MULTILINE)


def templates() -> Path:
    """The folder of deck templates: inside the installed package, or beside it in a checkout."""
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "lammps_inputs", package.parent / "lammps_inputs"):
        if folder.is_dir():
            return folder
    raise InputError(f"deck templates not found beside {package}; install the package again: pip install .")


def render(scene: Scene) -> str:
    """The deck of ``scene``.  Raises InputError if template and scene disagree on a variable."""
    template = templates() / (scene.template or f"{scene.name}.in")
    values = {**scene.variables(), "data": DATA}
    return fill(whole(template, values), values)


def whole(path: Path, values: Mapping[str, object] | None = None) -> str:
    """The template with the files it includes, and those that these include, put in their places: a run directory needs no
    other file.  ``include ${NAME}`` takes the file that ``values``, or the template's default, give to NAME, such as `law`,
    or that the last ``variable NAME string common/FILE.in`` before it names.  Files lie beside the template, or in the
    package.  Raises InputError if one cannot be read."""
    text = _read(path)
    named = {match[2]: match[5] for match in reversed(list(_VARIABLE.finditer(text)))} | dict(values or {})

    def put(match: re.Match[str]) -> str:
        if match["variable"]:
            named[match["variable"]] = match["value"]
            return match[0]
        name = match["file"] or named.get(match["of"])
        if not name:
            raise InputError(
                f"deck template '{path}' includes ${{{match['of']}}} and has no such variable; declare it in its head"
            )
        return _PART.sub(put, _read(path.parent / str(name), templates() / str(name)))

    return _PART.sub(put, text) + "\n"


def copy_template(name: str, folder: Path) -> None:
    """Write the template ``name``, whole, to ``folder``, where its variables can be given on the command line."""
    (folder / name).write_text(whole(templates() / name), encoding="utf-8")


def _read(*places: Path) -> str:
    """The text of the first of these files that exists, without its last line feeds."""
    try:
        return next(file for file in places if file.is_file()).read_text(encoding="utf-8").rstrip("\n")
    except (StopIteration, OSError, ValueError):
        raise InputError(f"deck template '{places[0]}' cannot be read; give a text file") from None


def fill(template: str, values: dict[str, str | int | float]) -> str:
    """``template`` with the values of its index variables replaced; floats keep their last bit."""
    declared = {match[2] for match in _VARIABLE.finditer(template)}
    missing = declared - set(values) - LEFT_TO_THE_COMMAND_LINE
    unused = set(values) - declared
    if missing or unused:
        raise InputError(
            f"deck template and scene disagree: no value for {sorted(missing)}, no variable for {sorted(unused)}; "
            "declare each once in both"
        )

    def put(match: re.Match[str]) -> str:
        value = values.get(match[2], match[5])
        text = repr(value) if isinstance(value, float) else str(value)
        if not re.fullmatch(r"[\w.+/-]+", text):
            raise InputError(f"deck variable '{match[2]}' = {text!r} is not a plain word or number; rename the file it names")
        return f"variable{match[1]}{match[2]}{match[3]}index{match[4]}{text}"

    return _VARIABLE.sub(put, template)


def data_file(discs: Discs) -> str:
    """The discs as a LAMMPS data file (atom_style sphere); masses are set in the deck (m = d^2/a^2).

    Raises InputError if two centres coincide: such a pair has no direction to repel along.
    """
    return "".join(data_parts(discs))


def data_parts(discs: Discs) -> Iterator[str]:
    """`data_file` in parts of ROWS grains, so that a file of any size is written without being in memory."""
    places, counts = np.unique(np.mod(discs.position, discs.cell), axis=0, return_counts=True)
    if counts.max(initial=0) > 1:
        x, y = places[counts.argmax()]
        raise InputError(f"{counts.max()} grains have one centre, ({x:g}, {y:g}) a; move them apart")
    width, height = discs.cell.tolist()
    yield (
        f"discs in a periodic cell\n\n{len(discs.diameter)} atoms\n1 atom types\n\n"
        f"0 {width!r} xlo xhi\n0 {height!r} ylo yhi\n-0.5 0.5 zlo zhi\n\nAtoms # sphere\n\n"
    )
    starts = range(0, len(discs.diameter), ROWS)
    for k in starts:
        rows = zip(discs.diameter[k : k + ROWS].tolist(), discs.position[k : k + ROWS].tolist(), strict=True)
        yield "".join(f"{number} 1 {d!r} 1.0 {x!r} {y!r} 0\n" for number, (d, (x, y)) in enumerate(rows, k + 1))
    if discs.velocity is None:
        return
    yield "\nVelocities\n\n"
    for k in starts:
        moving = enumerate(discs.velocity[k : k + ROWS].tolist(), k + 1)
        yield "".join(f"{number} {u!r} {v!r} 0 0 0 0\n" for number, (u, v) in moving)

"""The rooms of the package stand on floors in the order of the flow: a module imports from its own floor or one below."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import workflow

PACKAGE = Path(workflow.__file__).parent
FLOORS = (
    {"errors"}, {"data"}, {"reference"}, {"scene"}, {"deck"}, {"runs"}, {"archive"}, {"measures"}, {"pipeline"}, {"reports"},
    {"campaign"}, {"verification", "reproduce"}, {"api", "cli"},
)  # fmt: skip
FLOOR = {room: number for number, rooms in enumerate(FLOORS) for room in rooms}
APART = ({"verification", "reproduce"}, {"api", "cli"})  # rooms of one floor that do not know each other


def rooms_imported(path: Path) -> Iterator[tuple[int, str]]:
    """(line, room) of every import of the package, wherever it stands in the file."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module == "workflow":
            yield from ((node.lineno, name.name) for name in node.names if name.name in FLOOR)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("workflow."):
            yield node.lineno, str(node.module).split(".")[1]
        elif isinstance(node, ast.Import):
            yield from ((node.lineno, name.name.split(".")[1]) for name in node.names if name.name.startswith("workflow."))


def test_every_module_stands_in_a_room() -> None:
    rooms = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    files = {path.stem for path in PACKAGE.glob("*.py")}
    assert rooms | files - {"__init__"} == set(FLOOR)


def test_imports_lead_down_only() -> None:
    broken = []
    for path in sorted(PACKAGE.rglob("*.py")):
        here = path.relative_to(PACKAGE)
        room = here.parts[0].removesuffix(".py")
        if room not in FLOOR:  # the public names; decks of other programs
            continue
        for line, other in rooms_imported(path):
            apart = any({room, other} <= rooms and room != other for rooms in APART)
            if FLOOR[other] > FLOOR[room] or apart:
                broken.append(f"{here}:{line} imports from {other}")
    assert broken == []


def test_page_names_the_imports_of_every_room() -> None:
    page = (Path(__file__).parents[2] / "ARCHITECTURE.md").read_text(encoding="utf-8")
    stated = dict(re.findall(r"^\| `(\w+)` \| [^|]+ \|([^|]*)\|$", page, re.MULTILINE))
    found = {room: set() for room in FLOOR}
    for path in PACKAGE.rglob("*.py"):
        room = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        if room in FLOOR:
            found[room] |= {other for _, other in rooms_imported(path) if other != room}
    assert {room: set(re.findall(r"\w+", rooms)) for room, rooms in stated.items()} == found

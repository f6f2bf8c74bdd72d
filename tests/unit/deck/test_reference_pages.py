"""The reference pages against what they describe: every deck, variable, style and keyword is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
DECKS = sorted((ROOT / "lammps_inputs").glob("*.in"))
DECK_PAGE = (ROOT / "lammps_inputs" / "README.md").read_text(encoding="utf-8")
PLUGIN_PAGE = (ROOT / "docs" / "plugin.md").read_text(encoding="utf-8")
# the comment above a class that says how it is used in a deck: kind, name, all of it
_USAGE = re.compile(r"/\* ((pair_style|fix|run_style) (?:ID \S+ )?(disc/\w+|verlet/disc).*?)\n\n", re.DOTALL)
USAGES = {
    header.stem: (found[2], found[3], found[1])
    for header in (ROOT / "plugins").glob("*.h")
    if (found := _USAGE.search(header.read_text(encoding="utf-8")))
}
SECTIONS = dict(re.findall(r"^## (\w+ \S+)\n(.*?)(?=^## |\Z)", PLUGIN_PAGE, re.MULTILINE | re.DOTALL))


# the section of each deck; its variables are named there or, where it says so, above
DECK_SECTIONS = dict(re.findall(r"^## (\S+\.in)\n(.*?)(?=^## |\Z)", DECK_PAGE, re.MULTILINE | re.DOTALL))
INHERITS = {"method2.in": "method1.in"}  # whose rows count where a deck has no row of its own


def declared(deck: str) -> dict[str, str]:
    """Index variables of a deck and their defaults; the first of a name counts, as for LAMMPS."""
    text = (ROOT / "lammps_inputs" / deck).read_text(encoding="utf-8")
    return dict(reversed(re.findall(r"^variable\s+(\w+)\s+index\s+(\S+)", text, re.MULTILINE)))


def tabled(deck: str) -> dict[str, str]:
    """{variable: default} of the table in the section of a deck."""
    found: dict[str, str] = {}
    for row in re.findall(r"^\| (`.*) \|$", DECK_SECTIONS[deck], re.MULTILINE):
        cells = [cell.strip() for cell in row.split("|")]
        names, defaults = re.findall(r"`(\w+)`", cells[0]), [word.strip().strip("`") for word in cells[-1].split(",")]
        defaults = defaults * len(names) if len(defaults) == 1 else defaults
        found |= dict(zip(names, defaults, strict=True))
    return found


@pytest.mark.parametrize("deck", DECKS, ids=lambda path: path.name)
def test_every_variable_of_a_deck_is_in_its_section(deck: Path) -> None:
    """And no section names a variable in its table that the deck has not."""
    page = DECK_SECTIONS[deck.name] + DECK_SECTIONS.get(INHERITS.get(deck.name, ""), "")
    assert f"`{deck.name}`" in DECK_PAGE
    assert not set(declared(deck.name)) - set(re.findall(r"`(\w+)`", page))


@pytest.mark.parametrize("deck", ["method1.in", "method2.in", "heap.in"])
def test_defaults_in_the_table_of_a_deck_are_those_of_the_deck(deck: str) -> None:
    """Words and numbers; method2.in has the defaults of method1.in where its own table gives none."""
    values, table = declared(deck), tabled(deck)
    rows = (tabled(INHERITS[deck]) if deck in INHERITS else {}) | table
    assert set(values) <= set(rows) and not set(table) - set(values)
    for name, value in values.items():
        try:
            assert float(value) == float(rows[name]), name
        except ValueError:
            assert value == rows[name], name


def test_every_file_that_decks_include_is_listed() -> None:
    for file in (ROOT / "lammps_inputs" / "common").glob("*.in"):
        assert f"`common/{file.name}`" in DECK_PAGE, file.name
    for file in (ROOT / "lammps_inputs" / "method2").glob("*.in"):
        assert f"`{file.name}`" in DECK_SECTIONS["method2.in"] or file.name in ("setup.in", "resume.in"), file.name


@pytest.mark.parametrize("folder", ["method1", "method2"])
def test_every_stage_says_in_three_lines_what_happens_what_ends_it_and_why(folder: str) -> None:
    files = [path for path in (ROOT / "lammps_inputs" / folder).glob("*.in") if path.name not in ("setup.in", "resume.in")]
    assert files
    for file in files:
        head = file.read_text(encoding="utf-8").splitlines()[:4]
        assert re.match(r"# Stages? \d", head[0]) and head[1].startswith("# It ends ") and head[2].startswith("# "), file.name
        assert head[3].startswith('if "${stage} != '), file.name


@pytest.mark.parametrize("source", sorted(USAGES))
def test_every_style_has_its_section_with_all_its_keywords(source: str) -> None:
    kind, name, usage = USAGES[source]
    section = SECTIONS[f"{kind} {name}"]
    for keyword in re.findall(r"\[(\w+)", usage):
        assert re.search(rf"\b{keyword}\b", section), keyword
    for part in ("```", "Example", "**Restrictions.**", "**Default.**"):
        assert part in section, part


def test_every_registered_style_has_a_section() -> None:
    text = (ROOT / "plugins" / "plugin.cpp").read_text()
    styles = set(re.findall(r'"(disc/\w+|verlet/disc)"', text))
    assert styles == {name.split()[1] for name in SECTIONS}

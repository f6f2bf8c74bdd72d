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


@pytest.mark.parametrize("deck", DECKS, ids=lambda path: path.name)
def test_every_variable_of_a_deck_is_described(deck: Path) -> None:
    assert f"`{deck.name}`" in DECK_PAGE
    named = set(re.findall(r"`(\w+)`", DECK_PAGE))
    assert set(re.findall(r"^variable\s+(\w+)\s+index", deck.read_text(), re.MULTILINE)) <= named


def test_defaults_in_the_table_of_method1_are_those_of_the_deck() -> None:
    """Rows with as many defaults as names; words and numbers."""
    text = (ROOT / "lammps_inputs" / "method1.in").read_text()
    deck = dict(reversed(re.findall(r"^variable\s+(\w+)\s+index\s+(\S+)", text, re.MULTILINE)))  # the first of a name
    table = DECK_PAGE[DECK_PAGE.index("## method1.in") : DECK_PAGE.index("## method2.in")]
    compared = 0
    for row in re.findall(r"^\| (`.*) \|$", table, re.MULTILINE):
        cells = [cell.strip() for cell in row.split("|")]
        names, defaults = re.findall(r"`(\w+)`", cells[0]), [word.strip().strip("`") for word in cells[-1].split(",")]
        if len(defaults) == 1:
            defaults *= len(names)
        for name, default in zip(names, defaults, strict=True):
            compared += 1
            try:
                assert float(deck[name]) == float(default), name
            except ValueError:
                assert deck[name] == default, name
    assert compared == len(deck)


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

"""The keywords that a style reads, those of the syntax in its header and those of docs/plugin.md are the same."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PLUGINS = ROOT / "plugins"
# style -> stem of its source, stem of the base class that reads further keywords
STYLES = {
    "disc/cohesive": ("pair_disc_cohesive", "pair_disc"),
    "disc/continuous": ("pair_disc_continuous", "pair_disc"),
    "disc/tail": ("pair_disc_tail", None),
    "disc/integrate": ("fix_disc_integrate", None),
    "disc/equilibrium": ("fix_disc_equilibrium", None),
    "disc/feed": ("fix_disc_feed", None),
    "disc/stiffen": ("fix_disc_stiffen", None),
}
# an entry of a table of keywords.h, or of a list of coefficients
ENTRY = re.compile(r'\b(?:number|integer|logical)\("(\w+)"|\{"(\w+)",\s*(?:\d|&law\.)')
COMMAND = re.compile(
    r"^(?:/\* |   )?(?:pair_style (?P<pair>disc/\w+)|pair_coeff \* \*|fix ID \w+ (?P<fix>disc/\w+)(?: N)?(?: FILE)?(?: factor time)?)"
    r"(?P<words>.*(?:\n +\[.*)*)$",
    re.MULTILINE,
)


def read_by(style: str) -> set[str]:
    """Keywords in the tables of the source files of a style."""
    found = set()
    for stem in STYLES[style]:
        if stem:
            found |= {first or second for first, second in ENTRY.findall((PLUGINS / f"{stem}.cpp").read_text())}
    return found


def stated_in(text: str) -> set[str]:
    """Keywords of the commands in a syntax table: the first word in brackets, every other word outside them."""
    found = set()
    for command in COMMAND.finditer(text):
        words = command["words"]
        found |= set(re.findall(r"\[(\w+)", words)) | set(re.sub(r"\[.*?\]", "", words, flags=re.DOTALL).split()[::2])
    return found


def header(style: str) -> str:
    """The comment before the class of a style."""
    text = (PLUGINS / f"{STYLES[style][0]}.h").read_text().split("namespace LAMMPS_NS", 1)[1]
    return text[text.index("/* ") : text.index("\nclass ")]


def page(style: str) -> str:
    """The first block of code of the section of a style."""
    section = re.split(r"^## ", (ROOT / "docs" / "plugin.md").read_text(), flags=re.MULTILINE)
    (text,) = [one for one in section if one.split("\n")[0].endswith(f" {style}")]
    return text.split("```")[1]


@pytest.mark.parametrize("style", STYLES)
def test_the_header_states_the_keywords_that_the_style_reads(style: str) -> None:
    assert stated_in(header(style)) == read_by(style)


@pytest.mark.parametrize("style", STYLES)
def test_the_page_states_the_keywords_that_the_style_reads(style: str) -> None:
    assert stated_in(page(style)) == read_by(style)


def test_keywords_are_found_at_all() -> None:
    """The checks above compare sets that are not empty, but for the ramp, whose arguments are positions."""
    assert {style for style in STYLES if not read_by(style)} == {"disc/stiffen"}
    assert len(read_by("disc/cohesive")) == 12 and len(read_by("disc/integrate")) == 10


@pytest.mark.parametrize("wrong", ["[mass m] [speed u]", "", "[mass]\n        [rate r]"])
def test_a_keyword_too_many_or_too_few_is_seen(wrong: str) -> None:
    right = stated_in("fix ID all disc/integrate [mass m]\n           [rate r] [stress S_x S_y]")
    assert right == {"mass", "rate", "stress"} and stated_in(f"fix ID all disc/integrate {wrong}") != right

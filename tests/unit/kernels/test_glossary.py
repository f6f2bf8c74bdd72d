"""The retired words of docs/glossary.md are no names in the plugin, and every kernel points to the glossary."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SOURCES = sorted(
    file
    for folder in ("plugins", "examples/08_new_law")
    for file in (ROOT / folder).rglob("*")
    if file.suffix in (".h", ".cpp")
)
NO_CODE = re.compile(r"/\*.*?\*/|//[^\n]*|\"(?:\\.|[^\"\\])*\"", re.DOTALL)  # comments and strings


def retired() -> set[str]:
    """Whole identifiers in the first column of the table; words with a remark are retired for one thing only."""
    rows = (ROOT / "docs" / "glossary.md").read_text().split("## Retired words")[1].split("\n")
    cells = [row.split("|")[1] for row in rows if row.startswith("| `")]
    return {word for cell in cells if "(" not in cell for word in re.findall(r"`(\w+)`", cell)}


def names(text: str) -> set[str]:
    """Identifiers of C++ code."""
    return set(re.findall(r"\b[A-Za-z_]\w*\b", NO_CODE.sub(" ", text)))


@pytest.mark.parametrize("file", SOURCES, ids=lambda file: file.name)
def test_no_retired_word_is_a_name(file: Path) -> None:
    assert not names(file.read_text()) & retired()


def test_a_retired_word_would_be_seen() -> None:
    assert {"receding", "respond", "choose_close", "Motion"} <= retired()
    assert names('double receding = 0.0; // of respond\nerror("Motion"); /* choose_close */') & retired() == {"receding"}


@pytest.mark.parametrize("kernel", sorted((ROOT / "plugins" / "kernels").glob("*.h")), ids=lambda file: file.name)
def test_every_kernel_points_to_the_glossary(kernel: Path) -> None:
    assert "docs/glossary.md" in kernel.read_text().split("*/")[0]

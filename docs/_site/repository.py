"""Paths of the repository and of the site: docs/x.md is x.md there, what lies elsewhere keeps its path."""

from __future__ import annotations

import os
import posixpath
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OUTSIDE = (
    "CHANGELOG.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CODE_OF_CONDUCT.md", "examples/README.md", "lammps_inputs/README.md",
    "validation/**/*.md",
)  # fmt: skip
NAVIGATION = Path(__file__).with_name("nav.txt")
LINK = re.compile(r"(!?\[(?:[^\[\]]|\[[^\]]*\])*\]\()([^)\s#]*)((?:#[^)\s]*)?\))")
CODE = re.compile(r"(^```.*?^```)", re.MULTILINE | re.DOTALL)
DRAWN = re.compile(r"^!\[[^\]]*\]\(([^)]+)\)\n?", re.MULTILINE)  # a figure in a paragraph of its own


def _of_docs() -> tuple[str, ...]:
    found = (path for path in (ROOT / "docs").rglob("*") if path.suffix in (".md", ".ipynb", ".png", ".svg"))
    return tuple(sorted(path.relative_to(ROOT).as_posix() for path in found if "_site" not in path.parts))


PAGES_OF_DOCS = _of_docs()  # with their pictures


def outside_pages() -> list[str]:
    """Pages that are not in docs/."""
    return sorted(path.relative_to(ROOT).as_posix() for pattern in OUTSIDE for path in ROOT.glob(pattern))


def site_path(path: str) -> str:
    """Where a file of the repository is on the site; a folder is its README, the README of the repository the first page."""
    if path == "README.md":
        return "index.md"
    if (ROOT / path).is_dir():
        return posixpath.join(path, "README.md")
    return path.removeprefix("docs/")


def linked_files() -> list[str]:
    """Files outside docs/ that are no pages and to which pages link, or which they show."""
    pages = [path for path in PAGES_OF_DOCS if path.endswith(".md")] + outside_pages()
    found = {target for page in pages for target in _targets((ROOT / page).read_text(encoding="utf-8"), page)}
    return sorted(
        path for path in found if not path.startswith(("docs/", "..")) and not path.endswith(".md") and (ROOT / path).is_file()
    )


def _targets(text: str, page: str) -> Iterator[str]:
    """Paths in the repository to which a page links."""
    for part in CODE.split(text)[::2]:
        for _, target, _ in LINK.findall(part):
            if target and "://" not in target:
                yield posixpath.normpath(posixpath.join(posixpath.dirname(page), target))


def rewritten(markdown: str, page: str) -> str:
    """The text of a page of the repository with the links of the site; without the figures of a scoreboard that are drawn and
    not kept."""
    folder, place = posixpath.dirname(page), posixpath.dirname(site_path(page))

    def kept(found: re.Match[str]) -> str:
        return found[0] if (ROOT / folder / found[1]).exists() else ""

    def link(found: re.Match[str]) -> str:
        before, target, after = found.groups()
        path = posixpath.normpath(posixpath.join(folder, target))
        if not target or "://" in target or not (ROOT / path).exists():  # a page that is generated: Sphinx checks it
            return found[0]
        return before + os.path.relpath(site_path(path), place or ".") + after

    if posixpath.basename(page) == "scoreboard.md":
        markdown = DRAWN.sub(kept, markdown)
    return "".join(part if k % 2 else LINK.sub(link, part) for k, part in enumerate(CODE.split(markdown)))


def navigation() -> dict[str, str]:
    """Page of the site -> the table of contents at its end.

    That of the first page is nav.txt, where "*" stands for the pages of docs/ that are not named; examples and validation have
    one of their folders.
    """
    text = NAVIGATION.read_text(encoding="utf-8")
    named = {line.strip() for line in text.splitlines()} | {"index"}
    rest = [page.removeprefix("docs/")[:-3] for page in PAGES_OF_DOCS if page.endswith(".md")]
    unnamed = "\n".join(page for page in rest if page not in named)
    first = ""
    for section in re.findall(r"^\S.*\n(?:^ .*\n)*", text, re.MULTILINE):
        caption, pages = section.split("\n", 1)
        first += _contents(
            f":caption: {caption}", re.sub(r"^ +", "", pages, flags=re.MULTILINE).replace("\n*\n", f"\n{unnamed}\n")
        )
    return {"index.md": first} | {f"{folder}/README.md": _contents(":glob:", "*/*\n") for folder in ("examples", "validation")}


def _contents(option: str, pages: str) -> str:
    return f"\n```{{toctree}}\n:hidden:\n{option}\n\n{pages}```\n"

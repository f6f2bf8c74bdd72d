"""The commands and programs of docs/guide.md, in their order, in one directory: they run, and print what the guide shows.

Runs are shortened (fewer and softer grains); numbers are not compared, they are those of the full runs.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from pathlib import Path

import pytest

from workflow.cli.main import main

GUIDE = Path(__file__).resolve().parents[2] / "docs" / "guide.md"
SHORT = {"--n 200": "--n 60 --kappa 1e3 --hold 1", "n = 200": "n = 60\nkappa = 1e3\nhold = 1.0",
         "--grains 60 --drop-height 20": "--grains 40 --drop-height 12"}  # fmt: skip
MADE = {"reference", "laws"}  # folders of docs/ that the build of the site makes, and whose links it checks
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def form(line: str) -> str:
    """A line without its numbers and blanks: what has to stay the same."""
    line = re.sub(r"\b[0-9a-f]{16}\b", "NAME", line)  # of a point
    line = re.sub(r"[-+~]?\d+(\.\d+)?(e[-+]?\d+)?%?", "1", line)
    return re.sub(r"\s+", " ", line.replace("undefined", "1")).strip()


def shown_in(expected: list[str], printed: str) -> list[str]:
    """Lines of ``expected`` that are not in ``printed`` in their order."""
    lines, missing = iter([form(line) for line in printed.splitlines()]), []
    for line in expected:
        beginning, dots, _ = line.partition("...")
        if form(beginning) and not any(
            (found.startswith(form(beginning)) if dots else found == form(beginning)) for found in lines
        ):
            missing.append(line)
    return missing


def run(words: list[str], status: int) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        assert main(words) == status, out.getvalue()
    return out.getvalue()


@pytest.fixture(scope="module")
def blocks() -> list[tuple[str, str]]:
    return BLOCK.findall(GUIDE.read_text(encoding="utf-8"))


def test_the_guide_does_what_it_says(blocks: list[tuple[str, str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    printed, commands = "", 0
    for kind, text in blocks:
        for full, short in SHORT.items():
            text = text.replace(full, short) if kind in ("console", "toml") else text
        if kind == "toml":
            Path(text.splitlines()[0].lstrip("# ")).write_text(text)
        elif kind == "python":
            with contextlib.redirect_stdout(io.StringIO()) as out:
                exec(compile(text, str(GUIDE), "exec"), {})
            printed = out.getvalue()
        elif kind == "text":
            assert not shown_in(text.splitlines(), printed), printed
        elif kind == "console":
            for part in text.removeprefix("$ ").split("\n$ "):
                command, *expected = part.splitlines()
                words, status = shlex.split(command, comments=True), re.search(r"# status (\d)", command)
                assert words[0] == "wf"
                printed = run(words[1:], int(status[1]) if status else 0)
                missing = shown_in(expected, printed)
                assert not missing, f"{command}: the guide shows {missing}, printed was\n{printed}"
                commands += 1
    assert commands > 12


def test_links_of_the_pages_lead_somewhere() -> None:
    root = GUIDE.parents[1]
    pages = [page for folder in ("docs", "examples", "validation") for page in (root / folder).rglob("*.md")]
    pages += root.glob("*.md")
    broken = []
    for page in pages:
        if page.name == "scoreboard.md":  # its larger figures are drawn, not kept
            continue
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            made = (page.parent / target).is_relative_to(GUIDE.parent) and target.split("/")[0] in MADE
            if not made and not (page.parent / target).exists():
                broken.append(f"{page.name}: {target}")
    assert not broken

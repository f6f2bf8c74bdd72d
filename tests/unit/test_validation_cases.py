"""validation/: every case states its claim, source and command, and its scripts still find what they import."""

from __future__ import annotations

import ast
import importlib
import re
import shlex
from pathlib import Path

import pytest

from workflow.cli.main import parser

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "validation"
CASES = sorted({path.parent for path in FOLDER.glob("[!_]*/*.*")})
SCRIPTS = sorted(FOLDER.glob("*/*.py"))
pytestmark = pytest.mark.skipif(not CASES, reason="source packages are made without validation/")
by_name = pytest.mark.parametrize("case", CASES, ids=lambda path: path.name)


def page_of(case: Path) -> str:
    return (case / "README.md").read_text(encoding="utf-8")


def commands_of(page: str) -> list[str]:
    block = re.search(r"^\* Command: (.*(?:\n  .*)*)", page, re.MULTILINE)
    return re.findall(r"`([^`]+)`", block[1]) if block else []


@by_name
def test_page_states_claim_source_and_command(case: Path) -> None:
    page = page_of(case)
    assert page.startswith("# ")
    for part in ("* Claim: ", "* Source: ", "* Command: `"):
        assert re.search(rf"^{re.escape(part)}\S", page, re.MULTILINE), part


@by_name
def test_commands_start_files_and_options_that_exist(case: Path) -> None:
    """A command of `wf` parses; a script and the files it is given are there."""
    for command in commands_of(page_of(case)):
        program, *words = shlex.split(command.partition(" > ")[0])
        for word in words:
            if word.startswith("validation/"):
                assert (ROOT / word).exists(), command
        if program == "wf":
            parser(words[0]).parse_args(words)
        else:
            assert (program, (ROOT / words[0]).parent) == ("python", case)


@by_name
def test_every_file_is_named_on_the_page(case: Path) -> None:
    page = page_of(case)
    for file in sorted(case.iterdir()):
        if file.is_file() and file.name != "README.md":
            assert file.name in page


def test_index_lists_every_case() -> None:
    index = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^\| \[`(\w+)`\]", index, re.MULTILINE)) == {case.name for case in CASES}


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.name)
def test_script_finds_what_it_imports(script: Path) -> None:
    """Also inside functions; names of the package move, and a script is run once a year."""
    tree = ast.parse(script.read_text(encoding="utf-8"), script.name)
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module]
    assert imports
    for node in imports:
        if node.module.startswith("workflow"):
            module = importlib.import_module(node.module)
            for name in node.names:
                assert hasattr(module, name.name), f"{script.name}:{node.lineno}: {node.module} has no {name.name}"

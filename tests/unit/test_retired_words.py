"""The check of .ci/run that keeps retired words out of code: it finds names and leaves prose alone."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / ".ci" / "retired_words.py"
SPEC = importlib.util.spec_from_file_location("retired_words", SCRIPT)
assert SPEC is not None and SPEC.loader is not None
check = importlib.util.module_from_spec(SPEC)
sys.modules[SPEC.name] = check  # dataclasses look their module up
SPEC.loader.exec_module(check)

PAGE = """# Glossary

| symbol | name |
|---|---|
| `n` | normal |

## Retired words

| retired | standard |
|---|---|
| `stretch`, `reach()` | `xi_t`, cutoff |
| `spin` (plugins) | `omega_rel` |
| `watch.in` | `diagnostics.in` |

## Another section

| `normal` | stays |
"""


def lines_of(tmp_path: Path, name: str, text: str) -> list[str]:
    for folder in check.FOLDERS:
        (tmp_path / folder).mkdir(exist_ok=True)
    (tmp_path / name).write_text(text)
    return list(check.found_in(tmp_path, check.table(PAGE)))


@pytest.mark.parametrize(
    ("file", "text", "line"),
    [
        ("workflow/a.py", "x = 1\nstretch = x\n", 2),
        ("workflow/a.py", "law.reach(stretch_of)\n", 1),
        ("workflow/a.py", "f(stretch=1)\n", 1),
        ("plugins/a.h", "/* prose\n*/ double stretch;\n", 2),
        ("plugins/a.cpp", 'print("x"); spin = 1;\n', 1),
        ("lammps_inputs/a.in", "# prose\nvariable stretch index 1\n", 2),
        ("lammps_inputs/a.in", "if '${stretch} > 0' then 'print x'\n", 1),
        ("lammps_inputs/a.in", "thermo_style custom v_stretch\n", 1),
        ("lammps_inputs/a.in", "include ../common/watch.in\n", 1),
    ],
)
def test_retired_name_is_found_in_its_line(file: str, text: str, line: int, tmp_path: Path) -> None:
    (found,) = lines_of(tmp_path, file, text)
    assert found.startswith(f"{file}:{line}: ")


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("workflow/a.py", '"""The stretch of a contact."""\nx = {"stretch": 1}  # stretch\n'),
        ("workflow/a.py", 'NEW = {old.stretch: "xi_t"}  # retired: files of version 0.2\n'),
        ("workflow/a.py", "stretched = outreach = spin = 1\n"),
        ("plugins/a.h", '// stretch\n/* stretch,\n   reach */ say("stretch");\n'),
        ("lammps_inputs/a.in", "# stretch\nprint 'the stretch is given'\n"),
    ],
)
def test_prose_and_marked_lines_are_left_alone(file: str, text: str, tmp_path: Path) -> None:
    assert lines_of(tmp_path, file, text) == []


def test_name_of_a_file_is_found(tmp_path: Path) -> None:
    (found,) = lines_of(tmp_path, "lammps_inputs/watch.in", "")
    assert found == "lammps_inputs/watch.in: retired name of a file, say `diagnostics.in`"


@pytest.mark.parametrize(
    "page", ["# Glossary\n", "## Retired words\n\nnone\n", "## Retired words\n| `x` (of a pair) | y |\n"],
    ids=["no heading", "no rows", "remarks alone"],
)  # fmt: skip
def test_check_that_could_find_nothing_is_refused(page: str) -> None:
    with pytest.raises(SystemExit, match=r"glossary\.md"):
        check.table(page)


def test_status_tells_whether_a_word_was_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "glossary.md").write_text(PAGE)
    assert lines_of(tmp_path, "workflow/a.py", "xi_t = 0\n") == []
    assert check.main(tmp_path) == 0
    (tmp_path / "workflow" / "a.py").write_text("stretch = 0\n")
    assert check.main(tmp_path) == 1
    assert "workflow/a.py:1: 'stretch' is retired, say `xi_t`" in capsys.readouterr().out

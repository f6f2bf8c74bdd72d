"""docs/si.md: its commands run and print what the page shows; conversions to the digit, runs but for their numbers."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from pathlib import Path

import pytest
from test_guide import BLOCK, form, run, shown_in

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "si.md").read_text(encoding="utf-8")
SHORT = "--n 60 --kappa 1e3 --hold 1"  # in place of 200 grains


def test_the_page_does_what_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    printed, commands = "", 0
    for kind, text in BLOCK.findall(PAGE):
        if kind == "python":
            with contextlib.redirect_stdout(io.StringIO()) as out:
                exec(compile(text, "si.md", "exec"), {})
            printed = out.getvalue()
        elif kind == "text":
            assert text == printed
        elif kind == "console":
            for part in text.removeprefix("$ ").split("\n$ "):
                command, *expected = part.replace("--n 200", SHORT).replace("--max-time 100", "--max-time 2").splitlines()
                status = re.search(r"# status (\d)", command)
                printed = run(shlex.split(command, comments=True)[1:], int(status[1]) if status else 0)
                exact = command.startswith("wf units")
                lines = [line for line in expected if line != "..."]
                missing = [line for line in lines if line not in printed.splitlines()] if exact else shown_in(lines, printed)
                assert not missing, f"{command}: the page shows {missing}, printed was\n{printed}"
                commands += 1
    assert commands == 6 and form("1 a") == form("2 a")
    assert "<td>5.0" in Path("toner/report.html").read_text(encoding="utf-8")  # the stress, in Pa

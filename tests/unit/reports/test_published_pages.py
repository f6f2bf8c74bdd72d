"""What is published of a machine: results, not its folders."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from workflow.cli.options import command_line

RESULTS = Path(__file__).parents[3] / "validation"
FOLDER = re.compile(r"(?<![\w.~/])/(?:home|root|tmp|usr|var|opt|mnt|work|scratch|Users)/\w")


def test_results_hold_no_folder_of_a_machine() -> None:
    pages = [path for path in RESULTS.rglob("*") if path.suffix in {".md", ".csv", ".json", ".toml", ".html"}]
    assert len(pages) > 20
    found = {str(path.relative_to(RESULTS)): FOLDER.findall(path.read_text(encoding="utf-8")) for path in pages}
    assert {name: hits for name, hits in found.items() if hits} == {}


@pytest.mark.parametrize(
    ("given", "published"),
    [
        (["measure", "{here}/runs/one", "--json"], "wf measure runs/one --json"),
        (["reproduce", "gilabert2007", "--out", "/somewhere/else/board"], "wf reproduce gilabert2007 --out board"),
        (["sweep", "--adopt=/somewhere/runs", "--out={here}/x y"], "wf sweep --adopt=runs '--out=x y'"),
        (["run", "method1", "--mu=0.5", "docs/a.toml"], "wf run method1 --mu=0.5 docs/a.toml"),
    ],
)
def test_published_command_has_relative_paths(
    given: list[str], published: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["wf", *(word.format(here=Path.cwd()) for word in given)])
    assert command_line() == published

"""docs/liggghts.md: its deck runs, and its commands say what the page says."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

from workflow.cli.main import main

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "liggghts.md").read_text(encoding="utf-8")


@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed: apt-get install liggghts")
def test_the_page_for_users_of_liggghts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    found = re.search(r"```liggghts\n(.*?)```", PAGE, re.DOTALL)
    assert found
    Path("in.pack").write_text(found[1])
    subprocess.run(["liggghts", "-in", "in.pack"], check=True, stdout=subprocess.DEVNULL)
    commands = re.findall(r"^    wf (.*)$", PAGE, re.MULTILINE)
    assert len(commands) == 5
    said = []
    for command in commands:
        assert main(shlex.split(command)) == 0, command
        said.append(capsys.readouterr())
    assert "id_i: grain i" in said[0].out and "overlap: minus the gap" in said[0].out
    for note in re.findall(r"^    (note: .*)$", PAGE, re.MULTILINE):
        assert re.sub(r"[\d.]+", "", note) in re.sub(r"[\d.]+", "", said[1].out)
    numbers = dict(re.findall(r"^(\S+) +(\S+)$", said[1].out, re.MULTILINE))
    # LIGGGHTS' own sums of the forces, but for what its mean over a step leaves
    assert float(numbers["unbalanced_force.engine_force_difference"]) < 1e-4
    assert float(numbers["stress.contacts.pressure"]) > 0.0 and int(numbers["sliding_contacts"]) > 0
    assert Path("forces.png").is_file() and Path("export/run.gsd").is_file() and Path("packing.html").is_file()

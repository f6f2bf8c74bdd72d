"""Every example runs, shortened, in an empty directory, as its reader would run it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import workflow
from workflow.runs.installation import engine

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = str(Path(workflow.__file__).parents[1])  # the package that is tested here, installed or not
SCRIPTS = sorted(path for kind in ("py", "sh") for path in (ROOT / "examples").glob(f"[0-9][0-9]_*/*.{kind}"))


def test_there_are_examples() -> None:
    assert SCRIPTS, f"no examples in {ROOT / 'examples'}"
    folders = {path.name for path in (ROOT / "examples").iterdir() if path.is_dir() and path.name[:2].isdigit()}
    assert folders == {path.parent.name for path in SCRIPTS}, "an example without a script"


@pytest.fixture
def commands(tmp_path: Path) -> str:
    """A PATH on which `wf`, `lmp` and `python` are those of this installation, installed or not."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for name, command in {
        "wf": f'"{sys.executable}" -m workflow.cli.main',
        "python": f'"{sys.executable}"',
        "python3": f'"{sys.executable}"',
        "lmp": f'"{engine().lmp}"',
    }.items():
        (folder / name).write_text(f'#!/bin/sh\nexec {command} "$@"\n')
        (folder / name).chmod(0o755)
    return os.pathsep.join([str(folder), os.environ["PATH"]])


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.parent.name + "/" + path.name)
def test_example_runs_and_leaves_something_to_look_at(script: Path, commands: str, tmp_path: Path) -> None:
    work = tmp_path / "work"
    work.mkdir()
    environment = {
        **engine().variables(),
        "PATH": commands,
        "PYTHONPATH": PACKAGE,
        "WORKFLOW_EXAMPLE_GRAINS": "60",
        "MPLBACKEND": "Agg",
    }
    command = [sys.executable if script.suffix == ".py" else "sh", str(script)]
    before = sorted(script.parent.iterdir())
    done = subprocess.run(command, cwd=work, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout.strip() or any(work.iterdir()), "it leaves nothing to look at"
    assert sorted(script.parent.iterdir()) == before, "it writes beside itself"

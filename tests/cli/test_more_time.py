"""wf resume --max-time: the run becomes the one that had the longer time from its beginning."""

from __future__ import annotations

import contextlib
import shutil
from pathlib import Path
from typing import Any

import pytest
from wf_process import ALL_STAGES, POURED, QUICK, Wf, record

from workflow.data.files import atomic_write
from workflow.runs import checkpoint
from workflow.runs.directory import RunDirectory
from workflow.runs.extend import extend

RESULTS = ("series.txt", "grains.dump", "contacts.dump", "run.h5", "measures.json", "scene.toml", "deck.in")
OF_QUICK = [*QUICK, "--checkpoint-interval", "1"]
CASES = {
    "before a checkpoint": (OF_QUICK, 0.5, 400), "early": (OF_QUICK, 4, 400), "late": (OF_QUICK, 30, 400),
    "a stage with a step of its own": (ALL_STAGES, 100, 5000), "a heap": (POURED, 40, 400),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_a_run_with_more_time_is_the_run_that_had_it_from_the_beginning(case: str, wf: Wf, tmp_path: Path) -> None:
    """Every file but log, seals and record is the same."""
    words, short, long = CASES[case]
    assert wf("run", *words, "--max-time", long, "--out", "long").returncode == 0
    assert wf("run", *words, "--max-time", short, "--out", "short").returncode == 3
    refused = wf("resume", "short", "--max-time", 0.1)
    assert refused.returncode == 2 and f"--max-time 0.1 is not allowed: the run in 'short' had {short:g}" in refused.stderr
    assert wf("resume", "short").returncode == 2
    done = wf("resume", "short", "--max-time", long)
    assert done.returncode == 0, done.stderr
    for file in RESULTS:
        assert (tmp_path / "short" / file).read_bytes() == (tmp_path / "long" / file).read_bytes(), file
    assert record(tmp_path / "short")["digest"] == record(tmp_path / "long")["digest"]
    refused = wf("resume", "long", "--max-time", long + 100)
    assert refused.returncode == 2 and "ended in equilibrium" in refused.stderr


def test_an_extension_that_is_killed_is_finished_by_the_next_resume(
    wf: Wf, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After each of its writes in turn."""
    assert wf("run", *OF_QUICK, "--max-time", 4, "--out", "short").returncode == 3
    shutil.copytree(tmp_path / "short", tmp_path / "whole")
    extend(RunDirectory(tmp_path / "whole"), 400.0)
    for number in range(1, 20):
        left, folder = number, tmp_path / f"killed{number}"
        shutil.copytree(tmp_path / "short", folder)

        def killed(path: Path, *more: Any) -> Any:
            nonlocal left
            left -= 1
            if not left:
                raise KeyboardInterrupt
            return atomic_write(path, *more)

        with monkeypatch.context() as patch:
            patch.setattr("workflow.runs.directory.atomic_write", killed)
            patch.setattr(checkpoint, "atomic_write", killed)
            with contextlib.suppress(KeyboardInterrupt):
                extend(RunDirectory(folder), 400.0)
        if left > 0:  # there are not so many writes
            assert number > 4
            break
        extend(RunDirectory(folder), 400.0 if number == 1 else None)  # nothing was recorded before the first write
        for file in sorted(path.name for path in (tmp_path / "whole").iterdir() if path.name != ".lock"):
            assert (folder / file).read_bytes() == (tmp_path / "whole" / file).read_bytes(), (number, file)
    else:
        pytest.fail("it does not end")

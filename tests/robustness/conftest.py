"""Runs to damage, and the command line that reads them."""

from __future__ import annotations

import contextlib
import io
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from mutations import SENTINEL, deadline

from workflow.cli.main import main

PACKING = ["method1", "--no-cohesion", "--n", "60", "--kappa", "1e3", "--hold", "1", "--frame-interval", "8"]
HEAP = ["heap", "--grains", "20", "--drop-height", "12", "--base-half-width", "5", "--feed-half-width", "2", "--frame-interval",
        "12", "--checkpoint-interval", "10"]  # fmt: skip


@pytest.fixture
def wf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[int, str, str]]:
    """`wf words` in this process: status, output and message.  An exception that reaches the top fails the test, and so does
    anything that a data file could make run."""
    monkeypatch.chdir(tmp_path)

    def call(*words: Any) -> tuple[int, str, str]:
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), deadline():
            status = main([str(word) for word in words])
        assert status in (0, 1, 2)
        if status and '"error"' not in out.getvalue():  # a group of measures that fails says so among the others
            last = (err.getvalue().splitlines() or [""])[-1]
            assert last.startswith("wf: ") and 20 < len(last) < 2000, err.getvalue()
        assert not Path(SENTINEL).exists(), "something in a file was executed"
        return status, out.getvalue(), err.getvalue()

    return call


def _finished(folder: Path, words: list[str]) -> Path:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        assert main(["run", *words, "--out", str(folder)]) == 0
    return folder


@pytest.fixture(scope="session")
def packing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run of method 1 with several frames; not to be changed."""
    return _finished(tmp_path_factory.mktemp("packing") / "run", PACKING)


@pytest.fixture(scope="session")
def heap(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished heap; not to be changed."""
    return _finished(tmp_path_factory.mktemp("heap") / "run", HEAP)


@pytest.fixture
def fresh(tmp_path: Path) -> Callable[..., Path]:
    """A copy of a run with one file changed (None: taken away)."""

    def copy(run: Path, changed: dict[str, bytes | None]) -> Path:
        target = tmp_path / "run"
        shutil.rmtree(target, ignore_errors=True)
        shutil.copytree(run, target)
        for name, content in changed.items():
            if content is None:
                (target / name).unlink()
            else:
                (target / name).write_bytes(content)
        return target

    return copy

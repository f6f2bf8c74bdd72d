"""The tier of a test: `engine` is put on what starts LAMMPS, a compiler or a browser, and nothing else may start them.

Tiers and their budgets: docs/testing.md.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
ENGINE_FOLDERS = tuple(HERE / name for name in (
    "cli", "engine", "examples", "pbs", "physics", "robustness", "slurm", "unit/kernels",
))  # fmt: skip
ENGINE_FIXTURES = frozenset({"discs", "ranks"})
HEAVY = frozenset({
    "lmp", "mpiexec", "mpirun", "liggghts", "yade", "c++", "g++", "cc", "gcc", "cmake", "chromium", "chromedriver",
})  # fmt: skip
_without_engine = ""  # id of the test at work, if it is not to start an engine


@pytest.hookimpl(tryfirst=True)  # before `-m` chooses
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what stands in a folder, or takes a fixture, that starts an engine."""
    for item in items:
        in_folder = any(folder in item.path.parents for folder in ENGINE_FOLDERS)
        if in_folder or ENGINE_FIXTURES & set(getattr(item, "fixturenames", ())):
            item.add_marker("engine")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Watch what a test without the marker opens and starts, its fixtures included."""
    global _without_engine
    _without_engine = "" if item.get_closest_marker("engine") else item.nodeid
    try:
        return (yield)
    finally:
        _without_engine = ""


def _watch(event: str, arguments: tuple[Any, ...]) -> None:
    if not _without_engine:
        return
    if event == "subprocess.Popen":
        words = [os.fsdecode(word) for word in arguments[1]]
        name = Path(os.fsdecode(arguments[0] or words[0])).name
        ours = next((word for word in words if word.startswith("workflow.")), "")  # a python that runs a module of ours
        if name in HEAVY or ours:
            raise RuntimeError(f"{_without_engine} starts '{ours or name}': mark it with pytest.mark.engine")
    elif event == "ctypes.dlopen" and "lammps" in str(arguments[0]):
        raise RuntimeError(f"{_without_engine} opens '{arguments[0]}': mark it with pytest.mark.engine")


sys.addaudithook(_watch)


def let_children_hear_interrupts() -> None:
    """Undo for children what `nohup pytest &` inherits: an ignored SIGINT stays ignored in every program that is started, a
    caught one does not.  This process stays deaf to it."""
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, lambda number, frame: None)

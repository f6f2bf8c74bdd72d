"""Tests without an engine start none, and children of tests hear interrupts wherever pytest itself was started."""

from __future__ import annotations

import ctypes
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = str(Path(__file__).resolve().parents[1])
CHILD = "import signal; print(signal.getsignal(signal.SIGINT) == signal.default_int_handler)"


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["lmp"], "lmp"),
        (["/usr/bin/c++", "-v"], "c++"),
        ([sys.executable, "-P", "-m", "workflow.cli.main"], "workflow.cli.main"),
    ],
)
def test_a_test_without_the_marker_cannot_start_an_engine_or_a_compiler(words: list[str], named: str) -> None:
    with pytest.raises(RuntimeError) as caught:
        subprocess.run(words, check=False)
    assert f"starts '{named}': mark it with pytest.mark.engine" in str(caught.value)


def test_a_test_without_the_marker_cannot_open_lammps() -> None:
    with pytest.raises(RuntimeError, match=r"opens '.*liblammps\.so': mark it"):
        ctypes.CDLL("liblammps.so")


@pytest.mark.parametrize(("reset", "heard"), [("let_children_hear_interrupts", "True"), ("str", "False")])
def test_children_hear_interrupts_under_an_ignored_sigint(reset: str, heard: str) -> None:
    """`nohup pytest &` starts so; without the reset the child stays deaf, so that this test can fail."""
    program = f"""
import signal, subprocess, sys
signal.signal(signal.SIGINT, signal.SIG_IGN)
sys.path.insert(0, {TESTS!r})
from tiers import let_children_hear_interrupts
{reset}()
signal.raise_signal(signal.SIGINT)  # pytest itself stays deaf
subprocess.run([sys.executable, "-c", {CHILD!r}], check=True)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == heard

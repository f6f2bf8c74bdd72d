"""`wf` as a child process, to its end or in the background."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import workflow
from workflow.data.series import read_series

# children that start elsewhere run the package that is tested here, also from a checkout
os.environ["PYTHONPATH"] = os.pathsep.join(
    filter(None, [str(Path(workflow.__file__).parents[1]), os.environ.get("PYTHONPATH")])
)
os.environ.pop("PYTHONUNBUFFERED", None)  # as a user's shell: what is wrong with standard output shows when it is flushed
WF = [sys.executable, "-m", "workflow.cli.main"]
# 25 000 steps, about a second: soft grains and a short proof of rest
QUICK = ["method1", "--no-cohesion", "--n", "60", "--kappa", "1e3", "--hold", "1"]
# 280 000 steps, some two seconds: can be stopped in the middle and still finished within a test
SLOW = ["method1", "--no-cohesion", "--n", "300", "--kappa", "1e5", "--hold", "1", "--checkpoint-interval", "1"]
# some three seconds through all six stages: soft grains with friction, rolling, distant pairs, a ramp and a load
ALL_STAGES = [
    "method2", "--n", "60", "--kappa", "1e4", "--soft-kappa", "1e3", "--d0", "0.01", "--stiffening", "3", "--rolling",
    "--mur", "0.05", "--quiet", "2", "--hold", "0.2", "--checkpoint-interval", "0.06", "--pstar", "0.05", "--frame-interval", "5",
]  # fmt: skip
# some two seconds: a heap on a base so narrow that grains fall off, with frames, tracks and checkpoints while it is fed
POURED = [
    "heap", "--grains", "80", "--drop-height", "15", "--base-half-width", "5", "--feed-half-width", "2", "--polydispersity",
    "0.1", "--checkpoint-interval", "3", "--frame-interval", "4",
]  # fmt: skip
# far longer than any test looks at it
ENDLESS = ["method1", "--n", "3000", "--max-time", "500"]

Wf = Callable[..., subprocess.CompletedProcess[str]]


def call(*words: object, cwd: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """`wf words` in ``cwd``; whatever happens, a user never sees a traceback."""
    done = subprocess.run(
        [*WF, *map(str, words)],
        cwd=cwd,
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert "Traceback" not in done.stderr, done.stderr
    return done


class Running:
    """A `wf` at work in the background, in a process group of its own."""

    def __init__(self, folder: Path, *words: str, stderr: Any = subprocess.PIPE, resume: bool = False) -> None:
        self.directory = folder / "slow"
        command = [*WF, "resume", "slow"] if resume else [*WF, "run", *words, "--out", "slow"]
        self.process = subprocess.Popen(
            command, cwd=folder, stdout=subprocess.PIPE, stderr=stderr, text=True, start_new_session=True
        )

    def rows(self) -> int:
        """Rows of the time series so far."""
        series = self.directory / "series.txt"
        return sum(1 for line in series.read_text().splitlines() if line[:1].isdigit()) if series.is_file() else 0

    def wait_for_rows(self, rows: int) -> None:
        """Until the engine has written so many rows (and so has checkpoints behind it)."""
        deadline = time.monotonic() + 30.0
        while self.rows() < rows:
            assert time.monotonic() < deadline, "the run does not get going"
            assert self.process.poll() is None, "the run ended before it could be stopped"
            time.sleep(0.02)

    def engine(self) -> list[int]:
        """Process ids of the children of `wf`."""
        pid = self.process.pid
        return [int(word) for word in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]

    def end(self) -> None:
        """Kill what is left."""
        children = self.engine() if self.process.poll() is None else []
        for pid in (self.process.pid, *children):
            kill(pid)
        self.process.communicate()


def kill(pid: int) -> None:
    """kill -9 of a process group that this test started, if it still exists."""
    try:
        os.killpg(pid, signal.SIGKILL)
    except ProcessLookupError:
        return


def alive(pid: int) -> bool:
    """True while the process runs (a zombie does not)."""
    try:
        return "Z" not in Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False


def record(directory: Path) -> dict[str, Any]:
    """run.json."""
    return dict(json.loads((directory / "run.json").read_text()))


def steps(directory: Path) -> Any:
    """Steps of the time series."""
    return read_series(directory / "series.txt")["step"]

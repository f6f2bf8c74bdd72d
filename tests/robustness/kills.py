"""Runs that are killed at random moments, and what must come out of them all the same."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import workflow
from workflow.runs.child_process import descendants
from workflow.runs.directory import RunDirectory

WF = [sys.executable, "-P", "-m", "workflow.cli.main"]
# soft grains, few, with checkpoints as dense as they can be: about a second each where a core is free
SCENES = {
    "method1": ["method1", "--no-cohesion", "--n", "40", "--kappa", "1e3", "--hold", "0.5", "--checkpoint-interval", "0.2",
                "--frame-interval", "3"],
    "method2": ["method2", "--n", "40", "--kappa", "1e4", "--soft-kappa", "1e3", "--d0", "0.02", "--stiffening", "2",
                "--rolling", "--mur", "0.05", "--quiet", "1", "--hold", "0.1", "--checkpoint-interval", "0.5", "--pstar", "0.05",
                "--frame-interval", "10"],
    "heap": ["heap", "--grains", "40", "--drop-height", "12", "--base-half-width", "4", "--feed-half-width", "2",
             "--polydispersity", "0.1", "--checkpoint-interval", "2", "--frame-interval", "4"],
    "consolidation": ["consolidation", "--n", "40", "--kappa", "1e3", "--d0", "0.02", "--quiet", "1", "--hold", "0.1",
                      "--pstar-first", "0.05", "--pstar", "0.2", "--per-decade", "1", "--unload", "--checkpoint-interval", "0.5"],
}  # fmt: skip
RESULTS = ("series.txt", "grains.dump", "contacts.dump", "tracks.dump")


def environment() -> dict[str, str]:
    """Children run the package that is tested; ranks that wait for each other leave the core to others."""
    return {**os.environ, "PYTHONPATH": str(Path(workflow.__file__).parents[1]), "MPIR_CVAR_POLLS_BEFORE_YIELD": "1"}


def start(folder: Path, *words: str) -> subprocess.Popen[bytes]:
    """`wf words` in the background; what it says goes to `said`."""
    with open(folder / "said", "ab") as said:
        return subprocess.Popen([*WF, *words], cwd=folder, env=environment(), stdout=said, stderr=said, start_new_session=True)


def kill(process: subprocess.Popen[bytes], whom: str) -> None:
    """kill -9 of wf, of its engine, or of everything at once, as a power cut does."""
    below = descendants(process.pid)
    for pid in {"wf": [process.pid], "engine": below[:1], "all": [process.pid, *below]}[whom]:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def killed(folder: Path, scene: str, ranks: int, seconds: float, rng: random.Random, kills: int) -> int:
    """Run ``scene`` in ``folder``/run, killed so many times within the ``seconds`` that it takes; how often that hit it."""
    words, hits = ["run", *SCENES[scene], "--out", "run", "--ranks", str(ranks), "--oversubscribe"], 0
    while True:
        process = start(folder, *words)
        if kills > 0:
            time.sleep(rng.uniform(0.0, seconds))
            if process.poll() is None:
                hits += 1
            kill(process, rng.choice(["wf", "engine", "all", "all"]))
            kills -= 1
        status = process.wait(timeout=600)
        directory = RunDirectory(folder / "run")
        if not (directory / "run.json").is_file():
            continue  # killed while the directory was made: the same command again
        if directory.state["status"] == "finished":
            return hits
        assert status != 0, (folder / "said").read_text()
        assert kills >= 0 or status < 0, (folder / "said").read_text()
        if kills == 0:
            kills = -1  # the next part is the last
        words = ["resume", "run", "--oversubscribe"]

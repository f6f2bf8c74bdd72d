"""kill -9 at random moments, of wf, of its engine or of everything at once: the resumed run is the run that was never killed.

By default a few; `WORKFLOW_KILLS=100 pytest -m robustness tests/robustness/test_kills.py` for a hundred of each kind of run.
"""

from __future__ import annotations

import os
import random
import time
from pathlib import Path

import pytest
from kills import RESULTS, SCENES, killed

MANY = int(os.environ.get("WORKFLOW_KILLS", "5"))


def assert_same(run: Path, whole: Path) -> None:
    """Byte for byte."""
    for name in ("measures.json", *RESULTS):
        if (whole / name).is_file():
            assert (run / name).read_bytes() == (whole / name).read_bytes(), name


def attack(tmp_path: Path, scene: str, ranks: int, kills: int) -> None:
    whole = tmp_path / "whole"
    whole.mkdir()
    begun = time.monotonic()
    killed(whole, scene, ranks, 0.0, random.Random(0), -1)
    seconds, done, number = time.monotonic() - begun, 0, 0
    while done < kills:
        folder = tmp_path / str(number)
        folder.mkdir()
        rng = random.Random(f"{scene} {ranks} {number}")
        done += killed(folder, scene, ranks, seconds, rng, min(rng.choice([1, 2, 3]), kills - done))
        assert_same(folder / "run", whole / "run")
        number += 1


@pytest.mark.parametrize("scene", ["method1", "heap"])
def test_a_killed_run_is_the_run_without_the_kills(scene: str, tmp_path: Path) -> None:
    attack(tmp_path, scene, 1, 2)


@pytest.mark.robustness
@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("scene", SCENES)
def test_a_run_killed_many_times_is_the_run_without_the_kills(scene: str, ranks: int, tmp_path: Path) -> None:
    attack(tmp_path, scene, ranks, MANY)

"""The command line in a fresh directory, and a few finished runs that several tests look at."""

from __future__ import annotations

import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from wf_process import ALL_STAGES, POURED, QUICK, Running, Wf, call


@pytest.fixture
def wf(tmp_path: Path) -> Wf:
    """Runs `wf` in the temporary directory of the test."""
    return lambda *words, **variables: call(*words, cwd=tmp_path, **variables)


def _finished(folder: Path, *words: str) -> Path:
    done = call("run", *words, "--out", "run", cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder / "run"


@pytest.fixture(scope="session")
def packing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run without cohesion; look, do not touch."""
    return _finished(tmp_path_factory.mktemp("packing"), *QUICK)


@pytest.fixture(scope="session")
def cohesive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run with everything: cohesion with a wide tail (so that distant pairs occur), friction, rolling."""
    words = ["method1", "--n", "60", "--kappa", "1e3", "--hold", "1", "--pstar", "1", "--d0", "0.05", "--rolling"]
    return _finished(tmp_path_factory.mktemp("cohesive"), *words)


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, float]:
    """A finished run of method 2 through all its stages, and how long it took; look, do not touch."""
    begun = time.monotonic()
    return _finished(tmp_path_factory.mktemp("whole"), *ALL_STAGES), time.monotonic() - begun


@pytest.fixture(scope="session")
def poured(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, float]:
    """A finished heap, and how long it took; look, do not touch."""
    begun = time.monotonic()
    return _finished(tmp_path_factory.mktemp("poured"), *POURED), time.monotonic() - begun


@pytest.fixture
def copy(packing: Path, tmp_path: Path) -> Path:
    """A copy of the finished run to damage."""
    return Path(shutil.copytree(packing, tmp_path / "copy"))


@pytest.fixture
def running(tmp_path: Path) -> Iterator[Callable[..., Running]]:
    """Starts `wf run WORDS --out slow` in the background."""
    started: list[Running] = []

    def start(*words: str, **options: Any) -> Running:
        started.append(Running(tmp_path, *words, **options))
        return started[-1]

    yield start
    for one in started:
        one.end()


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Callable[[str], Path]]:
    """Mounts a tmpfs with the given options on `disk`."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted: list[Path] = []

    def mount(options: str) -> Path:
        done = subprocess.run(
            ["mount", "-t", "tmpfs", "-o", options, "tmpfs", disk], capture_output=True, text=True, check=False
        )
        if done.returncode:
            pytest.skip(f"cannot mount a tmpfs here: {done.stderr.strip()}")
        mounted.append(disk)
        return disk

    yield mount
    for folder in mounted:
        subprocess.run(["umount", folder], check=True)

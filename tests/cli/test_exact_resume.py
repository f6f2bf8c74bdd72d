"""Kill -9 at any moment: the resumed run is, bit for bit, the run that was never interrupted, in every stage."""

from __future__ import annotations

import random
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from wf_process import Running, Wf, call, kill, record

from workflow.engine.checkpoint import newest

# some ten seconds through all six stages: soft grains with friction, rolling, distant pairs, a ramp and a load
ALL_STAGES = [
    "method2", "--n", "60", "--kappa", "1e4", "--soft-kappa", "1e3", "--d0", "0.01", "--stiffening", "3", "--rolling",
    "--mur", "0.05", "--quiet", "2", "--hold", "0.2", "--checkpoint-interval", "0.5", "--pstar", "0.05", "--frame-interval", "5",
]  # fmt: skip
RESULTS = ("series.txt", "grains.dump", "contacts.dump")
Start = Callable[..., Running]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, float]:
    """The run without interruption, and how long it took."""
    folder, begun = tmp_path_factory.mktemp("whole"), time.monotonic()
    done = call("run", *ALL_STAGES, "--out", "whole", cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder / "whole", time.monotonic() - begun


def stop(run: Running) -> None:
    """Power cut: `wf` and engine vanish at once."""
    for pid in (run.process.pid, *run.engine()):
        kill(pid)
    run.process.wait(timeout=5)


def assert_same(directory: Path, whole: Path) -> None:
    assert record(directory)["status"] == "finished"
    for name in RESULTS:
        assert (directory / name).read_bytes() == (whole / name).read_bytes(), name


def test_all_stages_are_there(whole: tuple[Path, float]) -> None:
    stages = {line.split()[2] for line in (whole[0] / "series.txt").read_text().splitlines() if line[0].isdigit()}
    assert stages >= {"1", "2", "3", "4", "5"}


@pytest.mark.parametrize("seed", range(4))
def test_killed_at_random_moments(seed: int, whole: tuple[Path, float], running: Start, wf: Wf) -> None:
    """Once in the run and up to twice more while it resumes."""
    rng = random.Random(seed)
    reference, seconds = whole
    run = running(*ALL_STAGES)
    run.wait_for_rows(1)
    for share in (0.7, 0.4, 0.4):
        time.sleep(rng.uniform(0.0, share * seconds))
        if run.process.poll() is None:
            stop(run)
        if record(run.directory)["status"] == "finished":
            break
        run = running(resume=True)
    _, text = run.process.communicate(timeout=120)
    assert run.process.returncode == 0, text
    assert_same(run.directory, reference)


def test_damaged_checkpoint_is_not_used(whole: tuple[Path, float], tmp_path: Path, running: Start, wf: Wf) -> None:
    """A bit that flipped on the disk: the checkpoint before it is taken."""
    reference, seconds = whole
    run = running(*ALL_STAGES)
    run.wait_for_rows(10)
    time.sleep(0.2 * seconds)
    stop(run)
    found = newest(run.directory)
    assert found is not None
    content = bytearray(found.path.read_bytes())
    content[len(content) // 2] ^= 4
    found.path.write_bytes(bytes(content))
    done = wf("resume", "slow")
    assert done.returncode == 0, done.stderr
    assert f"{found.path.name} is damaged" in done.stderr
    assert "continuing from checkpoint" in done.stderr
    assert_same(run.directory, reference)


def test_last_part_of_a_run_is_reproduced(whole: tuple[Path, float], tmp_path: Path, wf: Wf) -> None:
    shutil.copytree(whole[0], tmp_path / "copy")
    done = wf("verify", "copy", "--last")
    assert done.returncode == 0, done.stdout
    assert "reproduced: from step" in done.stdout


def test_finished_run_says_so(whole: tuple[Path, float]) -> None:
    done = call("resume", str(whole[0]), cwd=whole[0].parent)
    assert done.returncode == 2
    assert "is finished; there is nothing to resume" in done.stderr

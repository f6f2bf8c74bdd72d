"""Kill -9 at any moment: the resumed run is, bit for bit, the run that was never interrupted, in every stage."""

from __future__ import annotations

import filecmp
import os
import random
import shutil
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from wf_process import ALL_STAGES, POURED, SLOW, Running, Wf, call, kill, record

from workflow.archive.read import Archive
from workflow.runs.checkpoint import CheckpointChecksums, confirmed, newest, step_of
from workflow.runs.directory import RunDirectory

SEEDS = range(int(os.environ.get("WORKFLOW_KILLS", "1")))  # many more: pytest -m robustness tests/robustness/test_kills.py
RESULTS = ("series.txt", "grains.dump", "contacts.dump", "tracks.dump")
Start = Callable[..., Running]


def stop(run: Running) -> None:
    """Power cut: `wf` and engine vanish at once."""
    for pid in (run.process.pid, *run.engine()):
        kill(pid)
    run.process.wait(timeout=5)


def assert_same(directory: Path, whole: Path) -> None:
    assert record(directory)["status"] == "finished"
    for name in filter(lambda name: (whole / name).is_file(), RESULTS):
        assert filecmp.cmp(directory / name, whole / name, shallow=False), name


@pytest.mark.parametrize("seed", SEEDS)
def test_a_run_killed_at_random_moments_resumes_to_the_same_bytes(seed: int, whole: tuple[Path, float], running: Start) -> None:
    kill_and_resume(seed, ALL_STAGES, whole, running)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_heap_killed_at_random_moments_resumes_to_the_same_bytes(
    seed: int, poured: tuple[Path, float], running: Start
) -> None:
    """While grains fall, arrive, slide and leave the base."""
    kill_and_resume(seed, POURED, poured, running)


def kill_and_resume(seed: int, words: list[str], whole: tuple[Path, float], running: Start) -> None:
    """Killed once in the run and up to twice more while it resumes."""
    rng = random.Random(seed)
    reference, seconds = whole
    run = running(*words)
    run.wait_for_rows(1)
    killed = False
    for share in (0.7, 0.4, 0.4):
        time.sleep(rng.uniform(0.0, share * seconds))
        if run.process.poll() is not None:
            break
        stop(run)
        killed = record(run.directory)["status"] == "finished"  # all was written, only the farewell was cut off
        if killed:
            break
        run = running(resume=True)
    _, text = run.process.communicate(timeout=120)
    assert killed or run.process.returncode == 0, text
    assert_same(run.directory, reference)


@pytest.mark.parametrize("stage", range(1, 7))
def test_a_run_resumed_in_every_stage_has_the_same_bytes(stage: int, whole: tuple[Path, float], tmp_path: Path, wf: Wf) -> None:
    resume_after_last_checkpoint(stage, whole[0], tmp_path, wf)


def test_heap_resumes_from_its_last_checkpoint(poured: tuple[Path, float], tmp_path: Path, wf: Wf) -> None:
    resume_after_last_checkpoint(1, poured[0], tmp_path, wf)


def resume_after_last_checkpoint(stage: int, whole: Path, tmp_path: Path, wf: Wf) -> None:
    """As if killed right after the last checkpoint of the stage, which may be written at the very step that ends it."""
    run = Path(shutil.copytree(whole, tmp_path / "copy"))
    last = max(run.glob(f"checkpoint.{stage}.[ab]"), key=lambda path: step_of(path) or 0)
    for path in run.glob("checkpoint.*"):
        if not path.name.startswith(last.name):
            path.unlink()
    RunDirectory.open(run).record(status="running")
    done = wf("resume", "copy")
    assert done.returncode == 0, done.stderr
    assert f"continuing from {last.name}" in done.stderr
    assert_same(run, whole)


def test_damaged_checkpoint_is_not_used(whole: tuple[Path, float], tmp_path: Path, running: Start, wf: Wf) -> None:
    """A bit that flipped on the disk: the checkpoint before it is taken."""
    reference, seconds = whole
    run = running(*ALL_STAGES)
    run.wait_for_rows(10)
    time.sleep(0.2 * seconds)
    stop(run)
    CheckpointChecksums(run.directory).look()  # as wf does at intervals that are longer than those of the checkpoints here
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


def test_checkpoints_of_a_lost_course_are_not_used(whole: tuple[Path, float], tmp_path: Path, running: Start) -> None:
    """Killed twice: the second part continues from an early checkpoint, beside later ones of the first that were not sealed."""
    reference, seconds = whole
    run = Path(shutil.copytree(reference, tmp_path / "slow"))
    for path in run.glob("checkpoint.[2-6].?.json"):
        path.unlink()
    RunDirectory.open(run).record(status="running")
    second = running(resume=True)
    time.sleep(0.3 * seconds)
    stop(second)
    third = running(resume=True)
    _, text = third.process.communicate(timeout=120)
    assert third.process.returncode == 0, text
    assert_same(run, reference)


def test_a_run_on_a_disk_that_fills_up_resumes_with_more_room(
    small_disk: Callable[[str], Path], wf: Wf, tmp_path: Path
) -> None:
    """It stops with a sentence while the last checkpoint is good; with more room the run goes on from there."""
    disk = small_disk("size=3m")
    done = wf("run", *SLOW, "--frame-interval", "0.3", "--out", "disk/new")
    assert done.returncode == 1
    assert "No space left on device" in done.stderr
    assert "wf resume disk/new" in done.stderr
    found = newest(disk / "new")
    assert found is not None
    assert confirmed(found.path)
    assert record(disk / "new")["status"] == "failed"
    subprocess.run(["mount", "-o", "remount,size=200m", disk], check=True)
    done = wf("resume", "disk/new")
    assert done.returncode == 0, done.stderr
    assert f"continuing from {found.path.name}, step {found.step}" in done.stderr
    with Archive(disk / "new" / "run.h5") as archive:
        times = [frame.time for frame in archive.frames]
    assert np.all(np.diff(times) > 0)
    assert len(times) > 20


def test_last_part_of_a_run_is_reproduced(whole: tuple[Path, float], tmp_path: Path, wf: Wf) -> None:
    shutil.copytree(whole[0], tmp_path / "copy")
    done = wf("verify", "copy", "--last")
    assert done.returncode == 0, done.stdout
    assert "reproduced: from step" in done.stdout


@pytest.mark.parametrize("part", [[], ["--last"]])
def test_heap_is_reproduced(part: list[str], poured: tuple[Path, float], tmp_path: Path, wf: Wf) -> None:
    shutil.copytree(poured[0], tmp_path / "copy")
    done = wf("verify", "copy", *part)
    assert done.returncode == 0, done.stdout
    assert "every byte of what it wrote" in done.stdout


def test_finished_run_says_so(whole: tuple[Path, float]) -> None:
    done = call("resume", str(whole[0]), cwd=whole[0].parent)
    assert done.returncode == 2
    assert "is finished; there is nothing to resume" in done.stderr

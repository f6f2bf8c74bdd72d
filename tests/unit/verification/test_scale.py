"""Stages of a large scene, run on a small one; and what is read off them for a larger one."""

from __future__ import annotations

from pathlib import Path

import pytest

from workflow.errors import EngineError
from workflow.verification.scale import ARCHIVED, DATA_FILE, LOOP, SAVE, START, WIRE, Stage, estimate, part

PEAK = 0.5  # GB of a rank


def stages(n: int = 1_000_000, ranks: int = 2) -> list[Stage]:
    """A scene whose numbers are easy: 800 bytes and 20 ns per grain, two times the ranks in half the time."""
    bytes_per_grain = 800.0

    def row(stage: str, on: int, seconds: float, **more: float) -> Stage:
        return Stage("gas", n, stage, on, seconds, seconds, PEAK, bytes_per_grain, **more)

    return [
        row(DATA_FILE, 1, 3.0, MB=70.0),
        row(START, 1, 30.0, MB=500.0), row(LOOP, 1, 20.0, ns_per_grain_step=20.0, ghosts=8000.0), row(SAVE, 1, 2.0, MB=200.0),
        row(START, ranks, 30.0, MB=500.0), row(LOOP, ranks, 10.0, ns_per_grain_step=10.0, ghosts=6000.0),
        row(SAVE, ranks, 2.0, MB=200.0), row(ARCHIVED, 1, 40.0, MB=160.0),
    ]  # fmt: skip


def test_estimate_grows_as_grains_and_edges_do() -> None:
    same = estimate(stages(), 1_000_000, 2, 10.0)
    assert same.memory_GB == pytest.approx(PEAK)  # of what was measured
    assert same.seconds_per_million_steps == pytest.approx(1e6 * 0.5e6 * 20e-9)
    large = estimate(stages(), 100_000_000, 200, 10.0)  # the same grains per rank
    assert large.memory_GB == pytest.approx(same.memory_GB)
    assert large.seconds_per_million_steps == pytest.approx(same.seconds_per_million_steps)
    assert (large.data_GB, large.frame_GB, large.archive_GB, large.restart_GB) == pytest.approx((7.0, 25.0, 8.0, 20.0))
    assert (large.restart_seconds, large.restart_seconds_parallel, large.frame_seconds) == pytest.approx((200.0, 2.0, 1500.0))
    # ghosts stand along the edge: a quarter of the area has half of them; 8000 around a square of 1e6 grains
    assert large.ghosts == pytest.approx(8000.0 * (0.5e6 / 1e6) ** 0.5)
    quarter = estimate(stages(), 100_000_000, 800, 10.0)
    assert quarter.ghosts == pytest.approx(large.ghosts / 2.0)
    assert quarter.sent_kB == pytest.approx(WIRE * quarter.ghosts / 1e3)
    assert quarter.sent_MB_per_second == pytest.approx(large.sent_MB_per_second * 2.0)  # half of it in a quarter of the time
    # 800 bytes per grain, what a rank occupies without grains beside them
    assert large.memory_GB - quarter.memory_GB == pytest.approx(800.0 * (500_000 - 125_000) / 1e9)


@pytest.mark.engine
def test_every_stage_of_a_small_scene_is_measured(tmp_path: Path) -> None:
    folder, n = tmp_path / "gas", 300
    rows = part("gas", folder, n, 50) + part("run", folder, n, 1)
    rows += part("archive", folder, n) + part("read", folder, n) + part("measure", folder, n)
    rows += part("group", folder, n, "holes") + part("export", folder, n, "csv")
    found = {row["stage"]: Stage(state="gas", **row) for row in rows}
    assert list(found) == [
        "placement", DATA_FILE, START, LOOP, SAVE, ARCHIVED, "read a frame", "wf measure", "wf measure --only holes",
        "wf export --to csv",
    ]  # fmt: skip
    for stage in found.values():
        assert stage.seconds >= 0.0 and 0.01 < stage.peak_GB < 2.0
    assert (found[LOOP].ns_per_grain_step or 0.0) > 0.0 and (found[LOOP].ghosts or 0.0) > 0.0
    # a disc of a data file is a line of some 60 bytes, a record of a checkpoint is more than 20 numbers, a frame more
    assert 0.01 < (found[DATA_FILE].MB or 0.0) < 0.05
    assert (found[SAVE].MB or 0.0) > 300 * 20 * 8 / 1e6
    assert (found[START].MB or 0.0) > 2 * 300 * 11 * 8 / 1e6
    assert (found["wf export --to csv"].MB or 0.0) > 0.01 and not (folder / "export").exists()
    estimate(list(found.values()), 1000, 4, 1.0)


@pytest.mark.engine
def test_a_stage_that_fails_says_why(tmp_path: Path) -> None:
    with pytest.raises(EngineError, match=r"is no run directory|does not exist"):
        part("measure", tmp_path / "nowhere", 10)

"""Density histories and snapshots: what is drawn, at what scale, and which frames are chosen."""

from __future__ import annotations

import filecmp
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workflow.data.frame import Frame, Interactions
from workflow.errors import InputError
from workflow.reports.assembling import closing, density_history, snapshots

EMPTY = Interactions(*(np.zeros(0, int),) * 2, np.zeros((0, 2)), *(np.zeros(0),) * 8, *(np.zeros(0, bool),) * 2)


@pytest.fixture
def frame() -> Frame:
    rng = np.random.default_rng(1)
    d, zeros = rng.uniform(0.5, 1.0, 30), np.zeros((30, 2))
    return Frame(0, 1.0, "free", np.zeros(2), np.array([8.0, 6.0]), np.arange(30), d, d**2, rng.uniform(0, 6, (30, 2)),
                 zeros, zeros[:, 0], zeros, zeros[:, 0], EMPTY)  # fmt: skip


def shrunk(frame: Frame, factors: list[float], stages: list[str]) -> list[Frame]:
    return [
        replace(frame, cell=frame.cell * factor, stage=stage, step=k)
        for k, (factor, stage) in enumerate(zip(factors, stages, strict=True))
    ]


def test_frames_of_the_collapse_are_spread_over_the_solid_fraction(frame: Frame) -> None:
    factors = [1.0, 1.0, 0.99, 0.97, 0.95, 0.9, 0.85, 0.8, 0.8]
    frames = shrunk(frame, factors, ["aggregate", "free", *["load"] * 6, "settle"])
    chosen = closing(frames)
    assert (chosen[0], chosen[-1], len(chosen)) == (1, 8, 4)
    density = [1.0 / factors[k] ** 2 for k in chosen]
    assert np.diff(density).max() < 2.0 * np.diff(density).min()


def test_without_load_the_last_frame_is_shown(frame: Frame) -> None:
    frames = shrunk(frame, [1.0, 1.0], ["aggregate", "relax"])
    assert closing(frames)[-1] == 1


def test_figures_are_written_and_repeat(frame: Frame, tmp_path: Path) -> None:
    series = {"time": np.linspace(0, 50, 40), "stage": 1.0 + (np.arange(40) > 20), "solid_fraction": np.linspace(0.3, 0.5, 40)}
    for name in ("one", "two"):
        snapshots(shrunk(frame, [1.0, 0.8], ["free", "settle"]), tmp_path / f"{name}.svg", names=["free", "settle"])
        density_history({"method 2": series}, tmp_path / f"{name}d.svg", stages={"method 2": {1: "aggregate", 2: "load"}})
    for suffix in (".svg", "d.svg"):
        assert filecmp.cmp(tmp_path / f"one{suffix}", tmp_path / f"two{suffix}", shallow=False)


def test_nothing_to_draw(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no frame"):
        snapshots([], tmp_path / "x.png", names=[])
    with pytest.raises(InputError, match="no row"):
        density_history({"run": {"time": np.zeros(1)}}, tmp_path / "x.png", stages={})

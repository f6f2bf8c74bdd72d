"""The time left that a run shows, against series of runs that were recorded to their end.

recorded/: columns of the time series and scene of finished runs: method 1 and 2 of 1400 grains, and small ones of each scene.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from workflow.runs.progress import steps_left
from workflow.scene.base import Scene
from workflow.scene.registry import scene_from

RECORDED = sorted(Path(__file__).with_name("recorded").glob("*.npz"))
MOMENTS = np.linspace(0.5, 0.97, 12)  # shares of the time of a stage
ROWS = 12  # stages with fewer are over before anything is shown


def stages(path: Path) -> Iterator[tuple[Scene, dict[str, np.ndarray]]]:
    """The scene and the rows of each of its stages."""
    with np.load(path) as file:
        series = {name: file[name].astype(float) for name in file.files if name != "scene"}
        scene = scene_from(tomllib.loads(str(file["scene"])))
    for number in np.unique(series["stage"]):
        rows = {name: values[series["stage"] == number] for name, values in series.items()}
        if len(rows["time"]) >= ROWS:
            yield scene, rows


def shown(scene: Scene, rows: dict[str, np.ndarray]) -> Iterator[tuple[float | None, float]]:
    """(steps left as shown, steps that were left) from half of the stage's time on; None: unknown."""
    time, step = rows["time"], rows["step"]
    for share in MOMENTS:
        past = {name: values[time <= time[0] + share * (time[-1] - time[0])] for name, values in rows.items()}
        rest = step[-1] - past["step"][-1]
        yield steps_left(scene, past), rest * scene.cost_left(past)


def test_the_time_left_is_right_within_a_factor_of_two_or_unknown() -> None:
    """Over 62 runs of method 1 and 2, 496 of 514 values were (1286 moments: unknown); of the eight kept here, 60 of 65."""
    pairs = [pair for path in RECORDED for scene, rows in stages(path) for pair in shown(scene, rows)]
    known = [(left, rest) for left, rest in pairs if left is not None]
    right = [0.5 * rest <= left <= 2.0 * rest for left, rest in known]
    assert len(known) > 0.15 * len(pairs), f"{len(known)} of {len(pairs)} known: nothing is told"
    assert sum(right) >= 0.9 * len(right), f"{sum(right)} of {len(right)}"


@pytest.mark.parametrize("path", RECORDED, ids=lambda path: path.stem)
def test_no_value_is_far_off(path: Path) -> None:
    for scene, rows in stages(path):
        for left, rest in shown(scene, rows):
            assert left is None or rest / 10.0 < left < 10.0 * rest + 2000, (scene.name, rows["stage"][0], left, rest)

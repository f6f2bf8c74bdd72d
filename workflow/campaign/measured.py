"""Measures of the samples of a study: of one frame of each, kept beside the study, and what only several together give."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from workflow.archive.read import Archive
from workflow.data.files import atomic_write
from workflow.errors import InputError
from workflow.measures.heap import dip, mean_profile
from workflow.measures.registry import GROUPS, Settings
from workflow.measures.samples import found_at, pool
from workflow.pipeline.collect import measures_of, settings_of, stored_measures
from workflow.runs.directory import ARCHIVE, RunDirectory

LARGEST = 10  # avalanches of a heap whose depth is averaged

Measures = Mapping[str, Any]


def frame_index(directory: RunDirectory, stage: str | None) -> int:
    """Number of the last frame of a stage, -1 for the end of the run.

    A run whose longest time was over before the stage is taken at its end if its grains had the law and the load of
    the stage by then; it is among those that are not at rest.  Raises InputError if the run has no such frame.
    """
    if stage is None:
        return -1
    with Archive(directory / ARCHIVE) as archive:
        if stage in archive.ends:
            return archive.ends[stage]
        last = archive.stages[-1]
    scene = directory.scene
    order = ["start", *scene.stages.values()]
    if order.index(last) < order.index(stage) and scene.alike(last, stage):
        return -1
    raise InputError(f"'{directory.path}' has no frame of stage {stage}")


def measured(directory: RunDirectory, stage: str | None, group: str | None, kept: Path) -> dict[str, Any]:
    """Standard measures of a finished run at the end of ``stage``, with ``group`` of measures beside them.

    What measures.json of the run does not hold is computed once and written to ``kept``/NAME.json; remove that folder to
    measure anew.
    """
    if stage is None:
        known = stored_measures(directory)
        if group is None or group in known:
            return dict(known)
    store = kept / f"{directory.path.name}.json"
    table = json.loads(store.read_text(encoding="utf-8")) if store.is_file() else {}
    key = f"{stage or 'end'} {group or 'standard'}"
    if key not in table:
        groups = [group] if group else ["none"]
        table[key] = measures_of(directory, frame_index(directory, stage), groups=groups)
        kept.mkdir(parents=True, exist_ok=True)
        with atomic_write(store) as draft:
            draft.write_text(json.dumps(table), encoding="utf-8")
    return dict(table[key])


def settings_at(directory: RunDirectory, stage: str | None) -> Settings | None:
    """The settings of the measures at the end of ``stage``, None where the groups of measures do not know the law."""
    scene = directory.scene
    law = scene.law_of(stage or list(scene.stages.values())[-1])
    return None if law is None else settings_of(scene, law)


def group_of(measure: str) -> str | None:
    """The group of measures that a path needs, None if the standard ones have it."""
    first = measure.split(".")[0]
    return first if first in GROUPS else None


def of_samples(measure: str, samples: Sequence[Measures], settings: Settings | None) -> float | None:
    """The value of a measure over samples: the mean of those that have it, or what is only had from all together."""
    first = measure.split(".")[0]
    if first in TOGETHER:
        return found_at(TOGETHER[first](samples, settings), measure.partition(".")[2]) if samples else None
    values = [value for value in (found_at(sample, measure) for sample in samples) if value is not None]
    return float(np.mean(values)) if values else None


def jackknife(measure: str, samples: Sequence[Measures], settings: Settings | None) -> float | None:
    """Standard error of `of_samples`: sqrt((n - 1)/n sum (x_i - <x>)^2), x_i the value without sample i.

    For a mean this is the scatter over sqrt(n).  None for fewer than two samples.
    """
    count = len(samples)
    if count < 2:
        return None
    found = [of_samples(measure, [*samples[:k], *samples[k + 1 :]], settings) for k in range(count)]
    left = np.array([value for value in found if value is not None])
    return float(np.sqrt((count - 1.0) / count * np.sum((left - left.mean()) ** 2))) if len(left) == count else None


def _density(samples: Sequence[Measures], settings: Settings | None) -> Measures:
    """I(k) averaged over the samples and its fit by eq. 28."""
    assert settings is not None
    return dict(pool([{"density": sample["density"]} for sample in samples], settings)["density"])


def _base_profile(samples: Sequence[Measures], settings: Settings | None) -> Measures:
    """The base force profile averaged over heaps: how far its centre lies below its maxima, and these over it."""
    heaps = [(np.array(s["base_force_profile"]["x"]), np.array(s["base_force_profile"]["force"])) for s in samples]
    mean = mean_profile(heaps)
    below = dip(mean.x, mean.force, float(np.mean([sample["half_width"] for sample in samples])))
    return {"dip": below, "maxima_above_centre": 1.0 / (1.0 - below) - 1.0} if np.isfinite(below) and below < 1.0 else {}


def _avalanches(samples: Sequence[Measures], settings: Settings | None) -> Measures:
    """Mean depth of the largest avalanches of each heap."""
    events = [sorted(s["avalanches"] or [], key=lambda event: -event["size"])[:LARGEST] for s in samples]
    depths = [event["depth"] for heap in events for event in heap]
    return {"depth_of_largest": float(np.mean(depths))} if depths else {}


TOGETHER: dict[str, Callable[[Sequence[Measures], Settings | None], Measures]] = {
    "density": _density,
    "base_profile": _base_profile,
    "avalanches": _avalanches,
}

"""Measures of a run of scene `heap`, with the run's own error figures."""

from __future__ import annotations

from typing import Any

import numpy as np

from workflow.data.frame import Frame
from workflow.measures.heap import Ground, equivalent_stiffness, measure
from workflow.pipeline.recorded import Recorded
from workflow.scene.heap import FLOOR


def ground(scene: Any) -> Ground:
    """Where the heap of ``scene``, a `Heap`, stands."""
    return Ground(len(scene.base_discs()), scene.middle, FLOOR)


def of_frame(run: Recorded, frame: Frame) -> dict[str, Any]:
    """The measures of a frame of the archive."""
    scene, series, row = run.scene, run.series, run.row(frame)
    at = {name: float(values[row]) for name, values in series.items()} if row is not None else {}
    tracks = run.archive.tracks if run.is_last(frame) else None
    numbers: dict[str, Any] = {"scene": scene.name, **measure(frame, ground(scene), tracks)}
    closes = at and scene.account and not scene.law and scene.base == "rough" and scene.start == "pour" and at["energy_in"]
    numbers["energy_residual"] = {"value": at["residual"], "relative": at["residual"] / at["energy_in"]} if closes else None
    if not scene.hooke and numbers["closest_pair"] < 0.0:
        at_rest = 1.0 + numbers["closest_pair"]
        stiffness = equivalent_stiffness(scene.index, scene.cutoff, at_rest)
        numbers["equivalent_hooke"] = {"closest": at_rest, "stiffness": stiffness}
    step = scene.step_choice
    overlap, approach = numerics_of(series, "overlap"), numerics_of(series, "approach")
    if scene.start == "pour" and "largest_approach" not in series:  # rows meet few impacts; none is faster than the fall
        approach = max(scene.impact_speed, approach)
    tail = 0.0 if scene.hooke else (scene.cutoff - 1.0) * (1.0 - scene.polydispersity)  # of the force, from r0 to sigma
    return numbers | {
        "equilibrated": run.equilibrated(frame),
        "poured": int(at.get("poured", 0)), "removed": int(at.get("removed", 0)),
        "unbalanced_force": at.get("net_force"), "time": frame.time, "step": frame.step,
        "numerics": {
            "step": step.step, "step_reason": step.reason, "steps_per_stiffest_period": step.period / step.step,
            "largest_overlap": overlap if series else None,
            "fastest_approach": approach,
            "steps_in_tail": tail / (approach * step.step) if tail and approach else None,
        },
    }  # fmt: skip


def numerics_of(series: dict[str, Any], name: str) -> float:
    """Largest overlap or approach of every step; of the rows where they were not watched: version 0.2, laws of LAMMPS."""
    if not series:
        return 0.0
    every_step = series.get(f"largest_{name}", np.array([np.nan]))[-1]
    return float(series[name].max() if np.isnan(every_step) else every_step)

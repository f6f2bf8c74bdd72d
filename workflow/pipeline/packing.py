"""Measures of a run that ends in a packing, with the run's own error figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from workflow.data.balance import solid_fraction
from workflow.data.frame import Floats, Frame, Interactions
from workflow.measures.energy import energies
from workflow.measures.packing import measure
from workflow.pipeline.recorded import Recorded
from workflow.scene.packing import Packing


def of_run(run: Recorded) -> dict[str, Any]:
    """What settling stages changed, and how well the run was resolved."""
    archive, ends = run.archive, run.archive.ends
    relaxed = {
        after: relaxation(archive.frame(ends[before]), archive.frame(ends[after]))
        for before, after in run.scene.relaxations
        if {before, after} <= set(ends)
    }
    return {"relaxation": relaxed or None, "numerics": _numerics(run.scene, run.series)}


def of_frame(run: Recorded, frame: Frame) -> dict[str, Any]:
    """The standard numbers of a frame, its energies and the residual of its row of the time series."""
    scene, series, row, residual = run.scene, run.series, run.row(frame), None
    if row is not None and scene.account and scene.exact and scene.barostat == "inertial":
        value, scale = float(series["residual"][row]), _energy_scale(series, row)
        residual = {"value": value, "relative": value / scale if scale else 0.0}
    pressure, law = scene.pressure_of(frame.stage), scene.law_of(frame.stage)
    numbers = measure(
        frame, force_unit=scene.force_unit, tolerance=scene.force_tolerance, targets=(pressure, pressure),
        equilibrated=run.equilibrated(frame),
    )  # fmt: skip
    numbers["energy_residual"] = residual
    numbers["energy"] = {name: known(value) for name, value in energies(frame, law).as_dict().items()}
    return numbers


def _energy_scale(series: dict[str, Any], row: int) -> float:
    """What the residual of a row is compared with: the largest of the work of the cell, each loss, and the energy that grains
    and contacts have held in any row until then, which is all there is where nothing is lost."""
    passed = [abs(float(series[name][row])) for name in ("work", "lost_viscous", "lost_sliding", "lost_rolling", "lost_drag")]
    held = sum(np.abs(series[name][: row + 1]) for name in ("kinetic", "elastic", "tangential", "rolling", "adhesive"))
    return max(*passed, float(np.max(held)))


def _numerics(scene: Packing, series: dict[str, Any]) -> dict[str, Any]:
    """How well the run was resolved: steps per stiffest period, largest overlap, steps in the tail at the fastest approach;
    how fast the cell was strained.

    Overlap and approach are those of every step; of runs of version 0.2, which did not watch them, of the rows of the time
    series, a lower bound (``watched``: "every step" or "rows").  ``largest_strain_rate`` |d ln L/dt| [1/T0] and
    ``largest_wall_speed`` |dL/dt| [a/T0] are means between two rows.
    """
    step, law = scene.step_choice.step, scene.law_in_units
    watched = "every step" if "largest_overlap" in series and scene.exact else "rows"
    overlap = approach = longest = 0.0
    if series and watched == "every step":
        overlap, approach, longest = (float(series[f"largest_{of}"][-1]) for of in ("overlap", "approach", "advance"))
    elif series:
        overlap, approach = float(series["overlap"].max()), float(series["approach"].max())
        steps = {number: scene.step_of(stage).step for number, stage in scene.stages.items()}
        longest = float(max(series["approach"] * [steps[int(number)] for number in series["stage"]]))
    return {
        "step": step,
        "step_reason": scene.step_choice.reason,
        "steps_per_stiffest_period": scene.step_choice.period / step,
        "share_of_stability_limit": step / scene.step_choice.limit,
        "watched": watched,
        "largest_overlap": known(overlap),
        "largest_overlap_of_smallest_radius": known(2.0 * overlap / scene.smallest),
        "fastest_approach": known(approach),
        "largest_strain_rate": _fastest(series, np.log) if series else 0.0,
        "largest_wall_speed": _fastest(series, np.asarray) if series else 0.0,
        "steps_in_tail": law.d0 / longest if law.f0 > 0 and longest > 0 else None,
    }


def known(value: float) -> float | None:
    """``value``, None for what the law or the barostat does not tell."""
    return None if np.isnan(value) else value


def _fastest(series: Mapping[str, Floats], of: Callable[[Any], Floats]) -> float:
    """Largest |d of(L)/dt| of the two lengths of the cell, mean between two rows of the time series."""
    lengths = of(np.array([series["length_x"], series["length_y"]]))
    time = np.diff(series["time"])
    moved = time > 0  # the row of a stage's end may be written twice
    return float(np.abs(np.diff(lengths)[:, moved] / time[moved]).max(initial=0.0))


def relaxation(before: Frame, after: Frame) -> dict[str, Any]:
    """What a settling stage changed, between the last frame before it and its own: contacts that it found or lost."""
    pairs = [_pairs_in_contact(frame) for frame in (before, after)]
    common = len(np.intersect1d(pairs[0], pairs[1], assume_unique=True))
    return {
        "time": after.time - before.time,
        "contacts_opened": len(pairs[0]) - common,
        "contacts_closed": len(pairs[1]) - common,
        "solid_fraction_change": float((before.area / after.area - 1.0) * solid_fraction(before)),
    }


def _pairs_in_contact(frame: Frame) -> np.ndarray:
    """The pairs of ids that touch, each as one complex number: pairs that arrays can be searched for."""
    table: Interactions = frame.interactions.select(frame.interactions.in_contact)
    return frame.ids[table.i] + 1j * frame.ids[table.j]

"""What a running scene says of itself, from its time series: one line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from workflow.data.frame import Floats

if TYPE_CHECKING:
    from workflow.scene.packing import Packing


def of_packing(series: Mapping[str, Floats], scene: Packing, seconds: float | None) -> str:
    """One line: stage, time, solid fraction, pressure, unbalanced force, time left."""
    last = {name: float(values[-1]) for name, values in series.items()}
    pressure = 0.5 * (last["stress_x"] + last["stress_y"])
    parts = last.get("aggregates", 1.0) if scene.cohesion else 1.0
    # how long the last aggregates take to meet cannot be read from forces
    left = time_left(series, scene, seconds) if seconds is not None and parts <= 1.0 else None
    return (
        f"{scene.stages.get(int(last['stage']), '?'):9s} t {last['time']:8.2f}  Phi {last['solid_fraction']:.4f}  "
        f"z {last['coordination']:.2f}  P {pressure:9.3g}  unbalanced {last['net_force']:.1e}"
        + (f"  aggregates {parts:.0f}, largest {last['largest_aggregate']:.0f}" if parts > 1 else "")
        + (f"  left {left}" if left else "")
    )


def of_heap(series: Mapping[str, Floats], grains: int, floor: float, seconds: float | None) -> str:
    """One line: time, grains poured and gone, height above the ``floor``; time left until the feed ends, at a cost that grows
    with the heap."""
    last = {name: float(values[-1]) for name, values in series.items()}
    done = last["poured"] / max(grains, 1)
    left = seconds * (1.0 / done**2 - 1.0) if seconds and done > 0.05 else 0.0
    return (
        f"pour     t {last['time']:8.2f}  grains {last['poured']:.0f} of {grains}  gone {last['removed']:.0f}  "
        f"top {last['top'] - floor:6.2f}  unbalanced {last['net_force']:.1e}" + (f"  left ~{left:.0f} s" if left else "")
    )


def time_left(series: Mapping[str, Floats], scene: Packing, seconds: float) -> str | None:
    """Wall time until the unbalanced force reaches its tolerance, if it goes on falling as it did over the last half of
    the run (a straight line through its logarithm); None while it does not fall."""
    time, force = series["time"], series["net_force"]
    tail = slice(len(time) // 2, None)
    good = force[tail] > 0
    if good.sum() < 5:
        return None
    slope, intercept = np.polyfit(time[tail][good], np.log(force[tail][good]), 1)
    if slope >= 0:
        return None
    target = scene.force_tolerance * scene.force_unit
    end = (np.log(target) - intercept) / slope
    remaining = max(end - time[-1], scene.hold_time)
    wall = seconds / max(time[-1] - time[0], 1e-30) * remaining
    return f"~{wall:.0f} s" if wall < 120 else f"~{wall / 60:.0f} min" if wall < 7200 else f"~{wall / 3600:.1f} h"

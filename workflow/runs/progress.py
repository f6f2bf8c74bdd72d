"""Live progress of a run: one rewritten line on a terminal, plain lines elsewhere."""

from __future__ import annotations

import time
from typing import TextIO

import numpy as np

from workflow.errors import WorkflowError
from workflow.runs.directory import RunDirectory
from workflow.scene.heap import FLOOR, Heap
from workflow.scene.registry import Packed, Scene

PLAIN_INTERVAL = 10.0  # seconds between lines where output is not a terminal
LINE_INTERVAL = 1.0


class Progress:
    """Reads the time series of a running directory and says where it stands."""

    def __init__(self, directory: RunDirectory, out: TextIO) -> None:
        self.directory, self.out = directory, out
        self.terminal = out.isatty()
        self.scene = directory.scene
        self.begun = self.shown = time.monotonic()
        self.line = ""

    def show(self) -> None:
        """Print the present state if it is time to."""
        now = time.monotonic()
        if now - self.shown < (LINE_INTERVAL if self.terminal else PLAIN_INTERVAL):
            return
        self.shown = now
        try:
            series = self.directory.series()
        except WorkflowError:  # caught in the middle of a write
            return
        if series is None:
            return
        line = describe(series, self.scene, now - self.begun)
        if self.terminal:
            self.out.write("\r" + line.ljust(len(self.line)))
        elif line != self.line:
            self.out.write(line + "\n")
        self.out.flush()
        self.line = line

    def end(self) -> None:
        """Leave the terminal's line."""
        if self.terminal and self.line:
            self.out.write("\n")


def describe(series: dict[str, np.ndarray], scene: Scene, seconds: float | None) -> str:
    """One line: stage, time, solid fraction, pressure, unbalanced force, time left."""
    last = {name: float(values[-1]) for name, values in series.items()}
    if isinstance(scene, Heap):
        return describe_heap(last, scene, seconds)
    pressure = 0.5 * (last["stress_x"] + last["stress_y"])
    parts = 1.0 if not scene.cohesion else last.get("aggregates", 1.0)
    # how long the last aggregates take to meet cannot be read from forces
    left = time_left(series, scene, seconds) if seconds is not None and parts <= 1.0 else None
    return (
        f"{scene.stages.get(int(last['stage']), '?'):9s} t {last['time']:8.2f}  Phi {last['solid_fraction']:.4f}  "
        f"z {last['coordination']:.2f}  P {pressure:9.3g}  unbalanced {last['net_force']:.1e}"
        + (f"  aggregates {parts:.0f}, largest {last['largest_aggregate']:.0f}" if parts > 1 else "")
        + (f"  left {left}" if left else "")
    )


def describe_heap(last: dict[str, float], scene: Heap, seconds: float | None) -> str:
    """One line: time, grains poured and gone, height; time left until the feed ends, at a cost that grows with the heap."""
    done = last["poured"] / max(scene.grains, 1)
    left = seconds * (1.0 / done**2 - 1.0) if seconds and done > 0.05 else 0.0
    return (
        f"pour     t {last['time']:8.2f}  grains {last['poured']:.0f} of {scene.grains}  gone {last['removed']:.0f}  "
        f"top {last['top'] - FLOOR:6.2f}  unbalanced {last['net_force']:.1e}" + (f"  left ~{left:.0f} s" if left else "")
    )


def time_left(series: dict[str, np.ndarray], scene: Packed, seconds: float) -> str | None:
    """Wall time until the unbalanced force reaches its tolerance, if it goes on falling as it did over the last half of
    the run (a straight line through its logarithm); None while it does not fall."""
    time_, force = series["time"], series["net_force"]
    tail = slice(len(time_) // 2, None)
    good = force[tail] > 0
    if good.sum() < 5:
        return None
    slope, intercept = np.polyfit(time_[tail][good], np.log(force[tail][good]), 1)
    if slope >= 0:
        return None
    target = scene.force_tolerance * scene.force_unit
    end = (np.log(target) - intercept) / slope
    remaining = max(end - time_[-1], scene.hold_time)
    wall = seconds / max(time_[-1] - time_[0], 1e-30) * remaining
    return f"~{wall:.0f} s" if wall < 120 else f"~{wall / 60:.0f} min" if wall < 7200 else f"~{wall / 3600:.1f} h"

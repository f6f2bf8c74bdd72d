"""Live progress of a run: one rewritten line on a terminal, plain lines elsewhere."""

from __future__ import annotations

import shutil
import time
from collections import deque
from typing import TextIO

from workflow.data.frame import Floats
from workflow.errors import WorkflowError
from workflow.runs.directory import RunDirectory
from workflow.scene.base import Scene
from workflow.scene.progress import of_stage, words

PLAIN_INTERVAL = 10.0  # seconds between lines where output is not a terminal
LINE_INTERVAL = 1.0
PACE = 30  # looks over which seconds per step are averaged


def steps_left(scene: Scene, series: dict[str, Floats]) -> float | None:
    """Steps that the present stage still takes, at the cost that a step has now; None: unknown."""
    rows = of_stage(series)
    stage = scene.stages.get(int(rows["stage"][-1]))
    passed = rows["time"][-1] - rows["time"][0]
    try:
        left = scene.time_left(rows, stage) if stage and passed > 0 else None
    except KeyError:  # a column that the deck does not write
        left = None
    return None if left is None else left * (rows["step"][-1] - rows["step"][0]) / passed * scene.cost_left(rows)


class Progress:
    """Reads the time series of a running directory and says where it stands."""

    def __init__(self, directory: RunDirectory, out: TextIO) -> None:
        self.directory, self.out = directory, out
        self.terminal = out.isatty()
        self.scene = directory.scene
        self.shown = time.monotonic()
        self.line = ""
        self.looks: deque[tuple[float, float]] = deque(maxlen=PACE)  # seconds, step

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
        self.looks.append((now, float(series["step"][-1])))
        line = self.scene.progress_line(series, words(self._seconds_left(series)))
        if self.terminal:
            line = line[: shutil.get_terminal_size().columns - 1]
            self.out.write("\r" + line.ljust(len(self.line)))
        elif line != self.line:
            self.out.write(line + "\n")
        self.out.flush()
        self.line = line

    def _seconds_left(self, series: dict[str, Floats]) -> float | None:
        """Of the present stage, at the pace of the last looks; None: unknown."""
        (began, first), (now, last) = self.looks[0], self.looks[-1]
        left = steps_left(self.scene, series) if last > first else None
        return None if left is None else left * (now - began) / (last - first)

    def end(self) -> None:
        """Leave the rewritten line behind."""
        if self.terminal and self.line:
            self.out.write("\n")
            self.out.flush()

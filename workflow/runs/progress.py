"""Live progress of a run: one rewritten line on a terminal, plain lines elsewhere."""

from __future__ import annotations

import time
from typing import TextIO

from workflow.errors import WorkflowError
from workflow.runs.directory import RunDirectory

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
        line = self.scene.progress_line(series, now - self.begun)
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

"""Progress of a study: what is done, what is left, in one rewritten line."""

from __future__ import annotations

import shutil
import time
from typing import TextIO

INTERVAL = 10.0  # seconds between lines where output is not a terminal


class Meter:
    """Counts work off a known total; time left is what is left at the pace so far."""

    def __init__(self, total: float, out: TextIO) -> None:
        self.total, self.out, self.done = total, out, 0.0
        self.begun = time.monotonic()
        self.shown = self.begun if not out.isatty() else 0.0

    def add(self, work: float, what: str) -> None:
        """``work`` of the total was done."""
        self.done += work
        now = time.monotonic()
        terminal = self.out.isatty()
        if now - self.shown < (0.2 if terminal else INTERVAL):
            return
        self.shown = now
        left = (now - self.begun) * (self.total / self.done - 1.0)
        line = f"{100.0 * self.done / self.total:3.0f} %  left ~{left:.0f} s  {what}"
        width = shutil.get_terminal_size().columns - 1
        self.out.write(f"\r{line[:width]:{width}s}" if terminal else line + "\n")
        self.out.flush()

    def end(self) -> None:
        """Leave the terminal's line."""
        if self.out.isatty():
            self.out.write("\r" + " " * (shutil.get_terminal_size().columns - 1) + "\r")

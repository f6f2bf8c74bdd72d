"""Progress in a notebook: the lines that a terminal would show, rewritten in place in the output of the cell."""

from __future__ import annotations

import io
import sys
from typing import Any, TextIO


class CellOutput(io.TextIOBase):
    """A text stream whose text is shown in the output of a cell; a carriage return begins the last line anew.

    It says that it is a terminal, so that whoever shows progress rewrites its line.
    """

    def __init__(self, display: Any) -> None:
        """``display``: `IPython.display.display`."""
        self._display, self._handle = display, None
        self._lines = [""]

    def isatty(self) -> bool:
        return True

    def writable(self) -> bool:
        return True

    def write(self, text: str) -> int:
        for k, part in enumerate(text.split("\n")):
            if k:
                self._lines.append("")
            *before, last = part.split("\r")
            self._lines[-1] = last if before else self._lines[-1] + last
        return len(text)

    def flush(self) -> None:
        shown = {"text/plain": "\n".join(line.rstrip() for line in self._lines).rstrip()}
        if self._handle is None:
            self._handle = self._display(shown, raw=True, display_id=True)
        else:
            self._handle.update(shown, raw=True)


def progress_output() -> TextIO:
    """Where progress goes: the output of the cell in a notebook, else standard error."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if getattr(shell, "kernel", None) is None:
        return sys.stderr
    from IPython.display import display

    return CellOutput(display)  # type: ignore[return-value]  # all of TextIO that is used

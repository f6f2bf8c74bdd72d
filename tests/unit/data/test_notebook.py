"""Progress in the cell of a notebook: what a terminal would show after the same text."""

from __future__ import annotations

import sys
from types import SimpleNamespace
from typing import Any

import pytest

from workflow.data.notebook import CellOutput, progress_output


class Cell:
    """What IPython.display.display is to a cell: it shows one output, and can show it anew."""

    def __init__(self) -> None:
        self.shown: list[str] = []

    def __call__(self, data: dict[str, str], **_: Any) -> Cell:
        self.shown.append(data["text/plain"])
        return self

    def update(self, data: dict[str, str], **_: Any) -> None:
        self.shown[-1] = data["text/plain"]


def test_a_line_is_rewritten_and_whole_lines_stay() -> None:
    cell = Cell()
    out = CellOutput(cell)
    for text in ("\r 10 %", "\r 20 %  left 3 s", "\r       \rdone one\n", "\r 50 %", "\n"):
        out.write(text)
        out.flush()
    assert out.isatty() and cell.shown == ["done one\n 50 %"]


def test_progress_goes_to_standard_error_outside_a_notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: SimpleNamespace()))  # a shell in a terminal
    assert progress_output() is sys.stderr
    monkeypatch.delitem(sys.modules, "IPython")
    assert progress_output() is sys.stderr

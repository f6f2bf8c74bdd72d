"""Waiting in tests for what other programs do in their own time."""

from __future__ import annotations

import time
from collections.abc import Callable

PATIENCE = 300.0  # seconds for what must come in the end; how fast it is here is no matter of tests


def until(true: Callable[[], object], what: str) -> None:
    """Wait until it is."""
    deadline = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < deadline, f"not within {PATIENCE:.0f} s: {what}"
        time.sleep(0.2)

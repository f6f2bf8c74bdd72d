"""Interrupts that wait: what must not be left half done is done first."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread


@contextmanager
def deferred_interrupts() -> Iterator[None]:
    """A block after which, not within which, SIGINT and SIGTERM are handled; those that nobody handles stay as they are.

    Python raises KeyboardInterrupt between any two instructions of the main thread: counts and hashes that belong
    together would come apart.
    """
    if current_thread() is not main_thread():  # no interrupt reaches it
        yield
        return
    seen: list[int] = []
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    handled = {number: handler for number, handler in handlers.items() if callable(handler)}
    for number in handled:
        signal.signal(number, lambda number, frame: seen.append(number))
    try:
        yield
    finally:
        for number, handler in handled.items():
            signal.signal(number, handler)
        for first in seen[:1]:
            handled[signal.Signals(first)](first, None)

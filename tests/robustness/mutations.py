"""Damage, as disks, editors, half-finished copies and strangers do it, and a deadline for those who read it."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from types import FrameType
from typing import Any

from hypothesis import strategies as st

DEADLINE = 20.0  # seconds that no reader may take for files of a few kilobytes; it takes milliseconds
SENTINEL = "pwned"  # a file that appears if anything in a data file is ever executed
WORDS = [
    "nan", "inf", "-inf", "1e308", "1e400", "-1", "0", "0.5", "", "x", "é", "\0", "9" * 25, "1" * 5000, "true", "null", "[]",
    "{}", "[" * 3000, f"__import__('os').system('touch {SENTINEL}')", f"$(touch {SENTINEL})", f"`touch {SENTINEL}`",
    f"\nshell touch {SENTINEL}\n", f"!!python/object/apply:os.system ['touch {SENTINEL}']",
]  # fmt: skip
VALUES: list[Any] = [None, -1, 0, 1, 1e308, float("nan"), 10**400, "x", "", "../x", [], {}, True, [None], {"a": 1}, *WORDS[-5:]]


class Damaged(bytes):
    """Bytes that a report of a failure shows by their size; the example itself can be drawn again."""

    def __repr__(self) -> str:
        return f"<{len(self)} bytes>"


@st.composite
def flipped(draw: st.DrawFn, data: bytes) -> bytes:
    """Some bits changed, or the end cut off, or bytes put in between."""
    place = st.integers(0, len(data) - 1)
    kind = draw(st.sampled_from(["bit", "bits", "cut", "between"]))
    if kind == "cut":
        return Damaged(data[: draw(place)])
    if kind == "between":
        at = draw(place)
        return Damaged(data[:at] + draw(st.binary(min_size=1, max_size=40)) + data[at:])
    changed = bytearray(data)
    for at in draw(st.lists(place, min_size=1, max_size=1 if kind == "bit" else 20)):
        changed[at] ^= 1 << draw(st.integers(0, 7))
    return Damaged(changed)


@st.composite
def edited(draw: st.DrawFn, data: bytes) -> bytes:
    """A text with words replaced, lines exchanged, doubled or gone, or damaged as any file."""
    kind = draw(st.sampled_from(["word", "word", "swap", "double", "gone", "flipped"]))
    if kind == "flipped":
        return draw(flipped(data))
    lines = data.split(b"\n")
    one, two = (draw(st.integers(0, len(lines) - 1)) for _ in range(2))
    if kind == "word":
        words = lines[one].split(b" ")
        words[draw(st.integers(0, len(words) - 1))] = draw(st.sampled_from(WORDS)).encode()
        lines[one] = b" ".join(words)
    elif kind == "swap":
        lines[one], lines[two] = lines[two], lines[one]
    elif kind == "double":
        lines.insert(one, lines[two])
    else:
        del lines[one]
    return Damaged(b"\n".join(lines))


def paths(tree: Any, above: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Where the values of a JSON document are."""
    below = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    return [above, *(path for name, value in below for path in paths(value, (*above, name)))]


@st.composite
def replaced(draw: st.DrawFn, document: Any) -> Any:
    """A JSON document in which one value is another, or is missing."""
    path = draw(st.sampled_from(paths(document)))
    if not path:
        return draw(st.sampled_from(VALUES))
    place = document
    for name in path[:-1]:
        place = place[name]
    if isinstance(place, dict) and draw(st.booleans()):
        del place[path[-1]]
    else:
        place[path[-1]] = draw(st.sampled_from(VALUES))
    return document


@contextlib.contextmanager
def deadline() -> Iterator[None]:
    """A hang is a failure, not the end of the tests."""

    def late(number: int, frame: FrameType | None) -> None:
        raise AssertionError(f"no answer within {DEADLINE:g} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, DEADLINE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)

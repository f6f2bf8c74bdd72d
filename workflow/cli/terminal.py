"""What goes to a terminal: data cannot steer it, and no text is too odd to be shown."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO

# all control characters but the ends of lines, which the progress line needs too
CONTROL = {code: f"\\x{code:02x}" for code in (*range(0x20), *range(0x7F, 0xA0)) if chr(code) not in "\t\n\r"}
CONTROL |= {code: f"\\u{code:04x}" for code in (0x2028, 0x2029, *range(0x202A, 0x202F), *range(0x2066, 0x206A))}


class Escaping:
    """A text stream that writes control characters, and what its encoding has not, as escapes; else the stream itself."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        encoding = getattr(self._stream, "encoding", None) or "utf-8"
        plain = text.translate(CONTROL).encode(encoding, "backslashreplace").decode(encoding)
        self._stream.write(plain)
        return len(text)

    def writelines(self, lines: Any) -> None:
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def overwrite(text: str) -> None:
    """Show ``text`` on a line of the terminal that the next one overwrites; nothing elsewhere, and "" clears it."""
    if sys.stderr.isatty():
        shown = text[: shutil.get_terminal_size().columns - 1]
        sys.stderr.write("\r" + shown.ljust(40) + ("" if text else "\r"))
        sys.stderr.flush()


@contextmanager
def escaped_output() -> Iterator[None]:
    """Standard output and error escape what is written to them."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = Escaping(before[0]), Escaping(before[1])
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before

"""What is to be said of data beside the result."""

from __future__ import annotations

import sys
from collections.abc import Iterable


def tell(notes: Iterable[str]) -> None:
    """Print notes about a source on standard error."""
    for note in notes:
        print(f"wf: note: {note}", file=sys.stderr)

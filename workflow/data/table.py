"""Rows of dataclasses as CSV."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from workflow.data.cells import named_cells
from workflow.data.files import atomic_write


def write_csv(path: Path, rows: Sequence[Any]) -> None:
    """Write dataclass instances of one kind, one line each; the file appears as a whole."""
    with atomic_write(path) as draft, open(draft, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(asdict(rows[0])))
        writer.writeheader()
        writer.writerows(named_cells(asdict(row)) for row in rows)

"""What a run of several ranks is free in that was continued: its ranks hold other grains than before.

Then what they lost is added in another order, and contacts are listed in another order; all else is the same to the last bit.
"""

from __future__ import annotations

import numpy as np

from workflow.analysis.frame import Floats
from workflow.archive.dumps import CONTACT_COLUMNS, TURNING

SUMS = ("lost_viscous", "lost_sliding", "lost_rolling", "lost_drag", "work", "energy_in", "energy_out", "residual")
LAST_DIGITS = 1e-12  # of the largest of the sums; 6e-15 was found
FREE = f"the order of contacts, and the last digit of {', '.join(SUMS)}"


def ungrouped(table: Floats, kind: str | None) -> Floats:
    """The rows of a contact table (kind ENTRIES) in the order of their grains, smaller id first; other tables as they are."""
    if kind != "ENTRIES" or table.shape[1] != len(CONTACT_COLUMNS):
        return table
    swap = table[:, 0] > table[:, 1]
    turned = table.copy()
    turned[swap, :2] = table[swap, 1::-1]
    turned[np.ix_(np.flatnonzero(swap), np.array(TURNING))] *= -1.0
    return turned[np.lexsort((turned[:, 1], turned[:, 0]))]


def last_digits(columns: tuple[str, ...], old: Floats, new: Floats) -> np.ndarray:
    """Where a row of a series, (1, columns), differs only as a sum in another order does."""
    sums = np.array([name in SUMS for name in columns])
    scale = float(np.abs(old[:, sums]).max(initial=0.0))
    return sums & (np.abs(old - new) <= LAST_DIGITS * scale)

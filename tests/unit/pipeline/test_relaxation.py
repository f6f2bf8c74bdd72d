"""What a settling stage changed between two frames."""

from __future__ import annotations

import numpy as np

from workflow.data.build import make_frame
from workflow.pipeline.packing import relaxation


def test_opened_and_closed_contacts_are_counted_by_the_ids_of_their_grains() -> None:
    """Four grains in a row: one contact stays, one opens, one closes; ids beyond 2^31 are told apart."""
    ids = np.array([3, 10, 2**31 + 1, 2**31 + 2])
    row = np.column_stack((np.array([0.0, 0.999, 1.998, 3.2]), np.zeros(4)))
    before = make_frame(row, 1.0, (10.0, 10.0), ids=ids, time=1.0)
    after = make_frame(row + np.array([[0.0, 0.0], [0.0, 0.0], [0.3, 0.0], [0.09, 0.0]]), 1.0, (10.0, 9.9), ids=ids, time=4.0)
    change = relaxation(before, after)
    assert (change["contacts_opened"], change["contacts_closed"]) == (1, 1)
    assert change["time"] == 3.0
    assert change["solid_fraction_change"] > 0.0
    assert {name: relaxation(after, after)[name] for name in ("contacts_opened", "contacts_closed", "time")} == {
        "contacts_opened": 0, "contacts_closed": 0, "time": 0.0,
    }  # fmt: skip

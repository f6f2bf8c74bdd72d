"""What all tests of functions share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from workflow.scene import placement


@pytest.fixture(scope="module", autouse=True)
def product_proposals() -> Iterator[int]:
    """Placement tries 40 000 points a round, right for many discs, but what a unit test with few would spend its time on.  Here
    they are 4000, since what holds must hold for any number; the value is that of the product, for tests of its bits."""
    product = placement._PROPOSALS
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(placement, "_PROPOSALS", 4000)
        yield product

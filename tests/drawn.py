"""How many examples hypothesis draws, and which."""

from __future__ import annotations

import os
from datetime import timedelta
from typing import Any

from hypothesis import HealthCheck, settings

TIMES = int(os.environ.get("WORKFLOW_FUZZ", "0"))


def examples(count: int, deadline: timedelta | None = None) -> Any:
    """So many examples, the same each time, so that what fails fails again; with WORKFLOW_FUZZ=K, K times as many at random."""
    return settings(
        max_examples=count * max(TIMES, 1), derandomize=not TIMES, deadline=deadline, database=None,
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip

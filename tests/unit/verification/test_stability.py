"""Verdicts of single trials, and that the list covers what it should."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from workflow.scene.heap import Heap
from workflow.verification.one_run import VARIANTS
from workflow.verification.pages import write_stability
from workflow.verification.stability import (
    INACCURATE,
    REFUSED,
    STABLE,
    UNSTABLE,
    Setting,
    Trial,
    Verdict,
    beyond,
    given,
    judge,
    packing,
    poured,
)

SMALL = {"n": 20, "cohesion": False, "kappa": 1e3}


@pytest.mark.engine
@pytest.mark.parametrize(
    ("verdict", "words", "setting"),
    [
        (STABLE, "residual", packing(**{**SMALL, "kappa": 1e4}, zeta=0.1)),
        (INACCURATE, "overlap", packing(**{**SMALL, "kappa": 100.0})),
        (UNSTABLE, "", beyond(2.0, n=20, zeta=0.0, mu=0.0, kappa=1e3)),
        (REFUSED, "zeta = 3", packing(zeta=3.0)),
        (REFUSED, "one centre", given([1.0, 1.0], [[5.0, 5.0], [5.0, 5.0]])),
        (REFUSED, "cell length", given([1.0], [[0.5, 0.5]], 1.0)),
        (STABLE, "no contact", given([1.0], [[5.0, 5.0]])),
        (STABLE, "residual", poured(index=300, cutoff=1.02)),
        (REFUSED, "index = 2", poured(index=2.0)),
        (REFUSED, "step = ", poured(steps_per_period=5.0)),
    ],
)
def test_verdict_follows_residual_overlap_and_refusal(verdict: str, words: str, setting: Callable[[], Setting | Heap]) -> None:
    found = judge(Trial("case", 0.0, setting), VARIANTS[0], 20_000)
    assert found.verdict == verdict, found
    assert words in found.reason


def test_map_and_page_hold_every_case(tmp_path: Path) -> None:
    rows = [Verdict("kappa", 10.0 * k, "exact", name, "why") for k, name in enumerate((STABLE, INACCURATE, UNSTABLE, REFUSED))]
    write_stability(tmp_path, rows, "wf stability")
    assert (tmp_path / "stability.csv").read_text().count("\n") == 5
    assert (tmp_path / "stability.png").stat().st_size > 1000
    assert "data:image/png;base64," in (tmp_path / "stability.html").read_text()

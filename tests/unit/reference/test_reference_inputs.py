"""Refusals: every message names the thing, its value and what to do."""

import math
import re
from collections.abc import Callable

import numpy as np
import pytest

from workflow.errors import InputError, WorkflowError
from workflow.reference.cohesive import CohesiveLaw, Motion
from workflow.reference.discs import Cell, Discs, Floats, Ints
from workflow.reference.integrate import integrate


def two(**changes: object) -> Discs:
    """Two unit discs 1e-3 apart, closing."""
    values: dict[str, object] = {
        "position": [[0.0, 0.0], [1.001, 0.0]],
        "velocity": [[0.1, 0.0], [-0.1, 0.0]],
        "omega": [0.0, 0.0],
        "diameter": [1.0, 1.0],
    }
    return Discs(**(values | changes))  # type: ignore[arg-type]


LAW = CohesiveLaw(kn=1e4, kt=1e4, mu=0.3)
CASES: list[tuple[Callable[[], object], str]] = [
    (lambda: CohesiveLaw(kn=0.0), "'kn' is 0.0; it must be > 0 and finite"),
    (lambda: CohesiveLaw(kn=1.0, zeta=-0.1), "'zeta' is -0.1; it must be >= 0 and finite"),
    (lambda: CohesiveLaw(kn=1.0, mu=math.nan), "'mu' is nan; it must be >= 0;"),
    (lambda: CohesiveLaw(kn=1.0, kr=math.inf), "'kr' is inf"),
    (lambda: two(diameter=[1.0]), "'diameter' has 1 values; the reference takes 2 to 6"),
    (lambda: two(omega=[0.0, 0.0, 0.0]), "'omega' has shape (3,); it must be (2,)"),
    (lambda: two(velocity=[[0.0, 0.0], [0.0, math.inf]]), "'velocity' is [[0.0, 0.0], [0.0, inf]]"),
    (lambda: two(diameter=[1.0, -1.0]), "'diameter' is [ 1. -1.]; it must be > 0"),
    (lambda: two(mass=[1.0, 0.0]), "'mass' is [1. 0.]; it must be > 0"),
    (lambda: two(position=[[0.0, 0.0], [0.0, 0.0]]), "coinciding centres"),
    (lambda: Cell(np.array([1.0])), "'lengths' has shape (1,)"),
    (lambda: integrate(LAW, two(), 0.0), "'t_end' is 0.0"),
    (lambda: integrate(LAW, two(), 1.0, t_eval=[0.5, 0.2]), "'t_eval' must increase within [0, 1]"),
    (lambda: integrate(LAW, two(), 1.0, t_eval=[2.0]), "'t_eval' must increase within [0, 1]"),
    (lambda: integrate(LAW, two(), 1.0, rtol=1e-16), "'rtol' is 1e-16"),
    (lambda: integrate(LAW, two(), 1.0, cell=Cell(np.array([1.9, 3.0]))), "twice the range 1 of a pair"),
    (lambda: integrate(LAW, two(), 9.0, cell=Cell(np.array([3.0, 3.0]), (0.1, 0.0))), "lower the rate"),
    (
        lambda: integrate(LAW, two(position=[[0.0, 0.0], [0.999, 0.0]], xi_t=[1.0]), 1.0),
        "'xi_t' of pair 0 is 1; the law allows at most 0.0003",
    ),
]


@pytest.mark.parametrize(("call", "message"), CASES, ids=[message for _, message in CASES])
def test_values_out_of_range_are_refused(call: Callable[[], object], message: str) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        call()


def test_events_that_do_not_advance_are_reported() -> None:
    class Stubborn(CohesiveLaw):
        """Ignores that its contact has closed, so the same trigger fires for ever."""

        def switch(self, row: int, pair: int, motion: Motion, memory: Floats, modes: Ints) -> tuple[Floats, Ints, str]:
            return memory, modes, "close"

    with pytest.raises(WorkflowError, match="the last 'close' of discs 0 and 1; at most 100 at one instant"):
        integrate(Stubborn(kn=1e4), two(), 1.0)


def test_state_is_copied_and_read_only() -> None:
    position = np.array([[0.0, 0.0], [1.5, 0.0]])
    discs = two(position=position)
    position[1, 0] = 0.0
    assert discs.position[1, 0] == 1.5
    with pytest.raises(ValueError, match="read-only"):
        discs.position[1, 0] = 0.0


def test_discs_at_rest_stay_at_rest() -> None:
    run = integrate(LAW, two(velocity=np.zeros((2, 2))), 10.0, t_eval=[0.0, 3.0, 10.0])
    assert run.events == ()
    assert np.all(run.position == run.position[0])
    assert run.energy.residual.tolist() == [0.0, 0.0, 0.0]
